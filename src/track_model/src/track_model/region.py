"""The area of a lane as valid polygons, also in tight bends; for the texture and the referee."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
from shapely.geometry import Polygon
from shapely.ops import unary_union

from track_model.geometry import Lane


def lane_area(lane: Lane, inset: float = 0.0) -> Any:
    """Return the lane's area as a shapely geometry: the union of the pieces between its edges.

    It is built piece by piece, because the inner edge folds over in a tight bend.

    Args:
        inset: distance by which both edges move inwards [m].
    """
    left, right = lane.edge(1.0, inset), lane.edge(-1.0, inset)
    ends = np.arange(len(lane.curve) - (not lane.closed))
    after = (ends + 1) % len(lane.curve)
    pieces = []
    for a, b in zip(ends, after):
        corners = np.array([right[a], right[b], left[b], left[a]])
        piece = Polygon(corners)
        pieces.append(piece if piece.is_valid else piece.convex_hull)
    return unary_union(pieces)


def rings(area: Any) -> list[npt.NDArray[Any]]:
    """Return the boundary rings of an area: list of (N, 2), outer ones and holes alike."""
    parts = getattr(area, "geoms", [area])
    boundaries: list[npt.NDArray[Any]] = []
    for part in parts:
        if part.geom_type == "Polygon" and not part.is_empty:
            boundaries += [
                np.asarray(ring.coords)[:-1] for ring in (part.exterior, *part.interiors)
            ]
    return boundaries


class Inside:
    """Whether points lie in an area, by counting the edges to their right (even-odd rule).

    Args:
        area: shapely geometry of valid polygons.
    """

    def __init__(self, area: Any) -> None:
        starts, ends = [], []
        for ring in rings(area):
            starts.append(ring)
            ends.append(np.roll(ring, -1, axis=0))
        self._a, self._b = np.vstack(starts), np.vstack(ends)
        rise = self._b[:, 1] - self._a[:, 1]
        self._slope = (self._b[:, 0] - self._a[:, 0]) / np.where(rise == 0, np.inf, rise)

    def __call__(self, points: npt.ArrayLike) -> npt.NDArray[np.bool_]:
        """Return (N,) bool for points (N, 2) [m]."""
        points = np.asarray(points, dtype=float).reshape(-1, 2)
        x, y = points[:, 0, None], points[:, 1, None]
        a, b = self._a, self._b
        spans = (a[:, 1] > y) != (b[:, 1] > y)
        right = x < a[:, 0] + (y - a[:, 1]) * self._slope
        return np.count_nonzero(spans & right, axis=1) % 2 == 1
