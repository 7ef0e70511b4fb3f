"""Ackermann steering: from a speed and a curvature to hinge angles and wheel speeds. No ROS.

Frames follow REP-103: x forward, y left, positive turns to the left.
"""

from __future__ import annotations

import math
from typing import NamedTuple


class Wheels(NamedTuple):
    """Hinge angles [rad, left positive] and rolling speeds [rad/s, forward positive]."""

    left_steering: float = 0.0
    right_steering: float = 0.0
    left_rear: float = 0.0
    right_rear: float = 0.0
    left_front: float = 0.0
    right_front: float = 0.0


def steering(speed: float, yaw_rate: float, wheelbase: float) -> float:
    """Returns the steering angle of the equivalent bicycle [rad], left positive.

    tan(steering) = wheelbase * yaw_rate / speed (kinematic bicycle, no side slip at the rear axle).
    At speed 0 no steering angle causes a yaw rate, so it is 0.

    Args:
        speed: Of the rear axle's center [m/s]; negative is backwards.
        yaw_rate: Of the body [rad/s], left positive.
    """
    if speed == 0.0:
        return 0.0
    # atan2 with a positive second argument is atan of the quotient without overflow.
    return math.atan2(wheelbase * math.copysign(1.0, speed) * yaw_rate, abs(speed))


def wheels(
    speed: float, curvature: float, wheelbase: float, radius: float, front: float, rear: float
) -> Wheels:
    """Returns what four wheels do that have a common turning center.

    With the curvature k it is on the rear axle's line at y = 1/k. A hinge at y = h points across
    the line to it: tan(angle) = wheelbase k / (1 - k h). A wheel's speed grows with its distance.

    Args:
        speed: Of the rear axle's center [m/s].
        curvature: Of its path [1/m].
        wheelbase, radius: Rear to front axle, radius of the wheels [m].
        front, rear: From the center line to a hinge and its wheel, to a rear wheel [m].
    """
    across, spin = wheelbase * curvature, speed / radius
    left, right = 1.0 - curvature * front, 1.0 + curvature * front
    return Wheels(
        math.atan2(across, left),
        math.atan2(across, right),
        spin * (1.0 - curvature * rear),
        spin * (1.0 + curvature * rear),
        spin * math.hypot(across, left),
        spin * math.hypot(across, right),
    )
