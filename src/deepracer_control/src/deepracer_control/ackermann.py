"""Ackermann steering geometry: from a body twist to hinge angles and wheel speeds.

Pure functions, no ROS. Frames follow REP-103: x forward, y left, positive turns to the left.
"""

import math
from dataclasses import dataclass

from paddock_common.settings import check, number


@dataclass(frozen=True)
class Geometry:
    """Wheel positions of a car.

    Attributes:
        wheelbase: Rear axle to front axle [m].
        front_half_track: Car's center line to a steering hinge (and its wheel) [m].
        rear_half_track: Car's center line to a rear wheel's center [m].
        wheel_radius: Radius of all four wheels [m].
        max_steering: Largest angle of the equivalent bicycle's front wheel [rad].
    """

    wheelbase: float = number(0.164, above=0.0, unit="m")
    front_half_track: float = number(0.079601, above=0.0, unit="m")
    rear_half_track: float = number(0.08105, above=0.0, unit="m")
    wheel_radius: float = number(0.03, above=0.0, unit="m")
    max_steering: float = number(0.5236, above=0.0, unit="rad")

    def __post_init__(self):
        check(self)
        widest = max(self.front_half_track, self.rear_half_track)
        limit = math.atan(self.wheelbase / widest)
        if self.max_steering >= limit:
            raise ValueError(
                f"max_steering is {self.max_steering!r} rad; it must be above 0 and below "
                f"{limit:.4f} rad, where the turning center would be under a wheel"
            )


@dataclass(frozen=True)
class WheelCommands:
    """Hinge angles [rad, left positive] and wheel speeds [rad/s, forward positive]."""

    left_steering: float = 0.0
    right_steering: float = 0.0
    left_rear: float = 0.0
    right_rear: float = 0.0
    left_front: float = 0.0
    right_front: float = 0.0


def bicycle_steering(speed, yaw_rate, geometry):
    """Returns the steering angle of the equivalent bicycle, within the car's limit.

    tan(steering) = wheelbase * yaw_rate / speed (kinematic bicycle, no side slip at the rear axle).

    Args:
        speed: Forward speed of the rear axle's center [m/s]; negative is backwards.
        yaw_rate: Yaw rate of the body [rad/s], left positive.

    Returns:
        Angle [rad], left positive. At speed 0 no steering angle causes a yaw rate, so it is 0.
    """
    if speed == 0.0:
        return 0.0
    # atan2 with a positive second argument is atan of the quotient without overflow.
    angle = math.atan2(geometry.wheelbase * math.copysign(1.0, speed) * yaw_rate, abs(speed))
    return max(-geometry.max_steering, min(geometry.max_steering, angle))


def wheel_commands(speed, yaw_rate, geometry=Geometry()) -> WheelCommands:
    """Converts a body twist to hinge angles and wheel speeds with a common turning center.

    With curvature k = tan(steering) / wheelbase the turning center is on the rear axle's line at
    y = 1/k. A hinge at y = h points across the line to it: tan(angle) = wheelbase k / (1 - k h).
    A wheel's speed grows with its distance from the center. If the steering limit is reached,
    the speed is unchanged and the car turns with the limit.

    Args:
        speed: Forward speed of the rear axle's center [m/s].
        yaw_rate: Yaw rate [rad/s], left positive (REP-103).
    """
    curvature = math.tan(bicycle_steering(speed, yaw_rate, geometry)) / geometry.wheelbase
    across = geometry.wheelbase * curvature
    left_along = 1.0 - curvature * geometry.front_half_track
    right_along = 1.0 + curvature * geometry.front_half_track
    spin = speed / geometry.wheel_radius
    return WheelCommands(
        left_steering=math.atan2(across, left_along),
        right_steering=math.atan2(across, right_along),
        left_rear=spin * (1.0 - curvature * geometry.rear_half_track),
        right_rear=spin * (1.0 + curvature * geometry.rear_half_track),
        left_front=spin * math.hypot(across, left_along),
        right_front=spin * math.hypot(across, right_along),
    )
