"""A track for the referee: projections onto its centreline, poses, curvatures."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from track_model import curves
from track_model.geometry import Lane
from track_model.region import inside, lane_area

WINDOW = 1.0  # arc length around the last position that is searched [m]
HALF_SPAN = 0.05  # half the length over which a curvature is computed [m]


class Course:
    """Arc length and distance to the side on a lane, of points and arrays of them.

    Args:
        window: arc length around a known one that is searched [m].

    Attributes:
        contains: function of points (M, 2) [m]: whether each lies in the lane.
        uniform_sides: (left, right) from the centreline to the edges [m] if the lane has one width
            everywhere, else None.
    """

    def __init__(self, lane: Lane, window: float = WINDOW) -> None:
        self.lane = lane
        self.closed, self.length = lane.closed, lane.length
        self.contains = inside(lane_area(lane))
        ends = np.vstack([lane.curve, lane.curve[:1]]) if lane.closed else lane.curve
        chords = np.diff(ends, axis=0)
        lengths = np.linalg.norm(chords, axis=1)
        along = np.concatenate(([0.0], np.cumsum(lengths)))
        self._count = len(chords)
        self._step = self.length / self._count
        self._window_count = min(int(window / lengths[0]) + 1, self._count)
        low, high = np.zeros(self._count), np.ones(self._count)
        if not self.closed:
            low[0], high[-1] = -np.inf, np.inf
        self._along = along
        rows = (*ends[:-1].T, *chords.T, *(chords / lengths[:, None] ** 2).T, low, high)
        self._rows = np.array([self._padded(row) for row in (*rows, along[:-1], lengths)])
        sides = np.stack([lane.left, lane.right])
        self._sides = np.hstack([sides, sides[:, :1]]) if self.closed else sides
        uniform = not np.ptp(lane.left) and not np.ptp(lane.right)
        self.uniform_sides = (float(lane.left[0]), float(lane.right[0])) if uniform else None
        tangents = curves.tangents(lane.curve, self.closed)
        yaw = np.unwrap(np.arctan2(tangents[:, 1], tangents[:, 0]))
        if self.closed:  # one more point, a full turn or none after the first
            turns = round((yaw[-1] - yaw[0]) / (2.0 * np.pi))
            yaw = np.append(yaw, yaw[0] + 2.0 * np.pi * turns)
            self._lap_angle = 2.0 * np.pi * turns
        self._ends, self._yaw, self._yaws = ends, yaw, yaw.tolist()
        self._curvature = self._curvatures()
        self._curvature_list = self._curvature.tolist()
        self._xs, self._ys = map(self._padded, ends[:-1].T) if self.closed else ends.T
        columns = (*ends[:-1].T, *chords.T, lengths, low, high, along[:-1])
        self._chord_rows = list(zip(*(column.tolist() for column in columns)))

    def _padded(self, row: npt.NDArray[Any]) -> npt.NDArray[Any]:
        """A row of the chords, on a circuit extended by a window at both ends."""
        if not self.closed:
            return row
        return np.concatenate((row[-self._window_count :], row, row[: self._window_count]))

    def difference(self, s: float, before: float) -> float:
        """Return the signed distance [m] between two arc lengths, in the shorter direction."""
        if not self.closed:
            return s - before
        return (s - before + self.length / 2.0) % self.length - self.length / 2.0

    def project(
        self, points: npt.ArrayLike, near: float | None = None
    ) -> tuple[npt.NDArray[Any], npt.NDArray[Any]]:
        """Project points onto the centreline.

        Args:
            points: (N, 2) [m], track frame.
            near: last arc length [m]: only positions around it are searched, so that a neighboring
                part of the track never counts as progress. None: everywhere.

        Returns:
            arc lengths (N,) [m], distances to the left (N,) [m]. An open course is extended
            straight beyond both ends.
        """
        points = np.asarray(points, dtype=float)
        start, stop = self._window(near)
        x, y, cx, cy, ux, uy, low, high, along, lengths = self._rows[:, start:stop]
        dx, dy = points[:, :1] - x, points[:, 1:] - y
        fraction = np.minimum(np.maximum(dx * ux + dy * uy, low), high)
        gap_x, gap_y = dx - fraction * cx, dy - fraction * cy
        gap = gap_x * gap_x + gap_y * gap_y
        best = gap.argmin(axis=1)
        row = np.arange(len(points))
        side = cx[best] * dy[row, best] - cy[best] * dx[row, best]
        return (
            along[best] + fraction[row, best] * lengths[best],
            np.copysign(np.sqrt(gap[row, best]), side),
        )

    def locate(self, x: float, y: float, near: float | None = None) -> tuple[float, float]:
        """Arc length and distance to the left [m] of one point, see project()."""
        s, left = self.project([(x, y)], near)
        return float(s[0]), float(left[0])

    def project_point(self, x: float, y: float, near: float) -> tuple[float, float]:
        """Project one point near a known arc length, as locate(), but faster.

        Args:
            x, y: [m], track frame.
            near: arc length [m].

        Returns:
            (arc length [m], distance to the left [m]).
        """
        start, stop = self._window(near)
        dx, dy = self._xs[start:stop] - x, self._ys[start:stop] - y
        first = start + int((dx * dx + dy * dy).argmin())
        best: Any = None
        for k in (first - 1, first):  # the chords that meet in the nearest point
            if not self.closed and not 0 <= k < self._count:
                continue
            k = (k - self._window_count) % self._count if self.closed else k
            ax, ay, cx, cy, length, low, high, along = self._chord_rows[k]
            ox, oy = x - ax, y - ay
            fraction = min(max((ox * cx + oy * cy) / (length * length), low), high)
            gx, gy = ox - fraction * cx, oy - fraction * cy
            gap = gx * gx + gy * gy
            if best is None or gap < best[0]:
                best = gap, along + fraction * length, cx * oy - cy * ox
        gap, s, side = best
        return s, math.copysign(math.sqrt(gap), side)

    def point_curvature(self, s: float) -> float:
        """Curvature [1/m] of the point nearest to an arc length [m], positive to the left."""
        at = (s % self.length if self.closed else min(max(s, 0.0), self.length)) / self._step
        return self._curvature_list[int(at + 0.5)]

    def _window(self, near: float | None) -> tuple[int, int]:
        """First and last (excluded) column of the rows to search."""
        if near is None:
            return (
                (self._window_count, self._window_count + self._count)
                if self.closed
                else (0, self._count)
            )
        if self.closed:
            center = int(np.searchsorted(self._along, near % self.length))
            return center, center + 2 * self._window_count
        center = int(np.searchsorted(self._along, min(max(near, 0.0), self.length)))
        return max(0, center - self._window_count), max(
            1, min(self._count, center + self._window_count)
        )

    def sides(self, s: Any) -> Any:
        """Distances (left, right) [m] from the centreline to the lane's edges at arc lengths.

        Args:
            s: number or (N,) [m].

        Returns:
            (2,) or (2, N).
        """
        if self.uniform_sides is not None and np.ndim(s) == 0:
            return self.uniform_sides
        k, fraction = self._chord_at(s)
        return self._sides[:, k] + fraction * (self._sides[:, k + 1] - self._sides[:, k])

    def heading(self, s: float) -> float:
        """Direction [rad] of the centreline at an arc length [m], within -pi to pi."""
        at = (s % self.length if self.closed else min(max(s, 0.0), self.length)) / self._step
        k = min(int(at), self._count - 1)
        yaw = self._yaws[k]
        return math.remainder(yaw + (at - k) * (self._yaws[k + 1] - yaw), 2.0 * math.pi)

    def pose(self, s: float, lateral: float = 0.0, turn: float = 0.0) -> tuple[float, float, float]:
        """Return (x, y [m], yaw [rad]) at an arc length, beside the line and turned to the left.

        Args:
            s: Arc length [m].
            lateral: Offset to the left [m].
            turn: From the line's heading [rad].
        """
        k, fraction = self._chord_at(s)
        x, y = self._ends[k] + fraction * (self._ends[k + 1] - self._ends[k])
        yaw = self.heading(s)
        return (
            float(x) - float(lateral) * math.sin(yaw),
            float(y) + float(lateral) * math.cos(yaw),
            yaw + float(turn),
        )

    def curvature(self, s: Any) -> Any:
        """Curvatures [1/m], positive to the left, at arc lengths (N,) [m]."""
        k, fraction = self._chord_at(s)
        return self._curvature[k] + fraction * (self._curvature[k + 1] - self._curvature[k])

    def _chord_at(self, s: Any) -> tuple[Any, Any]:
        """Index of the chord at arc lengths, and the fraction along it (0 to 1)."""
        at = np.asarray(s) % self.length if self.closed else np.clip(s, 0.0, self.length)
        at = at / self._step
        k = np.minimum(at.astype(int), self._count - 1)
        return k, at - k

    def _curvatures(self) -> npt.NDArray[Any]:
        """Curvature at each point, from the directions HALF_SPAN before and after it."""
        at = np.arange(self._count + 1) * self._step
        return (self._unwrapped(at + HALF_SPAN) - self._unwrapped(at - HALF_SPAN)) / (
            2.0 * HALF_SPAN
        )

    def _unwrapped(self, s: npt.NDArray[Any]) -> npt.NDArray[Any]:
        if not self.closed:
            return np.interp(s, np.arange(self._count + 1) * self._step, self._yaw)
        laps = np.floor(s / self.length)
        at = np.arange(self._count + 1) * self._step
        return np.interp(s - laps * self.length, at, self._yaw) + laps * self._lap_angle


LEAD = 0.3  # of a start before the line of a circuit [m]
OPEN_LEAD = 0.15  # of a start after the line of an open course [m]


def standing_start(course: Course) -> float:
    """Arc length [m] at which ./run lap puts the car; a circuit's lap begins at the line after it,
    an open course's when the car moves."""
    return -LEAD if course.closed else OPEN_LEAD
