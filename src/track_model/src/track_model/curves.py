"""Curves of points: spline, even sampling, directions, radii, crossings.

A curve is an (N, 2) array of evenly spaced points [m]; a closed one does not repeat its first.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.interpolate import CubicSpline, PchipInterpolator

STEP = 0.02  # spacing of a sampled curve [m]


def spline(points: npt.ArrayLike, closed: bool, values: npt.ArrayLike | None = None) -> Any:
    """Evaluate the cubic spline (twice differentiable) through points, densely.

    Knots are spaced by the square root of the chords (centripetal; see Lee 1989, "Choosing nodes
    in parametric curve interpolation"). Closed: periodic; open: natural ends.

    Args:
        points: (P, 2) [m]; a closed curve returns from the last to the first.
        values: (P, K) numbers of the points, interpolated monotonically between them, or None.

    Returns:
        (M, 2) positions [m] with the point of each knot among them, (M, K) values or None. The
        closed curve does not repeat its first point.
    """
    points = np.asarray(points, dtype=float)
    if closed:
        points = np.vstack([points, points[:1]])
    chords = np.linalg.norm(np.diff(points, axis=0), axis=1)
    knots = np.concatenate(([0.0], np.cumsum(np.sqrt(chords))))
    curve = CubicSpline(knots, points, bc_type="periodic" if closed else "natural")
    # at most 5 mm apart, so that chords approximate arcs
    fine = np.concatenate(
        [
            np.linspace(a, b, max(4, int(chord / 0.004)), endpoint=False)
            for a, b, chord in zip(knots[:-1], knots[1:], chords)
        ]
    )
    if not closed:
        fine = np.append(fine, knots[-1])
    if values is None:
        return curve(fine), None
    values = np.asarray(values, dtype=float)
    if closed:
        values = np.vstack([values, values[:1]])
    return curve(fine), PchipInterpolator(knots, values)(fine)


def length(curve: npt.NDArray[Any], closed: bool = True) -> float:
    """Return the length of a polyline (N, 2) [m]."""
    chords = np.roll(curve, -1, axis=0) - curve if closed else np.diff(curve, axis=0)
    return float(np.linalg.norm(chords, axis=1).sum())


def resample(
    curve: npt.NDArray[Any],
    step: float = STEP,
    start: float = 0.0,
    closed: bool = True,
    values: npt.NDArray[Any] | None = None,
) -> Any:
    """Return a polyline sampled at even arc length.

    Args:
        curve: (N, 2) [m].
        step: Target spacing [m]; the nearest that divides the length is used.
        start: Arc length of the first sample [m]; an open curve starts there.
        closed: whether the last point is followed by the first.
        values: (N, K) numbers of the points, or None.

    Returns:
        (M, 2) curve, or with values: the curve and (M, K) values.
    """
    both = curve if values is None else np.hstack([curve, values])
    if closed:
        both = np.vstack([both, both[:1]])
    along = np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(both[:, :2], axis=0), axis=1))))
    if closed:
        count = max(8, int(round(along[-1] / step)))
        at = (start + along[-1] * np.arange(count) / count) % along[-1]
    else:
        at = np.linspace(start, along[-1], max(8, int(round((along[-1] - start) / step)) + 1))
    samples = np.stack([np.interp(at, along, column) for column in both.T], axis=1)
    return samples if values is None else (samples[:, :2], samples[:, 2:])


def tangents(curve: npt.NDArray[Any], closed: bool = True) -> npt.NDArray[Any]:
    """Return unit tangents (N, 2) of an evenly sampled curve."""
    if closed:
        direction = np.roll(curve, -1, axis=0) - np.roll(curve, 1, axis=0)
    else:
        direction = np.gradient(curve, axis=0)
    return direction / np.linalg.norm(direction, axis=1)[:, None]


def left_normals(curve: npt.NDArray[Any], closed: bool = True) -> npt.NDArray[Any]:
    """Return unit normals (N, 2) to the left of the driving direction."""
    return tangents(curve, closed)[:, ::-1] * (-1.0, 1.0)


def radii(curve: npt.NDArray[Any], closed: bool = True) -> npt.NDArray[Any]:
    """Return signed radii of curvature (N,) [m], positive in left bends, inf if straight."""
    t = tangents(curve, closed)
    ahead = np.roll(t, -1, axis=0)
    angle = np.arctan2(t[:, 0] * ahead[:, 1] - t[:, 1] * ahead[:, 0], (t * ahead).sum(axis=1))
    if not closed:
        angle[-1] = angle[-2]
    step = length(curve, closed) / (len(curve) - (not closed))
    with np.errstate(divide="ignore"):
        return np.where(np.abs(angle) < 1e-9, np.inf, step / angle)


def first_crossing(curve: npt.NDArray[Any], closed: bool = True) -> Any:
    """Return a point (2,) where a polyline crosses itself, or None.

    A point on a segment's line counts as left of it: a crossing at a point of the curve is one, and
    collinear segments do not cross.
    """
    a, b = curve, np.roll(curve, -1, axis=0)
    if not closed:
        a, b = a[:-1], b[:-1]
    d = b - a
    zero = 1e-9 * (d * d).sum(axis=1).max()

    def left(q: npt.NDArray[Any]) -> npt.NDArray[Any]:
        x, y = (q[None, :, k] - a[:, None, k] for k in (0, 1))
        return d[:, None, 0] * y - d[:, None, 1] * x > -zero

    parts = left(a) != left(b)
    hits = parts & parts.T
    if closed:
        hits[0, -1] = False  # neighbors
    index = np.argwhere(np.triu(hits, 2))
    return None if len(index) == 0 else a[index[0][0]]


def first_touch(curve: npt.NDArray[Any], width: Any, closed: bool = True) -> Any:
    """Return a point (2,) where two distant parts of the lane overlap, or None."""
    step = length(curve, closed) / len(curve)
    gap = np.abs(np.arange(len(curve))[:, None] - np.arange(len(curve))[None, :])
    along = step * (np.minimum(gap, len(curve) - gap) if closed else gap)
    apart = np.linalg.norm(curve[:, None] - curve[None, :], axis=2)
    index = np.argwhere((along > 1.7 * width) & (apart < width))
    return None if len(index) == 0 else curve[index[0][0]]
