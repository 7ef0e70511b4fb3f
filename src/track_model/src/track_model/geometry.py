"""The lane of a track: its centreline through the points, its edges, and its checks."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from track_model import curves
from track_model.spec import TrackError, TrackSpec


@dataclass(frozen=True)
class Lane:
    """A lane in its start frame: origin on the start line, +x in driving direction.

    Attributes:
        curve: (N, 2) centreline [m], evenly spaced; the first point is the origin.
        left, right: (N,) distances from the centreline to the lane's outer edges [m].
        closed: whether the last point is followed by the first.
        origin: (x, y, yaw) of the start frame in the track file's frame [m], [rad].
    """

    curve: npt.NDArray[Any]
    left: npt.NDArray[Any]
    right: npt.NDArray[Any]
    closed: bool
    origin: tuple[float, float, float]

    @property
    def length(self) -> float:
        """Length of the centreline [m]."""
        return curves.length(self.curve, self.closed)

    def edge(self, side: float, inset: float = 0.0) -> npt.NDArray[Any]:
        """Edge of the lane (N, 2): side +1 the left one, -1 the right; inset [m] inwards."""
        distance = (self.left if side > 0 else self.right) - inset
        return self.curve + side * distance[:, None] * curves.left_normals(self.curve, self.closed)


def lane(spec: TrackSpec) -> Lane:
    """Return the Lane of a TrackSpec.

    Raises:
        TrackError: The lane crosses itself; for track files also: it overlaps itself, or a bend is
            tighter than half the lane (allowed in imported routes).
    """
    fine, sides = curves.spline(spec.points, spec.closed, spec.sides)
    length = curves.length(fine, spec.closed)
    if spec.start_distance > length:
        raise TrackError(
            spec.path,
            "start_distance",
            spec.start_distance,
            f"0 to {length:.2f} m (the length of the centreline)",
        )
    coarse = curves.resample(fine, max(0.06, length / 2000), closed=spec.closed)
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
    rotated = (curve - curve[0]) @ np.array(
        ((direction[0], -direction[1]), (direction[1], direction[0]))
    )
    return Lane(
        rotated,
        sides[:, 0],
        sides[:, 1],
        spec.closed,
        (
            float(curve[0, 0]),
            float(curve[0, 1]),
            float(np.arctan2(direction[1], direction[0])),
        ),
    )


def _check_lane(
    spec: TrackSpec, curve: npt.NDArray[Any], coarse: npt.NDArray[Any], sides: npt.NDArray[Any]
) -> None:
    bends = curves.radii(curve, spec.closed)
    inside = np.where(bends > 0, sides[:, 0], sides[:, 1])
    margin = np.abs(bends) - inside
    tightest = int(np.argmin(margin))
    if margin[tightest] < 0.01:
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
