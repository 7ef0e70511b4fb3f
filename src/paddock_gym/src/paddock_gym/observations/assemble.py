"""Observations from what a robot measures, as the environment gives them."""

import math
from typing import NamedTuple

from paddock_gym.observations import picture, ranges
from paddock_gym.observations.state import StateObserver


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
        self._ranges = ranges.ranges(measured)

    def set_picture(self, rgb):
        """A new picture (H, W, 3) uint8."""
        self._picture = picture.picture(rgb, self._colour)

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
