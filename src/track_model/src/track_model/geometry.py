"""Geometry of a track: its lanes as areas, its surface, lines and walls."""

from dataclasses import dataclass

import numpy as np
from shapely.geometry import Polygon
from shapely.ops import unary_union

from track_model import curves
from track_model.spec import TrackError, TrackSpec


def lane_area(lane, inset=0.0):
    """Return the lane's area as a shapely geometry: the union of the pieces between its edges.

    It is built piece by piece, because the inner edge folds over in a tight bend.

    Args:
        lane: geometry.Lane.
        inset: [m] that both edges move inwards.
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


def rings(area):
    """Return the boundary rings of an area: list of (N, 2), outer ones and holes alike."""
    parts = getattr(area, "geoms", [area])
    found = []
    for part in parts:
        if part.geom_type == "Polygon" and not part.is_empty:
            found += [np.asarray(ring.coords)[:-1] for ring in (part.exterior, *part.interiors)]
    return found


class Inside:
    """Whether points lie in an area, by counting the edges to their right (even-odd rule).

    Args:
        area: shapely geometry of valid polygons.
    """

    def __init__(self, area):
        starts, ends = [], []
        for ring in rings(area):
            starts.append(ring)
            ends.append(np.roll(ring, -1, axis=0))
        self._a, self._b = np.vstack(starts), np.vstack(ends)
        rise = self._b[:, 1] - self._a[:, 1]
        self._slope = (self._b[:, 0] - self._a[:, 0]) / np.where(rise == 0, np.inf, rise)

    def __call__(self, points):
        """Return (N,) bool for points (N, 2) [m]."""
        points = np.asarray(points, dtype=float).reshape(-1, 2)
        x, y = points[:, 0, None], points[:, 1, None]
        a, b = self._a, self._b
        spans = (a[:, 1] > y) != (b[:, 1] > y)
        right = x < a[:, 0] + (y - a[:, 1]) * self._slope
        return np.count_nonzero(spans & right, axis=1) % 2 == 1


@dataclass(frozen=True)
class Lane:
    """A lane in its start frame: origin on the start line, +x in driving direction.

    Attributes:
        curve: (N, 2) centreline [m], evenly spaced; the first point is the origin.
        left, right: (N,) distances from the centreline to the lane's outer edges [m].
        closed: whether the last point is followed by the first.
        origin: (x, y, yaw) of the start frame in the track file's own frame [m], [rad].
    """

    curve: np.ndarray
    left: np.ndarray
    right: np.ndarray
    closed: bool
    origin: tuple

    @property
    def length(self) -> float:
        """Length of the centreline [m]."""
        return curves.length(self.curve, self.closed)

    def edge(self, side: float, inset: float = 0.0) -> np.ndarray:
        """Edge of the lane (N, 2): side +1 the left one, -1 the right; inset [m] inwards."""
        reach = (self.left if side > 0 else self.right) - inset
        return self.curve + side * reach[:, None] * curves.left_normals(self.curve, self.closed)


def lane(spec: TrackSpec) -> Lane:
    """Return the Lane of a TrackSpec.

    Raises:
        TrackError: The lane crosses itself; for track files also: it overlaps itself, or a bend is
            tighter than half the lane (imported routes may have such bends).
    """
    fine, sides = curves.spline(spec.points, spec.closed, spec.sides)
    whole = curves.length(fine, spec.closed)
    if spec.start_distance > whole:
        raise TrackError(
            spec.path,
            "start_distance",
            spec.start_distance,
            f"0 to {whole:.2f} m (the length of the centreline)",
        )
    coarse = curves.resample(fine, max(0.06, whole / 2000), closed=spec.closed)
    crossing = curves.first_crossing(coarse, spec.closed)
    if crossing is not None:
        raise TrackError(
            spec.path,
            "points",
            "a curve that crosses itself near ({:.2f}, {:.2f})".format(*tuple(crossing)),
            "a %s without crossings" % ("circuit" if spec.closed else "course"),
        )
    curve, sides = curves.resample(fine, curves.STEP, spec.start_distance, spec.closed, sides)
    if not spec.imported:
        _check_lane(spec, curve, coarse, sides)
    direction = curves.tangents(curve, spec.closed)[0]
    turned = (curve - curve[0]) @ np.array(
        ((direction[0], -direction[1]), (direction[1], direction[0]))
    )
    return Lane(
        turned,
        sides[:, 0],
        sides[:, 1],
        spec.closed,
        (*map(float, curve[0]), float(np.arctan2(direction[1], direction[0]))),
    )


def _check_lane(spec: TrackSpec, curve: np.ndarray, coarse: np.ndarray, sides: np.ndarray) -> None:
    bends = curves.radii(curve, spec.closed)
    inside = np.where(bends > 0, sides[:, 0], sides[:, 1])
    room = np.abs(bends) - inside
    tightest = int(np.argmin(room))
    if room[tightest] < 0.01:
        raise TrackError(
            spec.path,
            "points",
            "a bend of radius {:.2f} m near ({:.2f}, {:.2f})".format(
                abs(bends[tightest]), *curve[tightest]
            ),
            "at least %.2f m (half the lane and 1 cm)" % (inside[tightest] + 0.01),
        )
    touch = curves.first_touch(coarse, spec.width, spec.closed)
    if touch is not None:
        raise TrackError(
            spec.path,
            "points",
            "a lane that overlaps itself near ({:.2f}, {:.2f})".format(*tuple(touch)),
            f"parts at least {spec.width:.2f} m apart",
        )


def centreline(spec: TrackSpec) -> np.ndarray:
    """Return the sampled centreline (N, 2) [m] in the start frame: Lane.curve."""
    return lane(spec).curve
