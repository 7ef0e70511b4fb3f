"""Geometry of a base whose four wheels are all driven and steered.

The wheels stand at the corners of a rectangle, each `offset` outside its steering axis. All turn
about one centre, so an axle's virtual middle wheel at the angle d with the speed v along it moves
as the body does: turn rate w = v cos(d) (tan(front) - tan(rear)) / wheel_base.
"""

import math

STOPPED = 1e-3  # [m/s] commands of less stand still
PARALLEL = 1e-2  # difference of the tangents of an axle's wheels below which they are parallel


def for_twist(config, forward, turn):
    """Wheels for a velocity of the body, both axles steering against each other.

    Args:
        config: FourWheelConfig.
        forward: [m/s].
        turn: to the left [rad/s].

    Returns:
        Speeds [rad/s] and steering angles [rad] of the wheels, each front left, front right, rear
        left, rear right.
    """
    across = turn * config.track / 2.0
    speeds, angles = [0.0, 0.0], [0.0, 0.0]
    if abs(forward) > STOPPED:
        speeds = _rims(config, forward, turn, config.wheel_base * turn / 2.0)
        angles = [math.copysign(math.pi / 2.0, turn)] * 2
    if abs(forward) > abs(across):
        angles = [
            math.atan(turn * config.wheel_base / 2.0 / (forward + side * across))
            for side in (-1.0, 1.0)
        ]
    return (*speeds, *speeds), (*angles, *(-angle for angle in angles))


def for_angles(config, speed, front, rear):
    """Wheels for a speed [m/s] and the steering angles [rad] of both axles' virtual middle wheels.

    Returns:
        As for_twist.
    """
    base = config.wheel_base
    tangents = [math.tan(min(max(a, -math.pi / 2), math.pi / 2)) for a in (front, rear)]
    spread = config.track * (tangents[0] - tangents[1]) / 2.0
    turn = speed * (tangents[0] - tangents[1]) / base
    angles, speeds = [], []
    for tangent in tangents:
        pair = [0.0, 0.0]
        if abs(base - abs(spread)) > STOPPED:
            pair = [math.atan(base * tangent / (base + side * spread)) for side in (-1.0, 1.0)]
        parallel = abs(math.tan(pair[0]) - math.tan(pair[1])) <= PARALLEL
        lateral = 0.0 if parallel else speed * tangent
        angles += pair
        speeds += _rims(config, speed, turn, lateral) if abs(speed) > STOPPED else (0.0, 0.0)
    return tuple(speeds), tuple(angles)


def _rims(config, forward, turn, lateral):
    """Speeds [rad/s] of the left and the right wheel of an axle that moves like this."""
    return [
        (
            math.copysign(math.hypot(forward + side * turn * config.track / 2.0, lateral), forward)
            + side * turn * config.offset
        )
        / config.radius
        for side in (-1.0, 1.0)
    ]


def middle_angle(left, right):
    """Angle [rad] of an axle's virtual middle wheel, from those of its two."""
    if abs(left) <= 1e-3 and abs(right) <= 1e-3:
        return 0.0
    total = math.tan(left) + math.tan(right)
    return math.atan(2.0 * math.tan(left) * math.tan(right) / total) if total else 0.0


def body_motion(config, speeds, front, rear):
    """Velocity of the body's middle from its wheels.

    Args:
        config: FourWheelConfig.
        speeds: of the wheels [rad/s], order as for_twist.
        front, rear: middle_angle of both axles [rad].

    Returns:
        Forward [m/s], to the left [m/s], turn to the left [rad/s]: the mean of both axles.
    """
    slope = (math.tan(front) - math.tan(rear)) / config.wheel_base
    forward = lateral = turn = 0.0
    for angle, left, right in ((front, *speeds[:2]), (rear, *speeds[2:])):
        along = _axle_speed(config, left, right, slope * math.cos(angle), math.cos(angle))
        forward += along * math.cos(angle) / 2.0
        lateral += along * math.sin(angle) / 2.0
        turn += along * slope * math.cos(angle) / 2.0
    return forward, lateral, turn


def _axle_speed(config, left, right, curvature, cosine):
    """Speed [m/s] along an axle's middle wheel: its wheels' distances from the centre are known."""
    half, squares, total = config.track * curvature / 2.0, 0.0, 0.0
    for side, rim in ((-1.0, left), (1.0, right)):
        distance = math.sqrt(max(1.0 + 2.0 * side * half * cosine + half**2, 1e-12))
        own = rim * config.radius / (1.0 + side * config.offset * curvature / distance)
        squares += own**2
        total += own
    return math.copysign(math.sqrt(squares / (2.0 + 2.0 * half**2)), total)
