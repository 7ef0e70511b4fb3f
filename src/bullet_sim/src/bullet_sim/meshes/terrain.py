"""Shapes that become meshes: heightmaps, polygons extruded upwards."""

from __future__ import annotations

import os
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from bullet_sim.errors import ModelError
from bullet_sim.meshes import elevation
from bullet_sim.meshes.read import opened
from bullet_sim.pose import Array

if TYPE_CHECKING:
    from PIL import Image

STRAIGHT = 0.97  # cosine of an angle beyond which a bend of a road is none
STRIP = 256  # rows of an image that are read at once
MAX_POINTS = 513  # per side of a heightmap as a mesh; larger ones are subsampled
MAX_GRID = 4097  # per side of one on which bodies rest


def heightmap(path: str, size: Sequence[float], sampling: int = 1) -> tuple[Array, Array]:
    """Surface over the pixels of an image or the points of elevation data, the top towards +y.

    As in Gazebo the brightest pixel has the full height, whatever its brightness, and of colors
    blue counts; but where an image of 8 bits has the value 1, white has it: ignition::math::Color
    takes 1 for white.
    Elevation data have the height between their lowest point, which stays where it is, and highest.

    Args:
        path: of the image, whose brightness is the height, or of elevation data.
        size: along x and y, height of the brightest pixel or between the ends [m].
        sampling: points for each pixel and side, those between pixels interpolated; fewer where
            they would be more than MAX_POINTS.

    Returns:
        vertices (N, 3) [m] about the center, faces (M, 3).

    Raises:
        ModelError: no such image, or fewer than 2 pixels a side.
    """
    return _surface(_heights(path, size, sampling, MAX_POINTS), size)


def grid(path: str, size: Sequence[float], sampling: int) -> Array:
    """Heights (rows, columns) [m] of heightmap(), in single precision as in Gazebo and with up to
    MAX_GRID points a side; the first row is the one at +y."""
    return _heights(path, size, sampling, MAX_GRID).astype(np.float32)


def _heights(path: str, size: Sequence[float], sampling: int, most: int) -> Array:
    """Heights (rows, columns) of a heightmap [m], at most so many a side, see heightmap()."""
    if elevation.is_elevation(path):
        found = elevation.read(path)
        low, part = _points(found.side, sampling, most)
        rows = np.unique(np.concatenate((low, low + 1)))
        at = np.searchsorted(rows, low)
        raw = _between(_between(found.at(rows).astype(float), at, part, 0), at, part, 1)
        return found.scaled(raw, size[2])
    try:
        with opened(path) as image:
            if min(image.size) < 2:
                raise ModelError(f"heightmap '{path}' has {image.size[0]} x {image.size[1]} pixels")
            across, (low, part) = (_points(count, sampling, most) for count in image.size)
            rows = np.unique(np.concatenate((low, low + 1)))
            kept, top = _rows(image, rows)
        del image  # its pixels
    except (OSError, ValueError, SyntaxError) as error:
        if isinstance(error, ModelError):
            raise
        raise ModelError(f"heightmap '{path}' cannot be read: {error}") from None
    at = np.searchsorted(rows, low)
    white = 255.0
    along = _between(kept / white, *across, 1).astype(np.float32)
    return _between(along, at, part, 0) * (size[2] / float(np.float32(top / white)))


def _rows(image: Image.Image, rows: Array) -> tuple[Array, float]:
    """Some rows of an image, and which value is the full height; strip by strip, as all of a large
    one are much memory as numbers. Of a colored one blue counts, and its value where the image is
    brightest, as in Gazebo."""
    deep, (width, height) = image.mode.startswith("I"), image.size
    if not deep:
        image = image.convert("L" if image.mode in ("1", "L", "LA", "P", "PA") else "RGB")
    kept, top, brightest = [], 0.0, -1.0
    for start in range(0, height, STRIP):
        end = min(start + STRIP, height)
        strip = np.asarray(image.crop((0, start, width, end)))
        shades = strip if deep else np.where(strip == 1, 255, strip)
        sums, blue = (shades.sum(-1), shades[..., -1]) if strip.ndim == 3 else (shades, shades)
        if float(sums.max()) > brightest:
            brightest, top = float(sums.max()), float(blue.flat[sums.argmax()])
        strip = strip[..., -1] if strip.ndim == 3 else strip
        kept.append(strip[rows[(rows >= start) & (rows < end)] - start])
    return np.concatenate(kept), top or 1.0


