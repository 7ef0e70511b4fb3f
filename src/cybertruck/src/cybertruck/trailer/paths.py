"""Paths: position, heading and curvature over arc length, and the nearest point on them."""

import math

import numpy as np
from scipy.interpolate import CubicSpline

from cybertruck.trailer.geometry import TrailerError

SPACING = 0.01  # between the samples of a path [m]
NEWTON_STEPS = 4  # of the projection, which starts at the last result
LONGEST = 1000.0  # a longer path is refused [m]


class Path:
    """A smooth path in the plane, sampled at equal arc lengths, straight beyond both ends.

    Attributes:
        length: [m].
        arc: (n,) arc lengths [m].
        points: (n, 2) [m].
        headings: (n,) unwrapped directions of travel [rad].
        curvatures: (n,) positive to the left [1/m].
    """

    def __init__(self, points, headings, curvatures, length):
        """Stores samples at equal arc lengths from 0 to `length`."""
        self.points = np.asarray(points, dtype=float)
        self.headings = np.unwrap(headings)
        self.curvatures = np.asarray(curvatures, dtype=float)
        self.length = float(length)
        self.arc = np.linspace(0.0, self.length, len(self.points))
        self._step = self.arc[1]

    def sample(self, arc):
        """Returns points at arc lengths; before the start and past the end the path is straight.

        Args:
            arc: Arc length [m], any shape.

        Returns:
            (x, y [m], heading [rad], curvature [1/m]) of that shape.
        """
        arc = np.asarray(arc, dtype=float)
        inside = np.minimum(np.maximum(arc, 0.0), self.length)  # np.clip takes 3 times as long
        index = np.minimum((inside / self._step).astype(int), len(self.arc) - 2)
        ahead = inside - index * self._step
        heading, curvature = self.headings[index], self.curvatures[index]
        ratio = ahead / self._step
        mid_heading = heading + 0.5 * ratio * (self.headings[index + 1] - heading)
        end_heading = heading + ratio * (self.headings[index + 1] - heading)
        past = arc - inside
        x = self.points[index, 0] + ahead * np.cos(mid_heading) + past * np.cos(end_heading)
        y = self.points[index, 1] + ahead * np.sin(mid_heading) + past * np.sin(end_heading)
        curvature = curvature + ratio * (self.curvatures[index + 1] - curvature)
        return x, y, end_heading, np.where(past == 0.0, curvature, 0.0)

    def nearest(self, x, y, start):
        """Projects points onto the path by Newton's method, near their last projections.

        Args:
            x, y: Points [m], any shape.
            start: Arc lengths to start from, of that shape [m].

        Returns:
            Arc lengths [m]; below 0 and beyond the length where the ends are passed.
        """
        arc = np.asarray(start, dtype=float)
        for _ in range(NEWTON_STEPS):
            at_x, at_y, heading, curvature = self.sample(arc)
            cos, sin = np.cos(heading), np.sin(heading)
            along = (x - at_x) * cos + (y - at_y) * sin
            left = (y - at_y) * cos - (x - at_x) * sin
            slope = np.maximum(1.0 - curvature * left, 0.3)
            arc = arc + np.minimum(np.maximum(along / slope, -0.5), 0.5)
        return arc

    def first_nearest(self, x, y, within=math.inf):
        """Returns the arc length nearest to one point.

        Args:
            x, y: Point [m].
            within: Maximum arc length of the search; a path may pass its start again [m].

        Returns:
            Arc length [m], below 0 for a point before the start.
        """
        part = self.points[self.arc <= within]
        index = int(np.argmin(np.hypot(part[:, 0] - x, part[:, 1] - y)))
        return float(self.nearest(np.float64(x), np.float64(y), self.arc[index]))

    def errors(self, x, y, heading, arc):
        """Returns the errors of a vehicle from its projection on the path.

        Args:
            x, y: Its position [m].
            heading: Its direction of travel [rad].
            arc: Its arc length [m].

        Returns:
            (lateral error, positive left of the path [m], heading error within ±pi [rad]).
        """
        at_x, at_y, direction, _ = self.sample(arc)
        lateral = (y - at_y) * np.cos(direction) - (x - at_x) * np.sin(direction)
        difference = heading - direction
        return lateral, np.arctan2(np.sin(difference), np.cos(difference))

    def moved(self, x, y, heading):
        """Returns the path with its frame moved to a pose [m, m, rad]."""
        cos, sin = math.cos(heading), math.sin(heading)
        points = self.points @ np.array(((cos, sin), (-sin, cos))) + (x, y)
        return Path(points, self.headings + heading, self.curvatures, self.length)


