"""Triangles of boxes, planes, cylinders and spheres, with normals and texture coordinates."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from bullet_sim.description.model import Geometry
from bullet_sim.pose import Array, Vec3

CORNERS = ((-1, -1), (1, -1), (1, 1), (-1, 1))  # of a side, (right, up)


@lru_cache
def solid(kind: str, sides: int = 48, rings: int = 24) -> tuple[Array, Array]:
    """Corners and triangles of a shape of size 1: an edge, a diameter of 2, a length of 1.

    Args:
        kind: 'box', 'plane' (its upper side), 'cylinder' (along z) or 'sphere'.
        sides, rings: around a round shape, and from pole to pole of a sphere.

    Returns:
        (n, 8) position, normal, texture coordinates (right and up in the image);
        (m, 3) int, counter-clockwise seen from outside.
    """
    if kind == "sphere":
        return _sphere(sides, rings)
    return _cylinder(sides) if kind == "cylinder" else _box(kind == "plane")


def factors(geometry: Geometry) -> Vec3:
    """Factors (3,) from a solid of size 1; 1 of other shapes."""
    if geometry.kind in ("mesh", "road") or not geometry.size:
        return (1.0, 1.0, 1.0)
    if geometry.kind == "cylinder":
        radius, length = geometry.size
        return (radius, radius, length)
    x, y, z = geometry.size * 3 if geometry.kind == "sphere" else geometry.size
    return (x, y, z)


def box_sides() -> list[tuple[Array, list[Array]]]:
    """Sides of a box of edge 2 about the origin: normal (3,), four corners (3,) counter-clockwise
    from the lower left of an image, seen from outside with the side upright, as in Gazebo: images
    on top and below have their right at -y."""
    found = []
    for axis in range(3):
        for side in (1.0, -1.0):
            normal = np.zeros(3)
            normal[axis] = side
            right = (np.array([0.0, side, 0.0]), np.array([-side, 0.0, 0.0]))[axis == 1]
            if axis == 2:
                right = np.array([0.0, -1.0, 0.0])
            up = np.cross(normal, right)
            found.append((normal, [normal + a * right + b * up for a, b in CORNERS]))
    return found


def _box(is_plane: bool) -> tuple[Array, Array]:
    """Each side shows the full image, upright where the side is vertical; that of a plane has its
    right at +x, and its top at +y."""
    sides = box_sides()
    if is_plane:
        up = np.array([0.0, 0.0, 1.0])
        sides = [(up, [np.array([a, b, 1.0]) for a, b in CORNERS])]
    corners = [
        [*point / 2.0, *normal, (a + 1) / 2.0, (b + 1) / 2.0]
        for normal, points in sides
        for point, (a, b) in zip(points, CORNERS)
    ]
    firsts = range(0, len(corners), 4)
    return np.array(corners), np.array([[n, n + a, n + a + 1] for n in firsts for a in (1, 2)])


def _cylinder(sides: int) -> tuple[Array, Array]:
    """Images are upside down, from +y by +x around it; on top they shrink to a corner of theirs."""
    angle = np.linspace(0.0, 2.0 * np.pi, sides + 1)
    x, y, zero = np.sin(angle), np.cos(angle), np.zeros(sides + 1)

    def ring(height: float, normal: tuple[Array | float, ...], up: float) -> Array:
        columns = np.broadcast_arrays(x, y, height, *normal, angle / (2.0 * np.pi), up)
        return np.column_stack(columns)

    k, count = np.arange(sides), sides + 1
    parts = [ring(-0.5, (x, y, zero), 1.0), ring(0.5, (x, y, zero), 0.0)]
    above = count + k
    triangles = [(k, above + 1, k + 1), (k, above, above + 1)]
    for end in (1.0, -1.0):
        middle = np.full(sides, sum(map(len, parts)))
        parts.append(np.array([[0.0, 0.0, end / 2.0, 0.0, 0.0, end, 0.0, 1.0]]))
        parts.append(ring(end / 2.0, (0.0, 0.0, end), 0.0 if end > 0.0 else 1.0))
        one, two = middle + 1 + k, middle + 2 + k
        triangles.append((middle, two, one) if end > 0.0 else (middle, one, two))
    return np.concatenate(parts), np.concatenate([np.stack(part, 1) for part in triangles])


def _sphere(sides: int, rings: int) -> tuple[Array, Array]:
    """The top of an image is at +y; its left edge is at +z, from where it goes by +x around y."""
    polar, angle = np.meshgrid(
        np.pi * np.arange(rings + 1) / rings,
        2.0 * np.pi * np.arange(sides + 1) / sides,
        indexing="ij",
    )
    around = np.sin(polar) * np.sin(angle), np.cos(polar), np.sin(polar) * np.cos(angle)
    columns = (*around, *around, angle / (2.0 * np.pi), 1.0 - polar / np.pi)
    a = (np.arange(rings)[:, None] * (sides + 1) + np.arange(sides)).ravel()
    b = a + sides + 1
    upper, lower = np.stack((a, b, a + 1), 1)[sides:], np.stack((a + 1, b, b + 1), 1)[:-sides]
    return np.stack(columns, -1).reshape(-1, 8), np.concatenate((upper, lower))