def _surface(heights: Array, size: Sequence[float]) -> tuple[Array, Array]:
    """Vertices and faces of _heights(), see heightmap()."""
    count = heights.shape
    y, x = np.linspace(0.5, -0.5, count[0]) * size[1], np.linspace(-0.5, 0.5, count[1]) * size[0]
    xs, ys = np.meshgrid(x, y)
    vertices = np.stack((xs, ys, heights), -1).reshape(-1, 3)
    corners = np.arange(heights.size).reshape(count)
    a, b, c, d = (
        part.ravel()
        for part in (corners[:-1, :-1], corners[:-1, 1:], corners[1:, :-1], corners[1:, 1:])
    )
    return vertices, np.concatenate((np.stack((a, c, b), -1), np.stack((b, c, d), -1)))


def relief(path: str, size: Sequence[float], sampling: int) -> tuple[Array, Array]:
    """A heightmap to be seen: corners (N, 8) with smooth normals and texture coordinates from its
    lower left corner (0, 0) to its upper right one (1, 1), and triangles, see heightmap()."""
    heights = _heights(path, size, sampling, MAX_POINTS)
    vertices, faces = _surface(heights, size)
    rows, columns = heights.shape
    down, right = np.gradient(heights, size[1] / (rows - 1), size[0] / (columns - 1))
    corners = np.zeros((len(vertices), 8))
    corners[:, :3] = vertices
    normals = np.stack((-right.ravel(), down.ravel(), np.ones(heights.size)), 1)
    corners[:, 3:6] = normals / np.linalg.norm(normals, axis=1, keepdims=True)
    corners[:, 6:] = vertices[:, :2] / np.asarray(size[:2]) + 0.5
    return corners, faces


