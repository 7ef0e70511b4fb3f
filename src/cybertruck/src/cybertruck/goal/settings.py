"""Settings of the go-to-goal controller."""

import math
from dataclasses import dataclass, fields

from cybertruck.trailer.geometry import Geometry, towing_limit

GAINS = ("default", "original")
MAY_BE_ZERO = ("hitch_offset",)


@dataclass(frozen=True)
class GoalSettings:
    """Geometry, limits and gains.

    Attributes:
        gains: "default": shortest path, ends near the goal; "original": the original's
            proportional control, ends in its 0.5 m box.
        wheelbase: Front to rear axle [m].
        max_steering: Greatest angle of the bicycle's front wheel [rad].
        trailer: Whether the truck pulls a trailer; the curvature is then limited further.
        hitch_offset: Rear axle to hitch [m].
        tongue_length: Hitch to the trailer's axle [m].
        max_hitch_angle: Hitch angle that the tightest circle with a trailer ends in [rad].
        min_radius: Radius of planned turns without a trailer [m].
        trailer_min_radius: Radius of planned turns with a trailer [m].
        max_linear: Greatest linear.x [m/s].
        max_angular: Greatest angular.z [rad/s].
        acceleration: Rise of the commanded speed [m/s^2].
        deceleration: With which the truck slows down towards the goal [m/s^2].
        creep: Least speed while it drives [m/s].
        turn_gain: Curvature per heading error [1/(m rad)].
        turn_rate: Greatest rate at which a heading error decays [1/s].
        tolerance: Distance within which the goal counts as reached [m].
        max_distance: A goal further away is refused [m].
        odom_timeout: Time without odometry after which the drive ends [s].
        stuck_time: The drive ends when the truck moved less than stuck_distance in this time [s].
        stuck_distance: See stuck_time [m].
    """

    gains: str = "default"
    wheelbase: float = 0.508
    max_steering: float = 0.7854
    trailer: bool = False
    hitch_offset: float = 0.30
    tongue_length: float = 0.70
    max_hitch_angle: float = math.radians(60.0)
    min_radius: float = 0.8
    trailer_min_radius: float = 1.15
    max_linear: float = 1.5
    max_angular: float = 0.7854
    acceleration: float = 1.0
    deceleration: float = 0.5
    creep: float = 0.2
    turn_gain: float = 3.0
    turn_rate: float = 2.5
    tolerance: float = 0.15
    max_distance: float = 200.0
    odom_timeout: float = 0.5
    stuck_time: float = 5.0
    stuck_distance: float = 0.05

    def __post_init__(self):
        for item in fields(self):
            value = getattr(self, item.name)
            if item.name == "gains":
                if value not in GAINS:
                    raise ValueError(f"gains is {value!r}; it must be one of {', '.join(GAINS)}")
            elif item.name == "trailer":
                if not isinstance(value, bool):
                    raise ValueError(f"trailer is {value!r}; it must be true or false")
            elif (
                isinstance(value, bool)
                or not isinstance(value, (int, float))
                or not math.isfinite(value)
            ):
                raise ValueError(f"{item.name} is {value!r}; it must be a number")
            elif value < 0.0 or (value == 0.0 and item.name not in MAY_BE_ZERO):
                raise ValueError(f"{item.name} is {value!r}; it must be above 0")
        if self.radius < self.least_radius:
            name = "trailer_min_radius" if self.trailer else "min_radius"
            raise ValueError(
                f"{name} is {self.radius:g}; the truck turns on no less than "
                f"{self.least_radius:.3f} m"
            )

    @property
    def radius(self):
        """Radius of planned turns [m]."""
        return self.trailer_min_radius if self.trailer else self.min_radius

    @property
    def least_radius(self):
        """Radius that corrections may use: full lock, or what a trailer follows [m]."""
        geometry = Geometry(
            self.wheelbase, self.hitch_offset, self.tongue_length, self.max_steering
        )
        if self.trailer:
            return 1.0 / towing_limit(geometry, self.max_hitch_angle)
        return 1.0 / geometry.max_curvature
