"""The area of a lane as valid polygons, also in tight bends; for the texture and the referee."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt
from shapely.geometry import Point, Polygon
from shapely.ops import unary_union
from shapely.prepared import prep

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


def inside(area: Any) -> Callable[[npt.ArrayLike], npt.NDArray[np.bool_]]:
    """Return the function of points (N, 2) [m] that tells which of them lie in an area, (N,)."""
    contains = prep(area).contains
    return lambda points: np.array([contains(Point(*xy)) for xy in np.asarray(points)], bool)