def _points(count: int, sampling: int, most: int) -> tuple[Array, Array]:
    """`sampling` points for each of `count` along a side, but not more than `most` in all: the one
    before each, and how far behind that it is."""
    factor = min(max(sampling, 1), max((most - 1) // (count - 1), 1))
    points = min((count - 1) * factor + 1, most)
    at = np.linspace(0.0, count - 1.0, points)
    low = np.minimum(at.astype(int), count - 2)
    return low, at - low


def _between(heights: Array, low: Array, part: Array, axis: int) -> Array:
    """Heights at points of _points() along an axis."""
    one, other = np.take(heights, low, axis), np.take(heights, low + 1, axis)
    return one + (other - one) * np.expand_dims(part, 1 - axis)


def extruded(outlines: Iterable[Sequence[Sequence[float]]], height: float) -> tuple[Array, Array]:
    """Polygons in the plane, extruded upwards by a height [m].

    What an odd number of outlines surrounds is filled, as in Gazebo: one within another is a hole.

    Args:
        outlines: corners (x, y) [m] of each in order, in either direction; the last may repeat the
            first.

    Returns:
        vertices (N, 3) [m], faces (M, 3).

    Raises:
        ModelError: fewer than three corners, or sides that cross.
    """
    rings = [_ring(points) for points in outlines]
    depths = [
        sum(_surrounds(other, ring[0]) for other in rings if other is not ring) for ring in rings
    ]
    rings = [ring[::-1] if depth % 2 else ring for ring, depth in zip(rings, depths)]
    firsts = np.cumsum([0] + [len(ring) for ring in rings])
    flat = np.concatenate(rings)
    count = len(flat)
    faces = []
    for outer, depth in enumerate(depths):
        if depth % 2:
            continue
        holes = [
            number
            for number, other in enumerate(depths)
            if other == depth + 1 and _surrounds(rings[outer], rings[number][0])
        ]
        path = _joined(flat, *(list(range(*firsts[n : n + 2])) for n in (outer, *holes)))
        top = np.array(path)[np.array(_triangles([flat[n] for n in path]))]
        faces += [top[:, ::-1], top + count]
    for start, end in zip(firsts[:-1], firsts[1:]):
        here = np.arange(start, end)
        there = np.roll(here, -1)
        faces.append(np.stack((here, there, there + count), -1))
        faces.append(np.stack((here, there + count, here + count), -1))
    low, high = np.zeros(count), np.full(count, float(height))
    return np.concatenate((np.c_[flat, low], np.c_[flat, high])), np.concatenate(faces)


def road(points: Sequence[Sequence[float]], width: float) -> tuple[Array, Array]:
    """A strip of a width [m] along points, as Gazebo's Road2d makes it.

    Its ends are square, at bends it is as much wider as keeps its edges apart; an image lies
    across it, and repeats after each width along it.

    Args:
        points: (x, y, z) [m] of its middle, two or more.

    Returns:
        corners (N, 8): position [m], normal, texture coordinates; triangles (M, 3), seen from
        above.
    """
    middle = np.asarray(points, float)
    steps = np.diff(middle, axis=0)
    lengths = np.linalg.norm(steps, axis=1)
    units = steps / np.maximum(lengths, 1e-12)[:, None]
    tangents = np.vstack([units[:1], middle[2:] - middle[:-2], units[-1:]])
    bends = -(units[:-1] * units[1:]).sum(axis=1)
    bent = np.abs(bends) < STRAIGHT
    factors = np.ones(len(middle))
    factors[1:-1][bent] = 1.0 / np.sin(np.arccos(bends[bent]) / 2.0)
    theta = np.arctan2(tangents[:, 0], -tangents[:, 1])
    aside = np.stack([np.cos(theta), np.sin(theta), np.zeros(len(middle))], axis=1)
    aside *= (factors * width / 2.0)[:, None]
    corners = np.zeros((len(middle), 2, 8))
    corners[:, 0, :3], corners[:, 1, :3] = middle + aside, middle - aside
    corners[:, :, 5] = 1.0
    corners[:, 1, 6] = 1.0
    corners[:, :, 7] = -np.concatenate([[0.0], np.cumsum(lengths)])[:, None] / width
    first = 2 * np.arange(len(middle) - 1)[:, None]
    triangles = np.concatenate([first + (0, 1, 3), first + (0, 3, 2)])
    return corners.reshape(-1, 8), triangles


def _ring(points: Sequence[Sequence[float]]) -> Array:
    """Corners (n, 2) of an outline, counter-clockwise, the last not the first again."""
    corners = [np.asarray(p, float) for p in points]
    if len(corners) > 1 and np.allclose(corners[0], corners[-1]):
        corners.pop()
    if len(corners) < 3:
        raise ModelError(f"polyline has {len(corners)} corners, must have three or more")
    area = sum(_cross(p, q) for p, q in zip(corners, corners[1:] + corners[:1]))
    if area == 0.0:
        raise ModelError("polyline has no area, or sides that cross")
    return np.array(corners if area > 0.0 else corners[::-1])


def _cross(p: Array, q: Array) -> float:
    return p[0] * q[1] - p[1] * q[0]


def _surrounds(ring: Array, point: Array) -> bool:
    """Whether a point is within an outline: a ray from it crosses an odd number of sides."""
    x, y = (ring - point).T
    next_x, next_y = np.roll(x, -1), np.roll(y, -1)
    crossing = (y > 0.0) != (next_y > 0.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        at = x - y * (next_x - x) / (next_y - y)
    return bool(np.count_nonzero(crossing & (at > 0.0)) % 2)


def _joined(flat: Array, outer: list[int], *holes: list[int]) -> list[int]:
    """One path along an outline and its holes, to and fro between them (Eberly 2002).

    Args:
        flat: corners (n, 2) of all; the paths have their numbers.
    """
    path, left = outer, sorted(holes, key=lambda hole: -flat[hole, 0].max())
    while left:
        hole = left[0]
        start = int(flat[hole, 0].argmax())
        point = flat[hole[start]]
        near = np.argsort(np.linalg.norm(flat[path] - point, axis=1), kind="stable")
        sides = [(ring, ring[1:] + ring[:1]) for ring in (path, *left)]
        ends = [(a, b) for ring, after in sides for a, b in zip(ring, after)]
        for place in near.tolist():
            one, other = hole[start], path[place]
            if not any(_crosses(flat, one, other, a, b) for a, b in ends):
                break
        else:
            raise ModelError("polyline has sides that cross")
        path = path[: place + 1] + hole[start:] + hole[: start + 1] + path[place:]
        left = left[1:]
    return path


def _crosses(flat: Array, a: int, b: int, c: int, d: int) -> bool:
    """Whether a segment crosses or touches another with which it has no corner in common."""
    if {a, b} & {c, d}:
        return False
    p, q, r, s = flat[a], flat[b], flat[c], flat[d]
    one = _cross(q - p, r - p), _cross(q - p, s - p)
    other = _cross(s - r, p - r), _cross(s - r, q - r)
    return min(one) <= 0.0 <= max(one) and min(other) <= 0.0 <= max(other)


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
    others = np.array([corners[n] for n in left if n not in (before, here, after)])
    own = (others[:, None] == np.array((a, b, c))).all(-1).any(-1)  # where paths go to and fro
    x, y = others[~own].T
    inside = [
        (q[0] - p[0]) * (y - p[1]) - (q[1] - p[1]) * (x - p[0]) >= 0.0
        for p, q in ((a, b), (b, c), (c, a))
    ]
    return not bool((inside[0] & inside[1] & inside[2]).any())


def write_obj(path: str, vertices: Array, faces: Array) -> None:
    """Write an OBJ file; it replaces an existing one atomically."""
    lines = [f"v {x:.9g} {y:.9g} {z:.9g}" for x, y, z in vertices.tolist()]
    lines += [f"f {a} {b} {c}" for a, b, c in (faces + 1).tolist()]
    with open(f"{path}.new", "w", encoding="ascii") as file:
        file.write("\n".join(lines) + "\n")
    os.replace(f"{path}.new", path)
