"""The truck's dimensions and limits, as in config/truck.yaml."""

import math
from dataclasses import dataclass

from paddock_common.settings import check, number


@dataclass(frozen=True)
class TruckGeometry:
    """Lengths and limits.

    Attributes:
        wheelbase: rear axle to front axle [m].
        track_width: between the middles of left and right wheel [m].
        wheel_radius: of all wheels [m].
        wheel_width: of all wheels [m].
        hitch_offset: L1, rear axle back to the hitch [m].
        tongue_length: L2, hitch back to the trailer's axle [m].
        max_steering: largest angle of the bicycle's front wheel [rad].
        max_speed: of the rear axle's middle, either way [m/s].
        max_steering_rate: of the bicycle's angle [rad/s].
        max_acceleration: pulling away and braking [m/s^2].
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
                "rad, where the turning centre would lie under a rear wheel"
            )
