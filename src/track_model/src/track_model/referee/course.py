"""A lane as a course: arc length and lateral distance of points."""

import numpy as np

from track_model import curves
from track_model.region import Inside, lane_area

WINDOW = 1.0  # arc length around the last position that is searched first [m]


class Course:
    """Arc length and lateral distance on a lane.

    Args:
        lane: geometry.Lane.
    """

    def __init__(self, lane):
        self.lane = lane
        self.closed, self.length = lane.closed, lane.length
        self._ends = np.vstack([lane.curve, lane.curve[:1]]) if lane.closed else lane.curve
        self._chords = np.diff(self._ends, axis=0)
        self._lengths = np.linalg.norm(self._chords, axis=1)
        self._along = np.concatenate(([0.0], np.cumsum(self._lengths)))
        self.contains = Inside(lane_area(lane))

    def project(self, x, y, near=None):
        """Project a point onto the centreline.

        Args:
            x, y: [m], track frame.
            near: last arc length [m]: only its surroundings are searched, so that a neighbouring
                part of the track never counts as progress. None: everywhere.

        Returns:
            (arc length [m], distance to the left [m]). An open course is extended
            straight beyond both ends.
        """
        point = np.array((x, y))
        start, chords, lengths = self._ends[:-1], self._chords, self._lengths
        if near is None:
            pick = np.arange(len(chords))
        else:
            reach = int(WINDOW / lengths[0]) + 1
            centre = int(
                np.searchsorted(
                    self._along,
                    near % self.length if self.closed else np.clip(near, 0, self.length),
                )
            )
            pick = np.arange(centre - reach, centre + reach)
            pick = (
                pick % len(chords) if self.closed else np.unique(np.clip(pick, 0, len(chords) - 1))
            )
        offset = point - start[pick]
        share = np.sum(offset * chords[pick], axis=1) / lengths[pick] ** 2
        low = np.zeros(len(pick))
        high = np.ones(len(pick))
        if not self.closed:
            low[pick == 0] = -np.inf
            high[pick == len(chords) - 1] = np.inf
        share = np.clip(share, low, high)
        gap = np.linalg.norm(offset - share[:, None] * chords[pick], axis=1)
        best = int(np.argmin(gap))
        k = int(pick[best])
        left = chords[k, 0] * offset[best, 1] - chords[k, 1] * offset[best, 0]
        return (
            float(self._along[k] + share[best] * lengths[k]),
            float(np.copysign(gap[best], left)),
        )

    def difference(self, s, before):
        """Return the signed distance [m] from one arc length to another, the shorter way round."""
        way = s - before
        return (way + self.length / 2.0) % self.length - self.length / 2.0 if self.closed else way

    def pose(self, s):
        """Return (x, y, yaw) of the centreline at an arc length [m]."""
        at = s % self.length if self.closed else float(np.clip(s, 0.0, self.length))
        k = min(int(np.searchsorted(self._along, at, side="right")) - 1, len(self._chords) - 1)
        x, y = self._ends[k] + (at - self._along[k]) / self._lengths[k] * self._chords[k]
        tangents = curves.tangents(self.lane.curve, self.closed)
        step = self.lane.curve.shape[0]
        a, b = tangents[k % step], tangents[(k + 1) % step]
        mixed = a + (at - self._along[k]) / self._lengths[k] * (b - a)
        return float(x), float(y), float(np.arctan2(mixed[1], mixed[0]))

    def curvature(self, s):
        """Return the centreline's curvature [1/m] at an arc length, positive to the left."""
        before, after = self.pose(s - 0.05), self.pose(s + 0.05)
        turn = (after[2] - before[2] + np.pi) % (2.0 * np.pi) - np.pi
        return float(turn / 0.1)
