"""Rate limits of steering angle and speed."""

import math


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
        """Stand still, wheels straight."""
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
