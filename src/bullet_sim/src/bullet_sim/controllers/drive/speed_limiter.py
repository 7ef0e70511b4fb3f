"""Limits of velocity, acceleration and jerk for a commanded velocity."""

import math
from dataclasses import dataclass

from bullet_sim.errors import ControllerError


@dataclass(frozen=True)
class SpeedLimiter:
    """Bounds, each a pair (min, max), or None for no limit.

    Attributes:
        velocity: [m/s, rad/s].
        acceleration: change of velocity per time [m/s^2, rad/s^2].
        jerk: change of acceleration per time [m/s^3, rad/s^3].
    """

    velocity: tuple = None
    acceleration: tuple = None
    jerk: tuple = None

    def limit(self, wanted, last, last_but_one, period):
        """The wanted velocity, limited.

        Args:
            wanted: commanded velocity.
            last, last_but_one: velocities of the last two periods.
            period: [s].
        """
        value = wanted
        if self.jerk is not None:
            change = last - last_but_one
            bounds = [2.0 * jerk * period * period for jerk in self.jerk]
            value = last + change + _clamp(value - last - change, bounds)
        if self.acceleration is not None:
            value = last + _clamp(value - last, [a * period for a in self.acceleration])
        if self.velocity is not None:
            value = _clamp(value, self.velocity)
        return value


def _clamp(value, bounds):
    return min(max(value, bounds[0]), bounds[1])


def parse_limiter(settings):
    """SpeedLimiter from a `linear/x` or `angular/z` block.

    Args:
        settings: Settings of the block.

    Raises:
        ControllerError: a limit is switched on without its max, or min is above max.
    """
    pairs = {}
    for quantity in ("velocity", "acceleration", "jerk"):
        high = settings.number(f"max_{quantity}", math.nan)
        low = settings.number(f"min_{quantity}", -high)
        if not settings.flag(f"has_{quantity}_limits", False):
            continue
        if math.isnan(high):
            raise ControllerError(
                f"{settings.what} has has_{quantity}_limits without max_{quantity}"
            )
        if low > 0 or high < 0:
            raise ControllerError(
                f"{settings.what} has min_{quantity} {low} and max_{quantity} "
                f"{high}; 0 must lie between them"
            )
        pairs[quantity] = (low, high)
    return SpeedLimiter(**pairs)
