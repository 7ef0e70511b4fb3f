"""Axes, stops and the tree of joints, as URDF and SDF both have them."""

import numpy as np

UNLIMITED = 1e9  # [rad, m] stands for no limit on one side


def unit_axis(vector, default, what, element):
    """A joint's axis with length 1; the default, with a warning, for one without direction.

    Args:
        vector: (3,).
        default: unit vector.
        what: for the message.
        element: Node that takes the warning.
    """
    length = float(np.linalg.norm(vector))
    if length >= 1e-9:
        return tuple((np.asarray(vector, float) / length).tolist())
    used = " ".join(f"{value:g}" for value in default)
    element.warn(
        f"{what} axis is zero, must have a direction; {used} is used",
        "joint axes are zero; the format's default is used",
        what,
    )
    return default


def set_stops(joint, lower, upper, what, element):
    """Set a joint's stops [rad, m], None for none; swapped ones stop nothing, as in ODE.

    Args:
        joint: Joint.
        lower, upper: the limits.
        what: for the message.
        element: Node that takes the warning.
    """
    if lower is None and upper is None:  # PyBullet has both or none
        return
    lower = -UNLIMITED if lower is None else lower
    upper = UNLIMITED if upper is None else upper
    if lower > upper:
        element.warn(
            f"{what} has lower limit {lower} above upper {upper}; it has no stops, as in Gazebo",
            "joints have a lower limit above the upper one and so no stops",
            what,
        )
        return
    joint.lower, joint.upper = lower, upper


def closes_loop(model, parent, child):
    """Whether a joint between two links would lead from a link back to itself."""
    above = {joint.child: joint.parent for joint in model.joints.values()}
    while parent is not None and parent != child:
        parent = above.get(parent)
    return parent == child
