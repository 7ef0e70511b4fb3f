"""Settings of the steering map's drive, and curvatures from its poses; no ROS."""

import math
from dataclasses import dataclass

import numpy as np
from paddock_common.settings import check, number, text

from cybertruck.trailer.circle import fit_circle
from cybertruck.trailer.geometry import TrailerError
from cybertruck.trailer.tracker import TOP_SPEED

NEARLY_STRAIGHT = math.radians(1.0)  # below, turn per distance is taken, there is no circle
LEAST_POINTS = 20


@dataclass(frozen=True)
class MapSettings:
    """Settings of the drive.

    Attributes:
        angles: Steering angles that are measured [rad].
        check_angles: Others, measured to check the map, not to make it [rad].
        speed: [m/s].
        settle_distance: Driven before points are taken [m].
        circle: Share of a full circle that is then driven, ...
        longest: ... but no more than this [m].
        odom_topic: Odometry to measure with; not wheel odometry, computed from the steering.
    """

    angles: tuple = tuple(math.radians(angle) for angle in np.arange(-45.0, 46.0, 7.5))
    check_angles: tuple = tuple(
        math.radians(angle) for angle in (-41.0, -26.0, -11.0, 11.0, 26.0, 41.0)
    )
    speed: float = number(0.5, above=0.0, below=TOP_SPEED, unit="m/s")
    settle_distance: float = number(0.6, above=0.0, unit="m")
    circle: float = number(0.75, above=0.0)
    longest: float = number(3.0, above=0.0, unit="m")
    odom_topic: str = text("/ground_truth/odom")

    def __post_init__(self):
        check(self, TrailerError)
        for name in ("angles", "check_angles"):
            values = np.atleast_1d(np.array(getattr(self, name), dtype=float))
            if not np.all(np.isfinite(values)) or np.any(np.abs(values) >= math.pi / 2):
                raise TrailerError(f"{name}: {values.tolist()}; they must lie within ±pi/2 rad")
            object.__setattr__(self, name, tuple(values.tolist()))
        if len(self.angles) < 3 or not np.all(np.diff(self.angles) > 0.0):
            raise TrailerError("angles: there must be 3 or more, each above the one before")

    def distance(self, angle, wheelbase):
        """Distance [m] over which points are taken, by steering angle [rad] and wheelbase [m]."""
        bend = abs(math.tan(angle)) / wheelbase
        return min(self.longest, 2.0 * math.pi * self.circle / max(bend, 1e-9))


@dataclass(frozen=True)
class Measured:
    """One angle's drive: angle [rad], curvature [1/m], rms distance from the circle [m]."""

    angle: float
    curvature: float
    rms: float


def measure(angle, poses):
    """Computes the curvature from the poses of one angle.

    Args:
        angle: Steering angle [rad].
        poses: (n, 3) x, y, heading [m, m, rad] in driving order.

    Returns:
        Measured.

    Raises:
        TrailerError: Too few poses, or they do not lie on a circle.
    """
    poses = np.asarray(poses, dtype=float).reshape(-1, 3)
    if len(poses) < LEAST_POINTS:
        raise TrailerError(
            f"{math.degrees(angle):.1f} degrees: {len(poses)} points were "
            f"measured, {LEAST_POINTS} are needed"
        )
    if abs(angle) < NEARLY_STRAIGHT:
        turned = np.unwrap(poses[:, 2])
        distance = np.sum(np.hypot(*np.diff(poses[:, :2], axis=0).T))
        return Measured(angle, float((turned[-1] - turned[0]) / distance), 0.0)
    _, curvature, rms = fit_circle(poses[:, :2])
    if rms > 0.05 / abs(curvature):
        raise TrailerError(
            f"{math.degrees(angle):.1f} degrees: the points are {rms:.3f} m (rms) "
            "off a circle; the truck did not drive steadily"
        )
    return Measured(angle, curvature, rms)


def write_picture(file, measured, checked, steering, wheelbase):
    """Draws measured curvatures, the map and tan φ / L, with residuals, into a PNG.

    Args:
        file: PNG file to write.
        measured: List of Measured of which the map was made.
        checked: List of Measured that were not used for it.
        steering: MeasuredSteering.
        wheelbase: L [m].
    """
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    figure, (above, below) = pyplot.subplots(
        2, 1, figsize=(8.0, 7.5), sharex=True, gridspec_kw={"height_ratios": (3, 2)}
    )
    fine = np.linspace(steering.lowest, steering.highest, 400)
    above.plot(
        np.degrees(fine), np.tan(fine) / wheelbase, color="0.6", linewidth=3.0, label="tan φ / L"
    )
    above.plot(np.degrees(fine), steering.curvature(fine), color="#2f5d8a", label="map (PCHIP)")
    below.plot(
        np.degrees(fine),
        steering.curvature(fine) - np.tan(fine) / wheelbase,
        color="#2f5d8a",
        label="map - tan φ / L",
    )
    for group, mark, label in ((measured, "o", "measured"), (checked, "x", "check, not used")):
        angles = np.array([item.angle for item in group])
        curvatures = np.array([item.curvature for item in group])
        above.plot(np.degrees(angles), curvatures, mark, color="#b5651d", label=label)
        below.plot(
            np.degrees(angles), curvatures - np.tan(angles) / wheelbase, mark, color="#b5651d"
        )
    above.set(ylabel="curvature [1/m]", title="Steering map Fκ of the simulated truck")
    below.set(xlabel="steering angle φ [°]", ylabel="residual [1/m]")
    for axes in (above, below):
        axes.grid(alpha=0.3)
        axes.legend(loc="best")
    figure.tight_layout()
    figure.savefig(file, dpi=100)
    pyplot.close(figure)
