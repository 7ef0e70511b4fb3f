"""Lenses that are no pinhole: distorted and wide-angle images, warped from pinhole images.

The model of distorted ones is that of sensor_msgs/CameraInfo's plumb_bob and of OpenCV (Brown
1966): with x and y on the plane at distance 1 and r^2 = x^2 + y^2
    x' = x (1 + k1 r^2 + k2 r^4 + k3 r^6) + 2 p1 x y + p2 (r^2 + 2 x^2), and y' alike.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import lru_cache
from typing import Any

import cv2
import numpy as np

from bullet_sim.plugins.cameras import Lens
from bullet_sim.pose import Array, Pose, quaternion_from_rpy
from bullet_sim.render.request import CameraRequest
from bullet_sim.sensors import camera

WIDEST = math.tan(math.radians(80.0))  # of the pinhole that is warped, half its width at distance 1
ITERATIONS = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 100, 1e-10)


@lru_cache(maxsize=16)
def plan_pinhole(
    width: int, height: int, horizontal_fov: float, distortion: tuple[float, ...]
) -> tuple[tuple[int, int, float], Array]:
    """The pinhole to render for a lens, and where each of the lens's pixels is in its image.

    Args:
        width, height: of the lens's image [px].
        horizontal_fov: of its K [rad].
        distortion: (k1, k2, p1, p2, k3).

    Returns:
        (width, height, horizontal_fov) of the pinhole; (H, W, 2) float32 (column, row) for
        cv2.remap.
    """
    k = camera.intrinsics(width, height, horizontal_fov)
    columns, rows = np.meshgrid(np.arange(width, dtype=float), np.arange(height, dtype=float))
    pixels = np.stack([columns.ravel(), rows.ravel()], axis=1)[:, None, :]
    straight = cv2.undistortPointsIter(
        pixels, k, np.array(distortion, float), None, None, ITERATIONS
    )[:, 0, :]
    straight = np.clip(np.nan_to_num(straight), -WIDEST, WIDEST)
    focal = k[0, 0]
    extent = np.abs(straight).max(axis=0)
    size = [2 * math.ceil(focal * value) + 3 for value in extent]
    fov = 2.0 * math.atan(size[0] / (2.0 * focal))
    points = focal * straight + (np.array(size) - 1.0) / 2.0
    return (size[0], size[1], fov), points.reshape(height, width, 2).astype(np.float32)


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
MARGIN = 2  # [px] that a side's image extends beyond its edge, for what lies between two pixels
MIN_SIDE, MAX_SIDE = 64, 1024  # [px] of a side's image
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
    columns, rows = np.meshgrid(np.arange(width, dtype=float), np.arange(height, dtype=float))
    right = (columns - (width - 1) / 2.0) / (width / 2.0)
    down = (rows - (height - 1) / 2.0) / (width / 2.0)
    radius = np.hypot(right, down)
    focal = lens.f
    if lens.scaled:
        focal = 1.0 / (lens.c1 * _FUNCTION[lens.function](lens.fov / 2.0 / lens.c2 + lens.c3))
    with np.errstate(invalid="ignore"):
        theta = lens.c2 * (_INVERSE[lens.function](radius / (lens.c1 * focal)) - lens.c3)
    theta = np.where((theta >= 0.0) & (theta <= min(lens.cutoff, math.pi)), theta, np.nan)
    aside = np.sin(theta) / np.maximum(radius, 1e-12)
    return np.stack([np.cos(theta), -aside * right, -aside * down], axis=2)


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
    per_radian = width / lens.fov
    edge = int(min(max(math.ceil(1.5 * QUARTER * per_radian), MIN_SIDE), MAX_SIDE))
    focal = edge / 2.0
    size = edge + 2 * MARGIN
    sides = []
    rotated = [rays @ Pose(orientation=quaternion_from_rpy(*side)).matrix for side in SIDES]
    ahead = np.stack([np.nan_to_num(each[:, :, 0], nan=-1.0) for each in rotated])
    side_of = np.where(np.isnan(rays[:, :, 0]), -1, ahead.argmax(axis=0))
    for index, each in enumerate(rotated):
        mask = side_of == index
        if not mask.any():
            continue
        with np.errstate(invalid="ignore", divide="ignore"):
            plane = -each[:, :, 1:] / each[:, :, :1]
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
        As Renderer.image; a wide-angle lens has no depth.
    """
    rgb = np.empty((request.height, request.width, 3), np.uint8) if rgb is None else rgb
    rgb[:] = 0
    distances = None
    for pinhole, points, mask in _pinholes(request):
        colors, metres = render(pinhole)
        rgb[mask] = cv2.remap(colors, points, None, cv2.INTER_LINEAR)[mask]
        if metres is not None:  # distances are not mixed across edges
            distances = cv2.remap(metres, points, None, cv2.INTER_NEAREST, dst=depth)
    return rgb, distances


def warped_labels(render: Callable[[CameraRequest], Array], request: CameraRequest) -> Array:
    """A label image through the lens of a request; 0 where it sees nothing.

    Args:
        render: function as Renderer.label_image.
        request: with a lens or a distortion.

    Returns:
        (H, W) float32 of whole numbers: cv2.remap takes no int32.
    """
    labels = np.zeros((request.height, request.width), np.float32)
    for pinhole, points, mask in _pinholes(request):
        image = render(pinhole).astype(np.float32)  # exact below 2^24, which labels are
        labels[mask] = cv2.remap(image, points, None, cv2.INTER_NEAREST)[mask]
    return labels


def _pinholes(request: CameraRequest) -> Iterator[tuple[CameraRequest, Array, Any]]:
    """The pinholes to render: request, points of the lens's pixels in its image, their mask."""
    if request.lens is None:
        (width, height, fov), points = plan_pinhole(
            request.width, request.height, request.horizontal_fov, request.distortion
        )
        wide = replace(request, width=width, height=height, horizontal_fov=fov, distortion=())
        yield wide, points, ...
        return
    size, angle, sides = plan_sides(request.width, request.height, request.lens)
    pose = Pose.from_xyz_rpy(*request.pose)
    pinhole = replace(
        request, width=size, height=size, horizontal_fov=angle, lens=None, depth=False
    )
    for index, points, mask in sides:
        side = pose * Pose(orientation=quaternion_from_rpy(*SIDES[index]))
        yield replace(pinhole, pose=(side.position, side.rpy)), points, mask
