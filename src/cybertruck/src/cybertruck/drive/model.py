"""The truck's drive: geometry, limits, speeds and angles of wheels.

CyberModel: from the bicycle's steering angle and speed to four wheels, and back. No ROS. Frames
follow REP-103: x forward, y left, angles positive to the left. Curvature is that of the rear axle's
center; the center of rotation lies on the rear axle's line at y = 1 / curvature.
"""

import math
from dataclasses import dataclass

from paddock_common.settings import check, number

from paddock_common import ackermann


@dataclass(frozen=True)
class TruckGeometry:
    """Lengths and limits.

    Attributes:
        wheelbase: rear axle to front axle [m].
        track_width: between the centers of left and right wheel [m].
        wheel_radius: of all wheels [m].
        wheel_width: of all wheels [m].
        hitch_offset: L1, rear axle back to the hitch [m].
        tongue_length: L2, hitch back to the trailer's axle [m].
        max_steering: maximum angle of the bicycle's front wheel [rad].
        max_speed: of the rear axle's center, forward and backward [m/s].
        max_steering_rate: of the bicycle's angle [rad/s].
        max_acceleration: speeding up and braking [m/s^2].
    """

    wheelbase: float = number(0.508, above=0.0, unit="m")
    track_width: float = number(0.43, above=0.0, unit="m")
    wheel_radius: float = number(0.1016, above=0.0, unit="m")
    wheel_width: float = number(0.0762, above=0.0, unit="m")
    hitch_offset: float = number(0.30, above=0.0, unit="m")
    tongue_length: float = number(0.70, above=0.0, unit="m")
    max_steering: float = number(0.7854, above=0.0, unit="rad")
    max_speed: float = number(3.0, above=0.0, unit="m/s")
    max_steering_rate: float = number(2.5, above=0.0, unit="rad/s")
    max_acceleration: float = number(2.0, above=0.0, unit="m/s²")

    def __post_init__(self):
        check(self)
        limit = math.atan(2.0 * self.wheelbase / self.track_width)
        if self.max_steering >= limit:
            raise ValueError(
                f"max_steering is {self.max_steering!r}; it must be below {limit:.4f} "
                "rad, where the center of rotation would lie under a rear wheel"
            )


def towards(value, target, step):
    """`value` moved towards `target` by at most `step` (>= 0)."""
    return target if abs(target - value) <= step else value + math.copysign(step, target - value)


class RateLimiter:
    """The bicycle's steering angle and speed over time.

    Args:
        geometry: TruckGeometry, for max_steering_rate and max_acceleration.

    Attributes:
        steering: [rad] as commanded to the hinges now.
        speed: [m/s] as commanded to the rear wheels now.
    """

    def __init__(self, geometry):
        self._steering_rate = geometry.max_steering_rate
        self._acceleration = geometry.max_acceleration
        self.reset()

    def reset(self):
        """Reset to rest, wheels straight."""
        self.steering = self.speed = 0.0

    def advance(self, steering, speed, period):
        """Advance towards a target by one period.

        Args:
            steering, speed: target [rad], [m/s].
            period: [s], not negative.

        Returns:
            (steering [rad], speed [m/s]).
        """
        self.steering = towards(self.steering, steering, self._steering_rate * period)
        self.speed = towards(self.speed, speed, self._acceleration * period)
        return self.steering, self.speed


class CyberModel:
    """Kinematics without slip, within the truck's limits."""

    def __init__(self, geometry: TruckGeometry = TruckGeometry()):
        self.geometry = geometry

    def limit(self, steering, speed):
        """Steering angle [rad] and speed [m/s] within the limits."""
        shape = self.geometry
        return (
            max(-shape.max_steering, min(shape.max_steering, steering)),
            max(-shape.max_speed, min(shape.max_speed, speed)),
        )

    def from_twist(self, linear, angular):
        """Steering angle and speed for a twist: curvature = angular / linear.

        Args:
            linear: forward speed of the rear axle's center [m/s].
            angular: yaw rate [rad/s], left positive.

        Returns:
            (steering [rad], speed [m/s]), within the limits. Without speed no steering angle turns
            the truck, so it is 0. The speed limit does not change the curvature.
        """
        if linear == 0.0:
            return 0.0, 0.0
        return self.limit(ackermann.steering(linear, angular, self.geometry.wheelbase), linear)

    def rear_curvature(self, steering):
        """Curvature of the rear axle's center, tan(steering) / wheelbase [1/m]."""
        return math.tan(steering) / self.geometry.wheelbase

    def wheels(self, steering, speed):
        """Hinge angles and wheel speeds for a bicycle's steering angle and speed.

        Args:
            steering: bicycle's angle [rad], within the limits.
            speed: of the rear axle's center [m/s].

        Returns:
            paddock_common.ackermann.Wheels.
        """
        shape, half = self.geometry, self.geometry.track_width / 2.0
        curvature = self.rear_curvature(steering)
        return ackermann.wheels(speed, curvature, shape.wheelbase, shape.wheel_radius, half, half)

    def curvature_of_hinges(self, left, right):
        """Curvature [1/m] of two measured hinge angles [rad].

        Each hinge implies 1 / (wheelbase / tan(angle) + y), written without the division by a
        tangent of zero; the result is the mean of both.
        """
        half = self.geometry.track_width / 2.0
        return 0.5 * sum(
            math.sin(angle) / (self.geometry.wheelbase * math.cos(angle) + y * math.sin(angle))
            for angle, y in ((left, half), (right, -half))
        )
