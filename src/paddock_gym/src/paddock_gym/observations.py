"""Observations: images, ranges, state, and dictionaries of them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import ArrayLike
from track_model.referee.course import Course

from paddock_gym.course import Motion, RunState

WIDTH, HEIGHT = 160, 120  # [px]
GRAY_SHAPE = (HEIGHT, WIDTH, 1)
COLOR_SHAPE = (HEIGHT, WIDTH, 3)


def image(rgb: np.ndarray, colour: bool = False) -> np.ndarray:
    """Make the observation `camera` of an image.

    Args:
        rgb: (H, W, 3) uint8 of any size.
        colour: False: gray (ITU-R BT.601 weights).

    Returns:
        (120, 160, 1) or (120, 160, 3) uint8.
    """
    if rgb.shape[:2] != (HEIGHT, WIDTH):
        rgb = cv2.resize(rgb, (WIDTH, HEIGHT), interpolation=cv2.INTER_AREA)
    if colour:
        return np.ascontiguousarray(rgb)
    return cv2.cvtColor(rgb, cv2.COLOR_RGB2GRAY)[:, :, None]


RAYS = 64
HALF_ANGLE = math.radians(150.0)
MAX_RANGE = 10.0  # [m]: from here on a ray counts as free
RANGES_SHAPE = (RAYS,)
ANGLES = np.linspace(-HALF_ANGLE, HALF_ANGLE, RAYS)  # [rad], positive to the left


def ranges(measured: ArrayLike) -> np.ndarray:
    """Make the observation `lidar` of ranges.

    Args:
        measured: (64,) [m] along ANGLES; +inf: no object, -inf: too close (REP 117).

    Returns:
        (64,) float32, 0 to 1 of MAX_RANGE.
    """
    # np.clip and np.nan_to_num take several times as long; fmin turns NaN into MAX_RANGE
    near = np.maximum(np.fmin(np.asarray(measured, dtype=float), MAX_RANGE), 0.0)
    return (near / MAX_RANGE).astype(np.float32)


def over(measured: ArrayLike, most: float) -> np.ndarray:
    """Ranges [m] over their maximum, 0 to 1; too near: 0, nothing: 1."""
    return np.clip(np.fmin(measured, most) / most, 0.0, 1.0).astype(np.float32)


def polar(goal: Sequence[float], x: float, y: float, yaw: float) -> tuple[float, float]:
    """Distance [m] and bearing [rad] of a goal (x, y) from a robot's pose."""
    dx, dy = goal[0] - x, goal[1] - y
    return math.hypot(dx, dy), math.atan2(dy, dx) - yaw


def goal_row(distance: float, bearing: float, area: float) -> np.ndarray:
    """Make the observation `goal` (3,) float32 of polar(): distance over area, sine, cosine."""
    return np.array((min(4.0, distance / area), math.sin(bearing), math.cos(bearing)), np.float32)


def select_rays(angle_min: float, angle_increment: float, count: int) -> np.ndarray:
    """Indices of the rays of another scan that are closest to ANGLES.

    Args:
        angle_min, angle_increment: of the scan [rad].

    Returns:
        (64,) int.

    Raises:
        ValueError: the scan does not extend from -150 to 150 degrees, or has too few rays.
    """
    end = angle_min + angle_increment * (count - 1)
    tolerance = abs(angle_increment) / 2.0 + 1e-3
    if count < RAYS or angle_min > -HALF_ANGLE + tolerance or end < HALF_ANGLE - tolerance:
        raise ValueError(
            f"the scan has {count} rays from {math.degrees(angle_min):.0f} to "
            f"{math.degrees(end):.0f} degrees; the policy needs {RAYS} or more from -150 to 150"
        )
    return np.clip(np.rint((ANGLES - angle_min) / angle_increment).astype(int), 0, count - 1)


LOOKAHEADS = np.array((0.2, 0.5, 0.8, 1.2, 1.6, 2.0))  # where curvatures are sampled [m]
LIMIT = 4.0  # of all values
STEP = 0.02  # of the table of curvatures [m]
SPEED_SCALE = 4.0  # [m/s]
SIDEWAYS_SCALE = 1.0  # [m/s]
YAW_RATE_SCALE = 4.0  # [rad/s]
STEERING_SCALE = math.radians(30.0)
NAMES = (
    "lateral offset / half lane",
    "sine of the heading error",
    "cosine of the heading error",
    "forward speed / 4 m/s",
    "leftward speed / 1 m/s",
    "yaw rate / 4 rad/s",
    "commanded steering / 30 degrees",
    "commanded speed / 4 m/s",
    *(f"curvature {ahead:g} m ahead [1/m]" for ahead in LOOKAHEADS),
)
STATE_SHAPE = (len(NAMES),)


