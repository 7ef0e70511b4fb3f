"""Triangles of boxes, cylinders and spheres, each of unit size about the origin."""

from functools import lru_cache

import numpy as np

from bullet_sim.meshes.box import CORNERS, box_sides

SIDES = 48  # of a cylinder, and around a sphere
RINGS = 24  # from pole to pole of a sphere


@lru_cache
def solid(kind):
    """Corners and triangles of a shape of size 1: an edge, a diameter of 2, a length of 1.

    Args:
        kind: 'box', 'cylinder' (along z) or 'sphere'.

    Returns:
        (n, 8) float32 position, normal, texture coordinates (right and up in the picture);
        (m, 3) uint32, counter-clockwise seen from outside.
    """
    corners, triangles = {"box": _box, "cylinder": _cylinder, "sphere": _sphere}[kind]()
    return np.asarray(corners, np.float32), np.asarray(triangles, np.uint32)


def _box():
    """Each side shows the whole picture, upright where the side stands."""
    corners, triangles = [], []
    for normal, places in box_sides():
        first = len(corners)
        for place, (a, b) in zip(places, CORNERS):
            corners.append([*place / 2.0, *normal, (a + 1) / 2.0, (b + 1) / 2.0])
        triangles += [[first, first + 1, first + 2], [first, first + 2, first + 3]]
    return corners, triangles


def _cylinder():
    corners, triangles = [], []
    angles = np.linspace(0.0, 2.0 * np.pi, SIDES + 1)
    for angle in angles:
        x, y = np.cos(angle), np.sin(angle)
        along = angle / (2.0 * np.pi)
        corners += [[x, y, -0.5, x, y, 0.0, along, 0.0], [x, y, 0.5, x, y, 0.0, along, 1.0]]
    for side in range(SIDES):
        a = 2 * side
        triangles += [[a, a + 2, a + 3], [a, a + 3, a + 1]]
    for end in (1.0, -1.0):
        first = len(corners)
        for angle in angles[:-1]:
            x, y = np.cos(angle), np.sin(angle)
            corners.append([x, y, end / 2.0, 0.0, 0.0, end, 0.5 + x / 2.0, 0.5 + end * y / 2.0])
        for side in range(1, SIDES - 1):
            pair = (side, side + 1) if end > 0 else (side + 1, side)
            triangles.append([first, first + pair[0], first + pair[1]])
    return corners, triangles


def _sphere():
    corners, triangles = [], []
    for ring in range(RINGS + 1):
        polar = np.pi * ring / RINGS
        for side in range(SIDES + 1):
            angle = 2.0 * np.pi * side / SIDES
            x, y = np.sin(polar) * np.cos(angle), np.sin(polar) * np.sin(angle)
            z = np.cos(polar)
            corners.append([x, y, z, x, y, z, side / SIDES, 1.0 - ring / RINGS])
    width = SIDES + 1
    for ring in range(RINGS):
        for side in range(SIDES):
            a = ring * width + side
            b = a + width
            if ring > 0:
                triangles.append([a, b, a + 1])
            if ring < RINGS - 1:
                triangles.append([a + 1, b, b + 1])
    return corners, triangles
