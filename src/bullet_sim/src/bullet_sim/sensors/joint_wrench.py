"""What a joint bears: force and torque between its links."""

import numpy as np

from bullet_sim.description.lump import WELD_AXIS


def joint_wrench(model, joint):
    """Force and torque of a joint's child link on its parent link.

    Args:
        model: of the world; the joint is among those that it measures.
        joint: its name.

    Returns:
        force (3,) [N], torque (3,) [N m] about the joint, along the child link's axes: what Gazebo
        calls the wrench on body 2.
    """
    force, torque, effort = model.engine.joint_load(model.body, model.measured[joint])
    limits = model.joints.limits.get(joint)
    axis = np.asarray(limits.axis if limits is not None else WELD_AXIS)
    if limits is not None:
        (effort,) = model.joints.columns([model.joints.names.index(joint)])[2]
    part = force if limits is not None and limits.kind == "prismatic" else torque
    part += (effort - part @ axis) * axis
    return -force, -torque


def net_wrench(mass, inertia, before, after, period):
    """Mean net force and torque on a rigid body over a period.

    Args:
        mass: [kg].
        inertia: (3, 3) [kg m^2] about its centre, world axes.
        before, after: (velocity of the centre (3,), turn rate (3,)), world axes.
        period: [s].

    Returns:
        force (3,) [N], torque (3,) [N m], world axes.
    """
    force = mass * (after[0] - before[0]) / period
    spin = inertia @ after[1]
    return force, inertia @ (after[1] - before[1]) / period + np.cross(after[1], spin)
