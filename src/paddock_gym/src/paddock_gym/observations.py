"""Observations: images, ranges, state, and dictionaries of them."""

import math
from typing import NamedTuple

import cv2
import numpy as np

WIDTH, HEIGHT = 160, 120  # [px]
GREY_SHAPE = (HEIGHT, WIDTH, 1)
COLOUR_SHAPE = (HEIGHT, WIDTH, 3)


def picture(rgb, colour=False):
    """Observe a camera picture.

    Args:
        rgb: (H, W, 3) uint8 of any size.
        colour: False: grey (ITU-R BT.601 weights).

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
FARTHEST = 10.0  # [m]: from here on a ray counts as free
RANGES_SHAPE = (RAYS,)
ANGLES = np.linspace(-HALF_ANGLE, HALF_ANGLE, RAYS)  # [rad], positive to the left


def ranges(measured):
    """Observe ranges.

    Args:
        measured: (64,) [m] along ANGLES; +inf: nothing there, -inf: too near (REP 117).

    Returns:
        (64,) float32, 0 to 1 of FARTHEST.
    """
    # np.clip and np.nan_to_num take several times as long; fmin turns NaN into FARTHEST
    near = np.maximum(np.fmin(np.asarray(measured, dtype=float), FARTHEST), 0.0)
    return (near / FARTHEST).astype(np.float32)


def pick_rays(angle_min, angle_increment, count):
    """Numbers of the rays of another scan that are nearest to ANGLES.

    Args:
        angle_min, angle_increment: of the scan [rad].
        count: of its rays.

    Returns:
        (64,) int.

    Raises:
        ValueError: the scan does not reach from -150 to 150 degrees, or has too few rays.
    """
    end = angle_min + angle_increment * (count - 1)
    tolerance = abs(angle_increment) / 2.0 + 1e-3
    if count < RAYS or angle_min > -HALF_ANGLE + tolerance or end < HALF_ANGLE - tolerance:
        raise ValueError(
            f"the scan has {count} rays from {math.degrees(angle_min):.0f} to "
            f"{math.degrees(end):.0f} degrees; the policy needs {RAYS} or more from -150 to 150"
        )
    return np.clip(np.rint((ANGLES - angle_min) / angle_increment).astype(int), 0, count - 1)


AHEAD = np.array((0.2, 0.5, 0.8, 1.2, 1.6, 2.0))  # where curvatures are taken [m]
LIMIT = 4.0  # of all numbers
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
    *(f"curvature {ahead:g} m ahead [1/m]" for ahead in AHEAD),
)
STATE_SHAPE = (len(NAMES),)


class StateObserver:
    """Observes the state on one course.

    Args:
        projector: track_model.referee.course.Projector.
    """

    def __init__(self, projector):
        count = round(projector.length / STEP)
        self._step, self._count = projector.length / count, count
        at = (np.arange(count) * self._step)[:, None] + AHEAD
        bends = [projector.curvature(row) for row in at]
        self._bends = np.clip(bends, -LIMIT, LIMIT).astype(np.float32)

    def observe(self, motion, place, last):
        """Observe the state.

        Args:
            motion: Motion of the car.
            place: Standing, or anything with its s, lateral, heading_error, left and right.
            last: commanded (speed [m/s], steering [rad]).

        Returns:
            (14,) float32, the numbers of NAMES, each from -LIMIT to LIMIT.
        """
        left, right, error = place.left, place.right, place.heading_error
        speed, steering = last
        row = np.empty(STATE_SHAPE, np.float32)
        row[:8] = (
            _cut((place.lateral - (left - right) / 2.0) * 2.0 / (left + right)),
            math.sin(error),
            math.cos(error),
            _cut(motion.forward / SPEED_SCALE),
            _cut(motion.leftward / SIDEWAYS_SCALE),
            _cut(motion.yaw_rate / YAW_RATE_SCALE),
            steering / STEERING_SCALE,
            speed / SPEED_SCALE,
        )
        row[8:] = self._bends[min(max(int(place.s / self._step), 0), self._count - 1)]
        return row


def _cut(value):
    return min(max(value, -LIMIT), LIMIT)


class Place(NamedTuple):
    """Where a car is on its course; names and units as those of course.judge.Standing."""

    s: float
    lateral: float
    heading_error: float
    left: float
    right: float


def locate(projector, motion, near=None):
    """Place of a car.

    Args:
        projector: Projector.
        motion: Motion.
        near: its arc length before [m], or None.
    """
    arc, lateral = projector.project([(motion.x, motion.y)], near)
    s = float(arc[0])
    left, right = projector.sides(s)
    error = math.remainder(motion.yaw - projector.heading(s), 2.0 * math.pi)
    return Place(s, float(lateral[0]), error, float(left), float(right))


class Assembler:
    """Collects the newest measurements of each kind.

    Args:
        names: of the observations.
        colour: whether pictures keep their colours.
        projector: Projector; needed for `state`.
    """

    def __init__(self, names, colour=False, projector=None):
        self._names, self._colour, self._projector = names, colour, projector
        self._observer = StateObserver(projector) if "state" in names else None
        self._motion = self._place = self._ranges = self._picture = None

    def set_motion(self, motion):
        """A new Motion of the car."""
        if self._observer is None:
            return
        near = self._place and self._place.s
        place = locate(self._projector, motion, near)
        if near is not None and abs(place.lateral) > 1.0:
            place = locate(self._projector, motion)  # a service has moved it
        self._motion, self._place = motion, place

    def set_ranges(self, measured):
        """New ranges (64,) [m] along observations.ranges.ANGLES."""
        self._ranges = ranges(measured)

    def set_picture(self, rgb):
        """A new picture (H, W, 3) uint8."""
        self._picture = picture(rgb, self._colour)

    def observe(self, last):
        """The observation as a dict, or None while something is missing.

        Args:
            last: commanded (speed [m/s], steering [rad]).
        """
        found = {
            "state": self._motion and self._observer.observe(self._motion, self._place, last),
            "lidar": self._ranges,
            "camera": self._picture,
        }
        chosen = {name: found[name] for name in self._names}
        return None if any(value is None for value in chosen.values()) else chosen
