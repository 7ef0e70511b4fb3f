"""Length of the shortest forward path to a point, to judge the controller's paths."""

import math

from cybertruck.goal.laws import circle_distance


def shortest_length(forward, left, radius):
    """Returns the length of the shortest forward path with bounded curvature to a point.

    One turn and a straight line to a point outside the turning circles, two opposite turns to one
    inside (Bui et al. 1994); the end heading is free.

    Args:
        forward: The point along the heading at the start [m].
        left: The point to the left [m].
        radius: Least turning radius [m].

    Returns:
        The length [m].
    """
    left = abs(left)  # the mirror image is as long
    outside = circle_distance(forward, left, radius, 1) >= radius
    return turn_and_line(forward, left, radius) if outside else turn_and_turn(forward, left, radius)


def turn_and_line(forward, left, radius):
    """Returns the length [m] of a turn to the left and its tangent to a point outside."""
    distance = circle_distance(forward, left, radius, 1)
    line = math.sqrt(max(distance * distance - radius * radius, 0.0))
    # the angle of the point as seen from the centre, less the one between point and tangent point
    seen = math.atan2(left - radius, forward) + math.pi / 2.0
    turn = (seen - math.atan2(line, radius)) % (2.0 * math.pi)
    if 2.0 * math.pi - turn < 1e-9:  # straight ahead
        turn = 0.0
    return radius * turn + line


def turn_and_turn(forward, left, radius):
    """Returns the length of a turn to the right and one to the left, to a point inside the left
    circle [m]."""
    # Turned right by a, the left circle's centre is c + 2 r (sin a, cos a) with c = (0, -r). The
    # point lies on that circle: with (dx, dy) = point - c, 4 r² + d² - 4 r (dx sin a + dy cos a) =
    # r².
    dx, dy = forward, left + radius
    square = dx * dx + dy * dy
    phase = math.atan2(dx, dy)
    swing = math.acos(
        min((3.0 * radius * radius + square) / (4.0 * radius * math.sqrt(square)), 1.0)
    )
    lengths = []
    for away in (phase - swing, phase + swing):
        away %= 2.0 * math.pi
        centre = (2.0 * radius * math.sin(away), 2.0 * radius * math.cos(away) - radius)
        to_point = math.atan2(left - centre[1], forward - centre[0])
        to_start = math.atan2(math.cos(away), math.sin(away)) + math.pi
        lengths.append(radius * (away + (to_point - to_start) % (2.0 * math.pi)))
    return min(lengths)
