"""Lenses that are no pinhole: distorted and wide-angle images, warped from pinhole images.

Distorted ones as Gazebo Classic 11 makes them: Brown's model (1966) moves each point of the
pinhole's image to
    x' = c + d (1 + k1 r^2 + k2 r^4 + k3 r^6) + (2 p1 dx dy + p2 (r^2 + 2 dx^2), ...), d = x - c,
with x in widths and heights of the image, so not as CameraInfo's plumb_bob has it, whose d is in
focal lengths. Points are moved one by one on a square map as wide as the longer side; holes between
them take the mean of their neighbors.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import lru_cache
from typing import Any

import cv2
import numpy as np

from bullet_sim.pose import Array, Pose, quaternion_from_rpy
from bullet_sim.render.request import CameraRequest, Distortion, Lens

NEIGHBORS = np.array([[0.707, 1.0, 0.707], [1.0, 0.0, 1.0], [0.707, 1.0, 0.707]])
MIN_SCALE = 1e-7  # of a cropped image; below it is not cropped


def distorted(points: Array, lens: Distortion, scale: float = 1.0) -> Array:
    """Where points of a pinhole's image are in the distorted one.

    Args:
        points: (..., 2) in widths and heights of the image, from its upper left corner.
        scale: of the model's lengths: the map's side over the focal length.

    Returns:
        (..., 2), likewise.
    """
    d = (points - np.array(lens.center)) * scale
    x, y = d[..., 0], d[..., 1]
    square = x * x + y * y
    radial = 1.0 + square * (lens.k1 + square * (lens.k2 + square * lens.k3))
    moved = np.stack(
        [
            x * radial + lens.p2 * (square + 2.0 * x * x) + 2.0 * lens.p1 * x * y,
            y * radial + lens.p1 * (square + 2.0 * y * y) + 2.0 * lens.p2 * x * y,
        ],
        axis=-1,
    )
    return np.array(lens.center) + moved / scale


@lru_cache(maxsize=16)
def plan_distortion(width: int, height: int, horizontal_fov: float, lens: Distortion) -> Array:
    """Where each pixel of a distorted image is in the pinhole's.

    Args:
        width, height: of both [px].
        horizontal_fov: [rad].

    Returns:
        (H, W, 2) float32 (column, row) for cv2.remap; a corner where nothing is.
    """
    side = max(width, height)
    focal = width / (2.0 * math.tan(horizontal_fov / 2.0))
    scale = 1.0 if lens.legacy else side / focal
    steps = np.arange(side) / side
    points = np.stack(np.meshgrid(steps, steps), axis=-1)
    cells = np.floor(distorted(points, lens, scale) * side)
    inside = ((cells >= 0) & (cells < side)).all(axis=-1)
    columns, rows = cells[inside].astype(int).T
    sources = np.full((side, side, 2), 0.0)
    known = np.zeros((side, side))
    sources[rows, columns], known[rows, columns] = points[inside], 1.0  # the last of several
    weights = cv2.filter2D(known, -1, NEIGHBORS, borderType=cv2.BORDER_CONSTANT)[..., None]
    means = cv2.filter2D(sources, -1, NEIGHBORS, borderType=cv2.BORDER_CONSTANT)
    means = np.divide(means, weights, out=np.zeros_like(means), where=weights > 0.5)
    sources = np.where(known[..., None] > 0.0, sources, means).astype(np.float32)
    zoom = np.ones(2)
    if lens.crop:
        low, high = distorted(np.array([[0.0, 0.0], [1.0, 1.0]]), lens, scale)
        zoom = high - low if (high - low).min() > MIN_SCALE else zoom
    x = ((np.arange(width) + 0.5) / width - 0.5) * zoom[0] + 0.5
    y = ((np.arange(height) + 0.5) / height - 0.5) * zoom[1] + 0.5
    at = np.stack(np.meshgrid(x, y), axis=-1) * side - 0.5
    places = cv2.remap(
        sources, at.astype(np.float32), None, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE
    )
    return (places * (width, height) - 0.5).astype(np.float32)


QUARTER = math.pi / 2.0
# Rotations (roll, pitch, yaw) [rad] of the cameras that look at the sides.
SIDES = (
    (0.0, 0.0, 0.0),
    (0.0, 0.0, QUARTER),
    (0.0, 0.0, -QUARTER),
    (0.0, -QUARTER, 0.0),
    (0.0, QUARTER, 0.0),
    (0.0, 0.0, 2.0 * QUARTER),
)
RIM = 0.02  # half widths of the image over which its visible circle fades to black
MARGIN = 2  # [px] that a side's image extends beyond its edge, for what lies between two pixels
_INVERSE: dict[str, Callable[[Array], Array]] = {
    "tan": np.arctan,
    "sin": np.arcsin,
    "id": np.asarray,
}
_FUNCTION: dict[str, Callable[[float], float]] = {"tan": math.tan, "sin": math.sin, "id": float}


def directions(width: int, height: int, lens: Lens) -> Array:
    """Direction of each pixel of a lens.

    Args:
        width, height: [px].

    Returns:
        (H, W, 3) in the camera frame (x ahead, y left, z up); NaN where nothing is visible.
    """
    right, down = _from_center(width, height)
    radius = np.hypot(right, down)
    focal = _focal(lens)
    with np.errstate(invalid="ignore"):
        theta = lens.c2 * (_INVERSE[lens.function](radius / (lens.c1 * focal)) - lens.c3)
    theta = np.where((theta >= 0.0) & (theta <= min(lens.cutoff, math.pi)), theta, np.nan)
    aside = np.sin(theta) / np.maximum(radius, 1e-12)
    return np.stack([np.cos(theta), -aside * right, -aside * down], axis=2)


def _from_center(width: int, height: int) -> tuple[Array, Array]:
    """How far to the right and down each pixel (H, W) is, in half widths of the image."""
    columns, rows = np.meshgrid(np.arange(width, dtype=float), np.arange(height, dtype=float))
    right = (columns - (width - 1) / 2.0) / (width / 2.0)
    return right, (rows - (height - 1) / 2.0) / (width / 2.0)


def _focal(lens: Lens) -> float:
    """Focal length in half widths of the image."""
    if not lens.scaled:
        return lens.f
    return 1.0 / (lens.c1 * _FUNCTION[lens.function](lens.fov / 2.0 / lens.c2 + lens.c3))


@lru_cache(maxsize=8)
def plan_rim(width: int, height: int, lens: Lens) -> tuple[Array, Array]:
    """The pixels of a lens that fade to black at the rim of its circle.

    As Gazebo Classic 11's wide_lens_map_fp.glsl.

    Args:
        width, height: [px].

    Returns:
        Mask (H, W) bool, the factor of their colors (n, 1) float32.
    """
    radius = np.hypot(*_from_center(width, height))
    angle = min(lens.cutoff, math.pi) / lens.c2 + lens.c3
    if lens.function != "id":
        angle = min(angle, QUARTER)
    limit = lens.c1 * _focal(lens) * _FUNCTION[lens.function](angle)
    t = (radius - limit) / RIM + 1.0
    mask = (t > 0.0) & (t < 1.0)
    t = t[mask]
    return mask, (1.0 - t * t * (3.0 - 2.0 * t)).astype(np.float32)[:, None]


@lru_cache(maxsize=8)
def plan_sides(
    width: int, height: int, lens: Lens
) -> tuple[int, float, tuple[tuple[int, Array, Array], ...]]:
    """The sides to render.

    Returns:
        Edge of a side's image [px], its angle [rad], and for each side that is visible: index, the
        points of the pixels in it (H, W, 2) float32, mask (H, W) bool.
    """
    rays = directions(width, height, lens)
    edge = lens.texture
    focal = edge / 2.0
    size = edge + 2 * MARGIN
    sides = []
    rotated = [rays @ Pose(orientation=quaternion_from_rpy(*side)).matrix for side in SIDES]
    ahead = np.stack([np.nan_to_num(turned[:, :, 0], nan=-1.0) for turned in rotated])
    side_of = np.where(np.isnan(rays[:, :, 0]), -1, ahead.argmax(axis=0))
    for index, turned in enumerate(rotated):
        mask = side_of == index
        if not mask.any():
            continue
        with np.errstate(invalid="ignore", divide="ignore"):
            plane = -turned[:, :, 1:] / turned[:, :, :1]
        points = focal * plane + (size - 1) / 2.0
        sides.append((index, np.nan_to_num(points).astype(np.float32), mask))
    return size, 2.0 * math.atan(size / (2.0 * focal)), tuple(sides)


def warped_image(
    render: Callable[[CameraRequest], tuple[Array, Array | None]],
    request: CameraRequest,
    rgb: Array | None = None,
    depth: Array | None = None,
) -> tuple[Array, Array | None]:
    """An image through the lens of a request; black where it sees nothing.

    Args:
        render: function as Renderer.image, which renders pinholes.
        request: with a lens or a distortion.
        rgb, depth: arrays that take the result; None: new ones.

    Returns:
        As Renderer.image; as in Gazebo distances are not distorted. A wide-angle lens has none.
    """
    rgb = np.empty((request.height, request.width, 3), np.uint8) if rgb is None else rgb
    if request.distortion is not None:
        colors, distances = render(replace(request, distortion=None))
        if depth is not None and distances is not None:
            depth[:] = distances
        points = _points(request, request.distortion)
        return cv2.remap(colors, points, None, cv2.INTER_LINEAR, dst=rgb), distances
    lens = request.lens or Lens(request.horizontal_fov)
    rgb[:] = 0
    for pinhole, points, mask in _sides(request, lens):
        colors, _ = render(pinhole)
        rgb[mask] = cv2.remap(colors, points, None, cv2.INTER_LINEAR)[mask]
    rim, factors = plan_rim(request.width, request.height, lens)
    rgb[rim] = rgb[rim] * factors
    return rgb, None


def warped_labels(render: Callable[[CameraRequest], Array], request: CameraRequest) -> Array:
    """A label image through the lens of a request; 0 where it sees nothing.

    Args:
        render: function as Renderer.label_image.
        request: with a lens or a distortion.

    Returns:
        (H, W) float32 of whole numbers: cv2.remap takes no int32.
    """
    if request.distortion is not None:
        image = render(replace(request, distortion=None)).astype(np.float32)
        return cv2.remap(image, _points(request, request.distortion), None, cv2.INTER_NEAREST)
    labels = np.zeros((request.height, request.width), np.float32)
    for pinhole, points, mask in _sides(request, request.lens or Lens(request.horizontal_fov)):
        image = render(pinhole).astype(np.float32)  # exact below 2^24, which labels are
        labels[mask] = cv2.remap(image, points, None, cv2.INTER_NEAREST)[mask]
    return labels


def _points(request: CameraRequest, lens: Distortion) -> Array:
    return plan_distortion(request.width, request.height, request.horizontal_fov, lens)


def _sides(request: CameraRequest, lens: Lens) -> Iterator[tuple[CameraRequest, Array, Any]]:
    """The pinholes to render: request, points of the lens's pixels in its image, their mask."""
    size, angle, sides = plan_sides(request.width, request.height, lens)
    pose = Pose.from_xyz_rpy(*request.pose)
    pinhole = replace(
        request, width=size, height=size, horizontal_fov=angle, lens=None, depth=False, samples=4
    )
    for index, points, mask in sides:
        side = pose * Pose(orientation=quaternion_from_rpy(*SIDES[index]))
        yield replace(pinhole, pose=(side.position, side.rpy)), points, mask
