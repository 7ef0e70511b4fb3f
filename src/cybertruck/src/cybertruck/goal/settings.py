"""Settings of the go-to-goal controller."""

from dataclasses import dataclass

from paddock_common.settings import check, choice, number

from cybertruck.trailer.geometry import TowingTruck

GAINS = ("default", "original")


@dataclass(frozen=True)
class GoalSettings(TowingTruck):
    """Limits and gains, beside those of the truck.

    Attributes:
        gains: "default": shortest path, stops near the goal; "original": the original's
            proportional control, stops in its 0.5 m box.
        min_radius: Radius of planned turns without a trailer [m].
        trailer_min_radius: Radius of planned turns with a trailer [m].
        max_linear: Maximum linear.x [m/s].
        max_angular: Maximum angular.z [rad/s].
        acceleration: Rise of the commanded speed [m/s^2].
        deceleration: With which the truck slows down towards the goal [m/s^2].
        creep: Minimum speed while it drives [m/s].
        turn_gain: Curvature per heading error [1/(m rad)].
        turn_rate: Maximum rate at which a heading error decays [1/s].
        tolerance: Distance within which the goal counts as reached [m].
        max_distance: A goal further away is refused [m].
        odom_timeout: Time without odometry after which the drive stops [s].
        stuck_time: The drive stops when the truck moved less than stuck_distance in this time [s].
        stuck_distance: See stuck_time [m].
    """

    gains: str = choice("default", GAINS)
    min_radius: float = number(0.8, above=0.0, unit="m")
    trailer_min_radius: float = number(1.15, above=0.0, unit="m")
    max_linear: float = number(1.5, above=0.0, unit="m/s")
    max_angular: float = number(0.7854, above=0.0, unit="rad/s")
    acceleration: float = number(1.0, above=0.0, unit="m/s²")
    deceleration: float = number(0.5, above=0.0, unit="m/s²")
    creep: float = number(0.2, above=0.0, unit="m/s")
    turn_gain: float = number(3.0, above=0.0, unit="1/(m rad)")
    turn_rate: float = number(2.5, above=0.0, unit="1/s")
    tolerance: float = number(0.15, above=0.0, unit="m")
    max_distance: float = number(200.0, above=0.0, unit="m")
    odom_timeout: float = number(0.5, above=0.0, unit="s")
    stuck_time: float = number(5.0, above=0.0, unit="s")
    stuck_distance: float = number(0.05, above=0.0, unit="m")

    def __post_init__(self):
        check(self)
        if self.radius < self.min_turning_radius:
            name = "trailer_min_radius" if self.trailer else "min_radius"
            raise ValueError(
                f"{name} is {self.radius:g}; the truck turns on no less than "
                f"{self.min_turning_radius:.3f} m"
            )

    @property
    def radius(self):
        """Radius of planned turns [m]."""
        return self.trailer_min_radius if self.trailer else self.min_radius

    @property
    def min_turning_radius(self):
        """Minimum radius of corrections: full lock, or what a trailer can follow [m]."""
        return 1.0 / self.max_curvature
