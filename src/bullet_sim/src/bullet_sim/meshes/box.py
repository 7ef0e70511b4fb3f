"""Sides of a box, each with an upright picture."""

import numpy as np

CORNERS = ((-1, -1), (1, -1), (1, 1), (-1, 1))  # of a side, to the right and up


def box_sides():
    """Sides of a box of edge 2 about the origin: normal (3,), four corners (3,) from a picture's
    lower left counter-clockwise, as seen from outside where the side stands upright."""
    for axis in range(3):
        for side in (1.0, -1.0):
            normal = np.zeros(3)
            normal[axis] = side
            right = np.array([0.0, side, 0.0]) if axis == 0 else np.array([1.0, 0.0, 0.0])
            if axis == 1:
                right = right * -side
            up = np.cross(normal, right)
            yield normal, [normal + a * right + b * up for a, b in CORNERS]
