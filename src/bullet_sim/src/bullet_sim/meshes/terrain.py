"""Shapes that become meshes: heightmaps from images, polygons extruded upwards."""

from __future__ import annotations

import os
from collections.abc import Iterable, Sequence

import numpy as np

from bullet_sim.errors import ModelError
from bullet_sim.meshes.read import opened
from bullet_sim.pose import Array

MAX_POINTS = 257  # per side of a heightmap; larger images are subsampled


def heightmap(path: str, size: Sequence[float]) -> tuple[Array, Array]:
    """Surface over the pixels of an image, whose top is towards +y.

    Args:
        path: of the image; brightness is the height.
        size: along x and y, height of white [m].

    Returns:
        vertices (N, 3) [m] about the center, faces (M, 3).

    Raises:
        ModelError: no such image, or fewer than 2 pixels a side.
    """
    try:
        with opened(path) as image:
            deep = image.mode.startswith("I")
            gray = np.asarray(image if deep else image.convert("L"), float)
    except (OSError, ValueError, SyntaxError) as error:
        raise ModelError(f"heightmap '{path}' cannot be read: {error}") from None
    if min(gray.shape) < 2:
        raise ModelError(f"heightmap '{path}' has {gray.shape[1]} x {gray.shape[0]} pixels")
    rows, columns = (
        np.rint(np.linspace(0, side - 1, min(side, MAX_POINTS))).astype(int) for side in gray.shape
    )
    heights = gray[np.ix_(rows, columns)] / (65535.0 if deep else 255.0)
    y = (0.5 - rows / (gray.shape[0] - 1)) * size[1]
    x = (columns / (gray.shape[1] - 1) - 0.5) * size[0]
    xs, ys = np.meshgrid(x, y)
    vertices = np.stack((xs, ys, heights * size[2]), -1).reshape(-1, 3)
    corners = np.arange(len(rows) * len(columns)).reshape(len(rows), len(columns))
    a, b, c, d = (
        part.ravel()
        for part in (corners[:-1, :-1], corners[:-1, 1:], corners[1:, :-1], corners[1:, 1:])
    )
    return vertices, np.concatenate((np.stack((a, c, b), -1), np.stack((b, c, d), -1)))


def extruded(points: Iterable[Sequence[float]], height: float) -> tuple[Array, Array]:
    """A polygon in the plane, extruded upwards by a height [m].

    Args:
        points: its corners (x, y) [m] in order, in either direction; the last may repeat the first.

    Returns:
        vertices (N, 3) [m], faces (M, 3).

    Raises:
        ModelError: fewer than three corners, or sides that cross.
    """
    corners = [np.asarray(p, float) for p in points]
    if len(corners) > 1 and np.allclose(corners[0], corners[-1]):
        corners.pop()
    if len(corners) < 3:
        raise ModelError(f"polyline has {len(corners)} corners, must have three or more")
    area = sum(_cross(p, q) for p, q in zip(corners, corners[1:] + corners[:1]))
    if area == 0.0:
        raise ModelError("polyline has no area, or sides that cross")
    if area < 0.0:
        corners.reverse()
    top = np.array(_triangles(corners))
    count = len(corners)
    flat = np.array(corners)
    vertices = np.concatenate(
        (np.c_[flat, np.zeros(count)], np.c_[flat, np.full(count, float(height))])
    )
    here, there = np.arange(count), np.roll(np.arange(count), -1)
    sides = np.concatenate(
        (
            np.stack((here, there, there + count), -1),
            np.stack((here, there + count, here + count), -1),
        )
    )
    return vertices, np.concatenate((top[:, ::-1], top + count, sides))


def _cross(p: Array, q: Array) -> float:
    return p[0] * q[1] - p[1] * q[0]


def _triangles(corners: list[Array]) -> list[tuple[int, ...]]:
    """Triangles of a counter-clockwise polygon by ear clipping (Meisters, 1975)."""
    left, faces = list(range(len(corners))), []
    while len(left) > 3:
        for k, here in enumerate(left):
            before, after = left[k - 1], left[(k + 1) % len(left)]
            if _is_ear(corners, left, before, here, after):
                faces.append((before, here, after))
                left.remove(here)
                break
        else:
            raise ModelError("polyline has sides that cross")
    return [*faces, tuple(left)]


def _is_ear(corners: list[Array], left: list[int], before: int, here: int, after: int) -> bool:
    a, b, c = corners[before], corners[here], corners[after]
    if _cross(b - a, c - a) <= 0.0:
        return False
    others = [corners[n] for n in left if n not in (before, here, after)]
    return not any(
        _cross(b - a, p - a) >= 0.0 and _cross(c - b, p - b) >= 0.0 and _cross(a - c, p - c) >= 0.0
        for p in others
    )


def write_obj(path: str, vertices: Array, faces: Array) -> None:
    """Write an OBJ file; it replaces an existing one atomically."""
    lines = [f"v {x:.9g} {y:.9g} {z:.9g}" for x, y, z in vertices.tolist()]
    lines += [f"f {a} {b} {c}" for a, b, c in (faces + 1).tolist()]
    with open(f"{path}.new", "w", encoding="ascii") as file:
        file.write("\n".join(lines) + "\n")
    os.replace(f"{path}.new", path)
