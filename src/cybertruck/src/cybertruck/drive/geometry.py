"""The truck's dimensions and limits, as in config/truck.yaml."""

import math
from dataclasses import dataclass, fields


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

    wheelbase: float = 0.508
    track_width: float = 0.43
    wheel_radius: float = 0.1016
    wheel_width: float = 0.0762
    hitch_offset: float = 0.30
    tongue_length: float = 0.70
    max_steering: float = 0.7854
    max_speed: float = 3.0
    max_steering_rate: float = 2.5
    max_acceleration: float = 2.0

    def __post_init__(self):
        for item in fields(self):
            value = getattr(self, item.name)
            if (
                isinstance(value, bool)
                or not isinstance(value, (int, float))
                or not (math.isfinite(value) and value > 0.0)
            ):
                raise ValueError(f"{item.name} is {value!r}, must be a number above 0")
        limit = math.atan(2.0 * self.wheelbase / self.track_width)
        if self.max_steering >= limit:
            raise ValueError(
                f"max_steering is {self.max_steering!r}, must be below {limit:.4f} "
                "rad, where the turning centre would lie under a rear wheel"
            )


def geometry_from(get):
    """TruckGeometry from a function get(name, default), e.g. of private parameters.

    Raises:
        ValueError: names the parameter, its value and what is valid.
    """
    return TruckGeometry(
        **{item.name: get(item.name, item.default) for item in fields(TruckGeometry)}
    )
