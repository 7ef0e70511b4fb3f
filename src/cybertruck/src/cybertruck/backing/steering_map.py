"""Measures the steering map: the curvature of each steering angle."""

import math
import os
import sys
from dataclasses import dataclass

import numpy as np
import rospy
from paddock_common.settings import check, from_table, number, read, text
from scipy.optimize import least_squares

from cybertruck.backing.server import Driver
from cybertruck.backing.state import StateSource
from cybertruck.trailer.geometry import Geometry, TrailerError, has_steady_towing
from cybertruck.trailer.steering import MeasuredSteering, write_map
from cybertruck.trailer.tracker import TOP_SPEED
from paddock_common import nodes

NEARLY_STRAIGHT = math.radians(1.0)  # below, rotation per distance instead of a circle
MIN_POINTS = 20


def fit_circle(points):
    """Fits a circle to points: algebraically first (Kåsa), then by geometric distance.

    Args:
        points: (n, 2) in driving order, n >= 3 [m].

    Returns:
        (center (2,) [m], signed curvature, positive for a left turn [1/m], rms distance of the
        points from the circle [m]).

    Raises:
        TrailerError: Too few points, or they do not lie on a circle.
    """
    points = np.asarray(points, dtype=float)
    if points.ndim != 2 or points.shape[1:] != (2,) or len(points) < 3:
        raise TrailerError(f"circle: points of shape {points.shape}; it must be (n, 2), n >= 3")
    center = points.mean(axis=0)
    local = points - center
    matrix = np.column_stack((2.0 * local, np.ones(len(local))))
    solution, _, rank, _ = np.linalg.lstsq(matrix, (local**2).sum(axis=1), rcond=1e-10)
    if rank < 3:
        raise TrailerError("circle: the points lie on a line")
    start = np.append(solution[:2], np.sqrt(solution[2] + solution[:2] @ solution[:2]))

    def distances(values):
        return np.hypot(*(local - values[:2]).T) - values[2]

    fit = least_squares(distances, start, x_scale=max(start[2], 1e-6))
    radius = float(fit.x[2])
    arms = local - fit.x[:2]
    signed_area = np.sum(arms[:-1, 0] * arms[1:, 1] - arms[:-1, 1] * arms[1:, 0])
    return (
        center + fit.x[:2],
        float(np.sign(signed_area) / radius),
        float(np.sqrt(np.mean(fit.fun**2))),
    )


@dataclass(frozen=True)
class MapSettings:
    """Settings of the drive.

    Attributes:
        angles: Steering angles that are measured [rad].
        check_angles: Others, to check the map [rad].
        speed: [m/s].
        settle_distance: Driven before points are measured [m].
        circle: Fraction of a full circle that is then driven, ...
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
        """Measured distance [m] by steering angle [rad] and wheelbase [m]."""
        curvature = abs(math.tan(angle)) / wheelbase
        return min(self.longest, 2.0 * math.pi * self.circle / max(curvature, 1e-9))


@dataclass(frozen=True)
class Measured:
    """One angle's drive: angle [rad], curvature [1/m], rms distance from the circle [m]."""

    angle: float
    curvature: float
    rms: float


def measure(angle, poses) -> Measured:
    """Computes the curvature from the poses of one angle.

    Args:
        angle: Steering angle [rad].
        poses: (n, 3) x, y, heading [m, m, rad] in driving order.

    Raises:
        TrailerError: Too few poses, or they do not lie on a circle.
    """
    poses = np.asarray(poses, dtype=float).reshape(-1, 3)
    if len(poses) < MIN_POINTS:
        raise TrailerError(
            f"{math.degrees(angle):.1f} degrees: {len(poses)} points were "
            f"measured, {MIN_POINTS} are needed"
        )
    if abs(angle) < NEARLY_STRAIGHT:
        headings = np.unwrap(poses[:, 2])
        distance = np.sum(np.hypot(*np.diff(poses[:, :2], axis=0).T))
        return Measured(angle, float((headings[-1] - headings[0]) / distance), 0.0)
    _, curvature, rms = fit_circle(poses[:, :2])
    if rms > 0.05 / abs(curvature):
        raise TrailerError(
            f"{math.degrees(angle):.1f} degrees: the points are {rms:.3f} m (rms) "
            "off a circle; the truck did not drive steadily"
        )
    return Measured(angle, curvature, rms)


def write_figure(file, measured, checked, steering: MeasuredSteering, wheelbase):
    """Plots measured curvatures, the map and tan φ / L, with residuals, into a PNG.

    Args:
        measured: List of Measured of which the map was made.
        checked: List of Measured that were not used for it.
        wheelbase: L [m].
    """
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8.0, 7.5))
    heights = {"height_ratios": (3, 2)}
    above, below = figure.subplots(2, 1, sharex=True, gridspec_kw=heights)
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
    for group, marker, label in ((measured, "o", "measured"), (checked, "x", "check, not used")):
        angles = np.array([item.angle for item in group])
        curvatures = np.array([item.curvature for item in group])
        above.plot(np.degrees(angles), curvatures, marker, color="#b5651d", label=label)
        below.plot(
            np.degrees(angles), curvatures - np.tan(angles) / wheelbase, marker, color="#b5651d"
        )
    above.set(ylabel="curvature [1/m]", title="Steering map Fκ of the simulated truck")
    below.set(xlabel="steering angle φ [°]", ylabel="residual [1/m]")
    for axes in (above, below):
        axes.grid(alpha=0.3)
        axes.legend(loc="best")
    figure.tight_layout()
    figure.savefig(file, dpi=100)


