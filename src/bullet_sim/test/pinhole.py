"""The arithmetic of a pinhole camera, beside which images are held."""

import numpy as np

OPTICAL_FROM_CAMERA = np.array([[0.0, -1.0, 0.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0]])


def project(points_in_optical, k):
    """Pixels (n, 2) of points (n, 3) [m] in front of a camera with the matrix K."""
    uvw = np.asarray(points_in_optical, dtype=float) @ np.asarray(k).T
    return uvw[:, :2] / uvw[:, 2:]