class StateObserver:
    """Observes the state on one course."""

    def __init__(self, course: Course) -> None:
        count = round(course.length / STEP)
        self._step, self._count = course.length / count, count
        at = (np.arange(count) * self._step)[:, None] + LOOKAHEADS
        curvatures = [course.curvature(row) for row in at]
        self._curvatures = np.clip(curvatures, -LIMIT, LIMIT).astype(np.float32)

    def observe(
        self, motion: Motion, course_pose: CoursePose | RunState, last: tuple[float, float]
    ) -> np.ndarray:
        """Observe the state.

        Args:
            last: commanded (speed [m/s], steering [rad]).

        Returns:
            (14,) float32, the values of NAMES, each from -LIMIT to LIMIT.
        """
        left, right, error = course_pose.left, course_pose.right, course_pose.heading_error
        speed, steering = last
        row = np.empty(STATE_SHAPE, np.float32)
        row[:8] = (
            _clip((course_pose.lateral - (left - right) / 2.0) * 2.0 / (left + right)),
            math.sin(error),
            math.cos(error),
            _clip(motion.forward / SPEED_SCALE),
            _clip(motion.leftward / SIDEWAYS_SCALE),
            _clip(motion.yaw_rate / YAW_RATE_SCALE),
            steering / STEERING_SCALE,
            speed / SPEED_SCALE,
        )
        row[8:] = self._curvatures[min(max(int(course_pose.s / self._step), 0), self._count - 1)]
        return row


def _clip(value: float) -> float:
    return min(max(value, -LIMIT), LIMIT)


class CoursePose(NamedTuple):
    """Pose of a car on its course; names and units as those of course.RunState."""

    s: float
    lateral: float
    heading_error: float
    left: float
    right: float


def locate(course: Course, motion: Motion, near: float | None = None) -> CoursePose:
    """Find the CoursePose of a car.

    Args:
        near: its last arc length [m], or None.
    """
    s, lateral = course.locate(motion.x, motion.y, near)
    left, right = course.sides(s)
    error = math.remainder(motion.yaw - course.heading(s), 2.0 * math.pi)
    return CoursePose(s, lateral, error, float(left), float(right))


class Assembler:
    """Stores the newest measurement of each sensor.

    Args:
        course: needed for `state`.
    """

    def __init__(
        self, names: Sequence[str], colour: bool = False, course: Course | None = None
    ) -> None:
        self._names, self._colour, self._course = names, colour, course
        self._observer: StateObserver | None = None
        if "state" in names:
            if course is None:
                raise ValueError("course is None; the observation state needs one")
            self._observer = StateObserver(course)
        self._motion: Motion | None = None
        self._course_pose: CoursePose | None = None
        self._ranges: np.ndarray | None = None
        self._image: np.ndarray | None = None

    def set_motion(self, motion: Motion) -> None:
        """Set the car's Motion."""
        if self._observer is None or self._course is None:
            return
        near = self._course_pose.s if self._course_pose else None
        course_pose = locate(self._course, motion, near)
        if near is not None and abs(course_pose.lateral) > 1.0:
            course_pose = locate(self._course, motion)  # a service has moved the car
        self._motion, self._course_pose = motion, course_pose

    def set_ranges(self, measured: ArrayLike) -> None:
        """Set ranges (64,) [m] along observations.ranges.ANGLES."""
        self._ranges = ranges(measured)

    def set_image(self, rgb: np.ndarray) -> None:
        """Set an image (H, W, 3) uint8 RGB."""
        self._image = image(rgb, self._colour)

    def observe(self, last: tuple[float, float]) -> dict[str, np.ndarray] | None:
        """Return the observation, or None while a part of it is missing.

        Args:
            last: commanded (speed [m/s], steering [rad]).
        """
        available = {"lidar": self._ranges, "camera": self._image}
        if self._observer and self._motion and self._course_pose:
            available["state"] = self._observer.observe(self._motion, self._course_pose, last)
        selected = {name: available.get(name) for name in self._names}
        complete = {name: value for name, value in selected.items() if value is not None}
        return complete if len(complete) == len(selected) else None
