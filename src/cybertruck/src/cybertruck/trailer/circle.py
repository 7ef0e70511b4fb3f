"""Circles through measured points, by least squares."""

import numpy as np
from scipy.optimize import least_squares

from cybertruck.trailer.geometry import TrailerError


def fit_circle(points):
    """Fits a circle to points: algebraically first (Kåsa), then by geometric distance.

    Args:
        points: (n, 2) in driving order, n >= 3 [m].

    Returns:
        (centre (2,) [m], signed curvature, positive for a left turn [1/m], rms distance of the
        points from the circle [m]).

    Raises:
        TrailerError: Too few points, or they lie on no circle.
    """
    points = np.asarray(points, dtype=float)
    if points.ndim != 2 or points.shape[1:] != (2,) or len(points) < 3:
        raise TrailerError(f"circle: points of shape {points.shape}; it takes (n, 2), n >= 3")
    middle = points.mean(axis=0)
    local = points - middle
    matrix = np.column_stack((2.0 * local, np.ones(len(local))))
    solution, _, rank, _ = np.linalg.lstsq(matrix, (local**2).sum(axis=1), rcond=1e-10)
    if rank < 3:
        raise TrailerError("circle: the points lie on a line")
    start = np.append(solution[:2], np.sqrt(solution[2] + solution[:2] @ solution[:2]))

    def distances(values):
        return np.hypot(*(local - values[:2]).T) - values[2]

    fit = least_squares(distances, start, x_scale=max(start[2], 1e-6))
    radius = float(fit.x[2])
    arms = local - fit.x[:2]
    turning = np.sum(arms[:-1, 0] * arms[1:, 1] - arms[:-1, 1] * arms[1:, 0])
    return middle + fit.x[:2], float(np.sign(turning) / radius), float(np.sqrt(np.mean(fit.fun**2)))
