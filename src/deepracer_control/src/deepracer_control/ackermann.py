"""Ackermann steering geometry: from a body twist to hinge angles and wheel speeds.

Pure functions, no ROS. Frames follow REP-103: x forward, y left, positive turns to the left.
"""

import math
from dataclasses import dataclass

from paddock_common.settings import check, number

from paddock_common import ackermann


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


def bicycle_steering(speed, yaw_rate, geometry):
    """Returns the steering angle of the equivalent bicycle, within the car's limit, see steering().

    Args:
        speed: Forward speed of the rear axle's center [m/s]; negative is backwards.
        yaw_rate: Yaw rate of the body [rad/s], left positive.
    """
    angle = ackermann.steering(speed, yaw_rate, geometry.wheelbase)
    return max(-geometry.max_steering, min(geometry.max_steering, angle))


def wheel_commands(speed, yaw_rate, geometry=Geometry()):
    """Converts a body twist to hinge angles and wheel speeds with a common turning center.

    If the steering limit is reached, the speed is unchanged and the car turns with the limit.

    Args:
        speed: Forward speed of the rear axle's center [m/s].
        yaw_rate: Yaw rate [rad/s], left positive (REP-103).

    Returns:
        paddock_common.ackermann.Wheels.
    """
    curvature = math.tan(bicycle_steering(speed, yaw_rate, geometry)) / geometry.wheelbase
    return ackermann.wheels(
        speed,
        curvature,
        geometry.wheelbase,
        geometry.wheel_radius,
        geometry.front_half_track,
        geometry.rear_half_track,
    )
