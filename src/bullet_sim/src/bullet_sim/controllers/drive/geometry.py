"""Sizes of a base from the URDF, where its controller's configuration has none."""

from bullet_sim.errors import ControllerError
from bullet_sim.pose import Pose


def _joint(description, name):
    if description is None or name not in description.joints:
        raise ControllerError(f"joint '{name}' is not in the robot's description")
    return description.joints[name]


def joint_position(description, name):
    """Position (3,) [m] of a joint in the root link's frame, all joints at 0.

    Raises:
        ControllerError: no such joint.
    """
    pose, joint = Pose(), _joint(description, name)
    parents = {j.child: j for j in description.joints.values()}
    while joint is not None:
        pose = joint.origin * pose
        joint = parents.get(joint.parent)
    return pose.position


def wheel_radius(description, name):
    """Radius [m] of the cylinder or sphere with which a joint's child link collides.

    Raises:
        ControllerError: no such joint, or the link has neither.
    """
    link = description.links[_joint(description, name).child]
    for shape in link.collisions:
        if shape.geometry.kind in ("cylinder", "sphere"):
            return shape.geometry.size[0]
    raise ControllerError(
        f"link '{link.name}' has no cylinder or sphere as its collision to take it from"
    )