def from_curvature(curvature_of, length) -> Path:
    """Integrates a curvature over arc length, from (0, 0) along +x.

    Args:
        curvature_of: Function from arc lengths (m,) [m] to curvatures (m,) [1/m].
        length: [m].
    """
    count = max(3, int(math.ceil(length / SPACING)) + 1)
    arc = np.linspace(0.0, length, 4 * (count - 1) + 1)  # four parts per sample
    step = arc[1]
    curvature = curvature_of(arc)
    mid_heading = curvature_of(arc[:-1] + 0.5 * step)
    simpson = step / 6.0 * (curvature[:-1] + 4.0 * mid_heading + curvature[1:])
    headings = np.concatenate(([0.0], np.cumsum(simpson)))
    half = headings[:-1] + step / 24.0 * (5.0 * curvature[:-1] + 8.0 * mid_heading - curvature[1:])
    points = [
        np.concatenate(
            (
                [0.0],
                np.cumsum(
                    step / 6.0 * (wave(headings[:-1]) + 4.0 * wave(half) + wave(headings[1:]))
                ),
            )
        )
        for wave in (np.cos, np.sin)
    ]
    return Path(np.column_stack(points)[::4], headings[::4], curvature[::4], length)


def from_points(points):
    """Interpolates points by a cubic spline.

    Args:
        points: (n, 2) in driving order, n >= 2; repeated points count once [m].

    Returns:
        Path; its heading and curvature come from the spline.

    Raises:
        TrailerError: Fewer than two different points, one that is not finite, or too long.
    """
    points = np.asarray(points, dtype=float)
    if points.ndim != 2 or points.shape[1:] != (2,):
        raise TrailerError(f"path: points of shape {points.shape}, it must be (n, 2)")
    if not np.all(np.isfinite(points)):
        worst = int(np.argmin(np.isfinite(points).all(axis=1)))
        raise TrailerError(f"path: point {worst} is {tuple(points[worst])}, it must be finite")
    if len(points):
        apart = np.hypot(*np.diff(points, axis=0).T) > 1e-6
        points = points[np.concatenate(([True], apart))]
    if len(points) < 2:
        raise TrailerError(f"path: {len(points)} different points, it must be 2 or more")
    chords = np.concatenate(([0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))))
    if chords[-1] > LONGEST:
        raise TrailerError(f"path: {chords[-1]:.0f} m long, it must be at most {LONGEST:.0f} m")
    if len(points) == 2:
        heading = math.atan2(*(points[1] - points[0])[::-1])
        return from_curvature(np.zeros_like, chords[-1]).moved(*points[0], heading)
    spline = CubicSpline(chords, points, bc_type="natural" if len(points) == 3 else "not-a-knot")
    fine = np.linspace(0.0, chords[-1], max(4 * len(points), int(chords[-1] / (0.1 * SPACING))))
    speed = np.hypot(*spline(fine, 1).T)
    arc = np.concatenate(([0.0], np.cumsum(0.5 * np.diff(fine) * (speed[:-1] + speed[1:]))))
    count = max(3, int(math.ceil(arc[-1] / SPACING)) + 1)
    parameter = np.interp(np.linspace(0.0, arc[-1], count), arc, fine)
    first, second = spline(parameter, 1), spline(parameter, 2)
    curvature = (first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]) / np.maximum(
        np.hypot(*first.T), 1e-9
    ) ** 3
    return Path(spline(parameter), np.arctan2(first[:, 1], first[:, 0]), curvature, arc[-1])
