"""Inertia that an effort of each joint has to move."""

import numpy as np

from bullet_sim.pose import Pose


def joint_inertias(lumped, fixed_base):
    """Inertia that an effort of each joint has to move, all joints at 0 and nothing touching.

    Args:
        lumped: LumpedModel.
        fixed_base: whether the root link is held by the world.

    Returns:
        Dict of joint name -> [kg m^2], of a prismatic joint [kg]: the reduced inertia of both
        sides, each as one rigid body.
    """
    frames = {lumped.root: Pose()}
    waiting = [*lumped.joints, *lumped.welds]
    while waiting:
        waiting, before = [], waiting
        for joint in before:
            if joint.parent in frames:
                frames[joint.child] = frames[joint.parent] * joint.origin
            else:
                waiting.append(joint)
    result = {}
    for joint in lumped.joints:
        beyond = _descendants(lumped, joint.child)
        frame = frames[joint.child]
        own, rest = (
            sum(_about(lumped.links[name], frames[name], joint, frame) for name in names)
            for names in (
                [name for name in lumped.links if name in beyond],  # in order: the same last bits
                [name for name in lumped.links if name not in beyond],
            )
        )
        result[joint.name] = own if fixed_base or not rest > 0 else own * rest / (own + rest)
    return result


def _descendants(lumped, link):
    found = {link}
    joints = (*lumped.joints, *lumped.welds)
    for _ in joints:
        found |= {joint.child for joint in joints if joint.parent in found}
    return found


def _about(link, pose, joint, frame):
    """Inertia of a link at a pose about a joint's axis, or its mass along it."""
    if joint.kind == "prismatic":
        return link.mass
    axis = frame.matrix @ np.asarray(joint.axis)
    arm = np.asarray(pose.position) + pose.matrix @ link.centre - np.asarray(frame.position)
    across = np.cross(axis, arm)
    turned = pose.matrix @ link.inertia @ pose.matrix.T
    return float(axis @ turned @ axis + link.mass * (across @ across))
