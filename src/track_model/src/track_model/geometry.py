"""Centreline geometry: closed spline through points, checks, start frame, offset curves."""
import numpy as np

from track_model.spec import TrackError

STEP = 0.02     # spacing of the sampled centreline [m]


def periodic_spline(points, parameters):
    """Evaluate the closed natural cubic spline (twice differentiable) through points.

    Args:
        points: (P, 2) knots [m]; the curve returns from the last to the first.
        parameters: (M,) in [0, P'), where P' is the summed square-root chord length
            (centripetal knots; see Lee 1989, "Choosing nodes in parametric curve interpolation").

    Returns:
        (M, 2) positions [m].
    """
    points = np.asarray(points, dtype=float)
    step = _knot_steps(points)
    count = len(points)
    before, after = np.roll(step, 1), step
    rows = np.arange(count)
    matrix = np.zeros((count, count))
    # Second derivatives m: h0 m[i-1] + 2 (h0 + h1) m[i] + h1 m[i+1] = 6 (slope jump).
    np.add.at(matrix, (rows, (rows - 1) % count), before)
    np.add.at(matrix, (rows, rows), 2.0 * (before + after))
    np.add.at(matrix, (rows, (rows + 1) % count), after)
    slope = (np.roll(points, -1, axis=0) - points) / step[:, None]
    bend = np.linalg.solve(matrix, 6.0 * (slope - np.roll(slope, 1, axis=0)))
    knots = np.concatenate(([0.0], np.cumsum(step)))
    i = np.clip(np.searchsorted(knots, parameters, side='right') - 1, 0, count - 1)
    j = (i + 1) % count
    a, b = (knots[i + 1] - parameters)[:, None], (parameters - knots[i])[:, None]
    h = step[i][:, None]
    return ((bend[i] * a ** 3 + bend[j] * b ** 3) / (6.0 * h)
            + (points[i] / h - bend[i] * h / 6.0) * a + (points[j] / h - bend[j] * h / 6.0) * b)


def _knot_steps(points):
    return np.sqrt(np.linalg.norm(np.roll(points, -1, axis=0) - points, axis=1))


def closed_length(curve):
    """Return the length of a closed polyline (N, 2) [m]."""
    return float(np.linalg.norm(np.roll(curve, -1, axis=0) - curve, axis=1).sum())


def resample(curve, step=STEP, start=0.0):
    """Return a closed polyline sampled at even arc length.

    Args:
        curve: (N, 2) [m].
        step: Wanted spacing [m]; the nearest that divides the length is taken.
        start: Arc length of the first sample [m].
    """
    closed = np.vstack([curve, curve[:1]])
    along = np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(closed, axis=0), axis=1))))
    count = max(8, int(round(along[-1] / step)))
    at = (start + along[-1] * np.arange(count) / count) % along[-1]
    return np.stack([np.interp(at, along, closed[:, axis]) for axis in (0, 1)], axis=1)


def tangents(curve):
    """Return unit tangents (N, 2) of an evenly sampled closed curve."""
    direction = np.roll(curve, -1, axis=0) - np.roll(curve, 1, axis=0)
    return direction / np.linalg.norm(direction, axis=1)[:, None]


def left_normals(curve):
    """Return unit normals (N, 2) to the left of the driving direction."""
    return tangents(curve)[:, ::-1] * (-1.0, 1.0)


def offset(curve, distance):
    """Return the curve moved to its left by a distance [m]."""
    return curve + distance * left_normals(curve)


def radii(curve):
    """Return signed radii of curvature (N,) [m], positive in left turns, inf if straight."""
    t = tangents(curve)
    ahead = np.roll(t, -1, axis=0)
    turn = np.arctan2(t[:, 0] * ahead[:, 1] - t[:, 1] * ahead[:, 0], (t * ahead).sum(axis=1))
    step = closed_length(curve) / len(curve)
    with np.errstate(divide='ignore'):
        return np.where(np.abs(turn) < 1e-9, np.inf, step / turn)


def first_crossing(curve):
    """Return a point (2,) where a closed polyline crosses itself, or None."""
    a, b = curve, np.roll(curve, -1, axis=0)
    d = b - a

    def side(p, direction, q):
        return direction[:, None, 0] * (q[None, :, 1] - p[:, None, 1]) \
            - direction[:, None, 1] * (q[None, :, 0] - p[:, None, 0])

    ends = side(a, d, a) * side(a, d, b)
    hits = (ends < 0.0) & (ends.T < 0.0)
    index = np.argwhere(np.triu(hits, 2))
    return None if len(index) == 0 else a[index[0][0]]


def first_touch(curve, width):
    """Return a point (2,) where two far parts of the lane overlap, or None."""
    step = closed_length(curve) / len(curve)
    gap = np.abs(np.arange(len(curve))[:, None] - np.arange(len(curve))[None, :])
    along = step * np.minimum(gap, len(curve) - gap)
    apart = np.linalg.norm(curve[:, None] - curve[None, :], axis=2)
    index = np.argwhere((along > 1.7 * width) & (apart < width))
    return None if len(index) == 0 else curve[index[0][0]]


def centreline(spec):
    """Return the sampled centreline (N, 2) [m] in the start frame.

    The first sample is the origin and the driving direction there is +x.

    Args:
        spec: TrackSpec.

    Raises:
        TrackError: The lane crosses or overlaps itself, or a bend is too tight.
    """
    points = np.array(spec.points)
    end = _knot_steps(points).sum()
    fine = periodic_spline(points, np.linspace(0.0, end, 200 * len(points), endpoint=False))
    length = closed_length(fine)
    if spec.start_distance > length:
        raise TrackError(spec.path, 'start_distance', spec.start_distance,
                         '0 to %.2f m (the length of the centreline)' % length)
    coarse = resample(fine, 0.06)
    crossing = first_crossing(coarse)
    if crossing is not None:
        raise TrackError(spec.path, 'points', 'a curve that crosses itself near (%.2f, %.2f)'
                         % tuple(crossing), 'a circuit without crossings')
    curve = resample(fine, STEP, spec.start_distance)
    bends = np.abs(radii(curve))
    tightest = int(np.argmin(bends))
    least = spec.width / 2.0 + 0.01
    if bends[tightest] < least:
        raise TrackError(spec.path, 'points', 'a bend of radius %.2f m near (%.2f, %.2f)'
                         % (bends[tightest], *curve[tightest]),
                         'at least %.2f m (half the lane and 1 cm)' % least)
    touch = first_touch(coarse, spec.width)
    if touch is not None:
        raise TrackError(spec.path, 'points', 'a lane that overlaps itself near (%.2f, %.2f)'
                         % tuple(touch), 'parts at least %.2f m apart' % spec.width)
    cosine, sine = tangents(curve)[0]
    return (curve - curve[0]) @ np.array(((cosine, -sine), (sine, cosine)))
