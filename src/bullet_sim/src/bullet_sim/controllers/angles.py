"""Differences of angles on the circle."""

import math

TOLERANCE = 1e-9  # [rad] by which rounding may put an angle beyond a limit


def shortest_distance(start, end):
    """The shortest turn [rad] from one angle to another, in (-pi, pi]."""
    return -math.remainder(start - end, 2.0 * math.pi)


def distance_within(start, end, lower, upper):
    """The shortest turn [rad] to an angle (up to whole turns) that stays within limits.

    Args:
        start: where the joint is [rad].
        end: where it shall go, within the limits [rad].
        lower, upper: limits [rad].

    Returns:
        The shorter way round if it ends within the limits, else the longer one if that does, else
        end - start.
    """
    short = shortest_distance(start, end)
    long = short - math.copysign(2.0 * math.pi, short)
    for turn in (short, long):
        if lower - TOLERANCE <= start + turn <= upper + TOLERANCE:
            return turn
    return end - start


def position_error(joint, position, target):
    """Error [rad, m] of a joint's position, as ros_control's position controllers see it.

    Args:
        joint: bullet_sim.description.parts.Joint.
        position, target: [rad, m]; a target beyond the joint's limits counts as the limit.
    """
    if joint.lower is not None:
        target = min(max(target, joint.lower), joint.upper)
    if joint.kind == "prismatic":
        return target - position
    if joint.lower is None:
        return shortest_distance(position, target)
    return distance_within(position, target, joint.lower, joint.upper)
