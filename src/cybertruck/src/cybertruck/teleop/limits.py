"""Speeds and steering of the teleops: steps, limits, ramps."""

import math
from dataclasses import dataclass

from paddock_common.settings import Number, number

from cybertruck.trailer.geometry import TowingTruck

STEPS = {  # of ten percent
    "faster": ("linear", 1.1),
    "slower": ("linear", 0.9),
    "turn_faster": ("angular", 1.1),
    "turn_slower": ("angular", 0.9),
}
MIN_SPEED = 0.01  # minimum speeds [m/s, rad/s], from which they can grow again


class Speeds:
    """Linear and angular speed of a teleop, changed in steps and within limits.

    Args:
        linear, angular: Default speed [m/s] and yaw rate [rad/s].
        max_linear, max_angular: Their maxima.

    Raises:
        ValueError: A default is not a number within the limits.
    """

    def __init__(self, linear=0.5, angular=0.5, max_linear=3.0, max_angular=3.0):
        for name, value, limit in (
            ("linear_speed", linear, max_linear),
            ("angular_speed", angular, max_angular),
        ):
            Number(min=MIN_SPEED, max=limit).check(name, value)
        self._defaults = (float(linear), float(angular))
        self._max_speeds = {"linear": max_linear, "angular": max_angular}
        self.reset()

    def reset(self):
        """Sets both speeds back to the defaults."""
        self.linear, self.angular = self._defaults

    def apply(self, action):
        """Applies a named step, within the limits.

        Args:
            action: Key of STEPS, or "reset".
        """
        if action == "reset":
            self.reset()
            return
        name, factor = STEPS[action]
        speed = max(getattr(self, name) * factor, MIN_SPEED)
        setattr(self, name, min(speed, self._max_speeds[name]))


STANDSTILL = 1e-6  # lower speeds count as 0 [m/s]


@dataclass(frozen=True)
class Limits(TowingTruck):
    """Limits of the commands that a teleop sends, beside those of the truck.

    Attributes:
        max_speed: Maximum absolute linear.x [m/s].
        max_angular: Maximum absolute angular.z [rad/s].
        max_acceleration: Maximum rise of the speed [m/s^2]; 0: no limit. Slowing down is never
            delayed.
        max_steering_rate: Maximum change of the steering angle [rad/s]; 0: no limit.
    """

    max_speed: float = number(3.0, above=0.0, unit="m/s")
    max_angular: float = number(3.0, above=0.0, unit="rad/s")
    max_acceleration: float = number(3.0, min=0.0, unit="m/s²")
    max_steering_rate: float = number(3.0, min=0.0, unit="rad/s")

    def clip(self, linear, angular):
        """Limits a command; the truck cannot turn at rest.

        Args:
            linear, angular: Requested linear.x [m/s] and angular.z [rad/s].

        Returns:
            (linear.x [m/s], angular.z [rad/s]).
        """
        linear = min(max(linear, -self.max_speed), self.max_speed)
        if abs(linear) < STANDSTILL:
            return 0.0, 0.0
        limit = min(self.max_angular, abs(linear) * self.max_curvature)
        return linear, min(max(angular, -limit), limit)


class RateLimiter:
    """Limits the rates of change of commands; stopping is never delayed."""

    def __init__(self, limits: Limits):
        self._limits = limits
        self.reset()

    def reset(self):
        """Resets to rest with straight wheels."""
        self._linear, self._steering = 0.0, 0.0

    def step(self, linear, angular, period):
        """Returns the next command as Limits.clip, a period [s] after the last one."""
        limits = self._limits
        linear, angular = limits.clip(linear, angular)
        if linear == 0.0:
            self.reset()
            return 0.0, 0.0
        if limits.max_acceleration > 0.0:
            from_speed = abs(self._linear) if self._linear * linear > 0.0 else 0.0
            limit = from_speed + limits.max_acceleration * max(period, 0.0)
            reached = math.copysign(min(abs(linear), limit), linear)
        else:
            reached = linear
        steering = math.atan(angular / linear * limits.wheelbase)
        if limits.max_steering_rate > 0.0:
            limit = limits.max_steering_rate * max(period, 0.0)
            steering = min(max(steering, self._steering - limit), self._steering + limit)
        self._linear, self._steering = reached, steering
        return limits.clip(reached, reached * math.tan(steering) / limits.wheelbase)