START_LIMIT = 60.0  # wall time until the truck is up [s]
STEP_LIMIT = 20.0  # wall time without a new state after which the drive fails [s]
STUCK_FACTOR = 3.0  # maximum duration of a stretch / planned duration
PERIOD = 0.02  # simulated time between commands [s]


class MapDrive:
    """Measures one steering angle after the other.

    Raises:
        TrailerError: A parameter is wrong.
    """

    def __init__(self):
        parameters = rospy.get_param("~", {})
        values = {
            name: value for name, value in parameters.get("map", {}).items() if value != []
        }  # an empty list stands for the default
        self._settings = from_table(MapSettings, values, "map", TrailerError)
        self._geometry = read(Geometry, parameters.get, prefix="")
        if rospy.get_param("~trailer", False):
            self._refuse_folding()
        self._file = str(rospy.get_param("~file"))
        self._figure_file = str(rospy.get_param("~picture", ""))
        self._source = StateSource(self._settings.odom_topic)
        self._driver = Driver()

    def _refuse_folding(self):
        """Raises a TrailerError when an angle would fold the trailer."""
        for angle in (*self._settings.angles, *self._settings.check_angles):
            if not has_steady_towing(math.tan(angle) / self._geometry.wheelbase, self._geometry):
                raise TrailerError(
                    f"angles: {math.degrees(angle):.1f} degrees would fold the "
                    "trailer; measure without it (trailer:=false)"
                )

    def run(self):
        """Drives, writes the map and prints the result.

        Raises:
            TrailerError: The truck does not respond, or a circle cannot be fitted.
        """
        if self._source.wait(None, START_LIMIT) is None:
            raise TrailerError(f"no odometry on {self._settings.odom_topic}")
        while self._driver.subscribers == 0 and not rospy.is_shutdown():
            rospy.sleep(0.05)
        measured = [self._drive(angle) for angle in self._settings.angles]
        checked = [self._drive(angle) for angle in self._settings.check_angles]
        self._driver.stop()
        angles = [item.angle for item in measured]
        curvatures = [item.curvature for item in measured]
        os.makedirs(os.path.dirname(os.path.abspath(self._file)), exist_ok=True)
        write_map(
            self._file,
            angles,
            curvatures,
            (
                "Steering map of the simulated truck: curvature of the rear axle's path over the",
                f"bicycle's steering angle, circles fitted at {self._settings.speed:g} m/s. "
                "Made by: ./run exec roslaunch cybertruck steering_map.launch",
            ),
        )
        steering = MeasuredSteering(angles, curvatures)
        for item in checked:
            error = float(steering.curvature(item.angle)) / item.curvature - 1.0
            rospy.loginfo(
                "check %.1f degrees: measured %.4f 1/m, the map is %.2f %% off",
                math.degrees(item.angle),
                item.curvature,
                100.0 * error,
            )
        if self._figure_file:
            write_figure(self._figure_file, measured, checked, steering, self._geometry.wheelbase)
        rospy.loginfo("written: %s %s", self._file, self._figure_file)

    def _drive(self, angle):
        """Drives at one steering angle and returns its Measured."""
        self._stretch(angle, self._settings.settle_distance)
        poses = self._stretch(angle, self._settings.distance(angle, self._geometry.wheelbase))
        item = measure(angle, poses)
        rospy.loginfo(
            "%.1f degrees: %.4f 1/m (tan/L %.4f), %d points, rms %.1f mm",
            math.degrees(angle),
            item.curvature,
            math.tan(angle) / self._geometry.wheelbase,
            len(poses),
            1000.0 * item.rms,
        )
        return item

    def _stretch(self, angle, distance):
        """Drives a distance [m] and returns the poses along it."""
        state = self._next(None)
        start, last, driven, poses = state.stamp, state, 0.0, []
        limit = STUCK_FACTOR * distance / self._settings.speed + 5.0
        while driven < distance:
            self._driver.send(angle, self._settings.speed)
            state = self._next(state.stamp + PERIOD - 1e-6)
            driven += math.hypot(state.x - last.x, state.y - last.y)
            last = state
            poses.append((state.x, state.y, state.heading))
            if state.stamp - start > limit:
                raise TrailerError(
                    f"{math.degrees(angle):.1f} degrees: the truck drove "
                    f"{driven:.2f} m in {limit:.0f} s, not {distance:.2f} m"
                )
        return poses

    def _next(self, after):
        state = self._source.wait(after, STEP_LIMIT)
        if state is None or rospy.is_shutdown():
            raise TrailerError(f"no new odometry on {self._settings.odom_topic}")
        return state


def main():
    """Runs the drive; exit status 0 if the map was written."""
    nodes.init_interruptible("steering_map")
    try:
        MapDrive().run()
    except (TrailerError, KeyError, OSError, rospy.ROSException) as error:
        rospy.logfatal("steering_map: %s", error)
        sys.exit(1)
