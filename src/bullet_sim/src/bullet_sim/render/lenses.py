"""Lenses that are no pinhole: distorted and wide-angle pictures from pinhole pictures.

Lenses that bend lines: pictures of a wider pinhole, warped.

The model is that of sensor_msgs/CameraInfo's plumb_bob and of OpenCV (Brown 1966): with x and y on
the plane at distance 1 and r^2 = x^2 + y^2
    x' = x (1 + k1 r^2 + k2 r^4 + k3 r^6) + 2 p1 x y + p2 (r^2 + 2 x^2), and y' alike.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import lru_cache

import cv2
import numpy as np

from bullet_sim.plugins.cameras import Lens
from bullet_sim.pose import Array, Pose, quaternion_from_rpy
from bullet_sim.render.request import CameraRequest
from bullet_sim.sensors import camera

Draw = Callable[[CameraRequest], tuple[Array, Array | None]]  # Pictures.picture
DrawLabels = Callable[[CameraRequest], Array]  # Pictures.label_picture

WIDEST = math.tan(math.radians(80.0))  # of the pinhole that is warped, half its width at distance 1
ITERATIONS = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 100, 1e-10)


@lru_cache(maxsize=16)
def plan_pinhole(
    width: int, height: int, horizontal_fov: float, distortion: tuple[float, ...]
) -> tuple[tuple[int, int, float], Array]:
    """The pinhole to draw for a lens, and where each of the lens's pixels is in its picture.

    Args:
        width, height: of the lens's picture [px].
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
    reach = np.abs(straight).max(axis=0)
    size = [2 * math.ceil(focal * value) + 3 for value in reach]
    fov = 2.0 * math.atan(size[0] / (2.0 * focal))
    places = focal * straight + (np.array(size) - 1.0) / 2.0
    return (size[0], size[1], fov), places.reshape(height, width, 2).astype(np.float32)


def distorted_picture(
    draw: Draw, request: CameraRequest, rgb: Array | None = None, depth: Array | None = None
) -> tuple[Array, Array | None]:
    """A picture through the lens of a request.

    Args:
        draw: function as Pictures.picture, which draws pinholes.
        request: CameraRequest with a distortion.
        rgb, depth: arrays that take the result; None: new ones.

    Returns:
        As Pictures.picture.
    """
    wide, places = _pinhole(request)
    colors, metres = draw(wide)
    warped: Array = cv2.remap(colors, places, None, cv2.INTER_LINEAR, dst=rgb)
    if metres is None:
        return warped, None
    # distances are not mixed across edges
    return warped, cv2.remap(metres, places, None, cv2.INTER_NEAREST, dst=depth)


def distorted_labels(draw: DrawLabels, request: CameraRequest) -> Array:
    """A label image through the lens of a request.

    Args:
        draw: function as Pictures.label_picture.
        request: CameraRequest with a distortion.

    Returns:
        (H, W) float32 of whole numbers, as draw gives them.
    """
    wide, places = _pinhole(request)
    # cv2.remap takes no int32; float32 is exact for numbers below 2^24, which labels are.
    return cv2.remap(draw(wide).astype(np.float32), places, None, cv2.INTER_NEAREST)


def _pinhole(request: CameraRequest) -> tuple[CameraRequest, Array]:
    """The request of the pinhole to draw, and where the lens's pixels are in its picture."""
    (width, height, fov), places = plan_pinhole(
        request.width, request.height, request.horizontal_fov, request.distortion
    )
    wide = replace(request, width=width, height=height, horizontal_fov=fov, distortion=())
    return wide, places


QUARTER = math.pi / 2.0
# Turns (roll, pitch, yaw) [rad] of the cameras that look at the sides.
SIDES = (
    (0.0, 0.0, 0.0),
    (0.0, 0.0, QUARTER),
    (0.0, 0.0, -QUARTER),
    (0.0, -QUARTER, 0.0),
    (0.0, QUARTER, 0.0),
    (0.0, 0.0, 2.0 * QUARTER),
)
MARGIN = 2  # [px] that a side's picture goes beyond its edge, for what lies between two pixels
SMALLEST, LARGEST = 64, 1024  # [px] of a side's picture
_INVERSE: dict[str, Callable[[Array], Array]] = {
    "tan": np.arctan,
    "sin": np.arcsin,
    "id": np.asarray,
}
_FUNCTION: dict[str, Callable[[float], float]] = {"tan": math.tan, "sin": math.sin, "id": float}


def directions(width: int, height: int, lens: Lens) -> Array:
    """Where each pixel of a lens looks.

    Args:
        width, height: [px].
        lens: Lens.

    Returns:
        (H, W, 3) in the camera frame (x ahead, y left, z up); NaN where nothing is seen.
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
    """The sides to draw.

    Returns:
        Edge of a side's picture [px], its angle [rad], and for each side that is seen: number, the
        places of the pixels in it (H, W, 2) float32, mask (H, W) bool.
    """
    looks = directions(width, height, lens)
    per_radian = width / lens.fov
    edge = int(min(max(math.ceil(1.5 * QUARTER * per_radian), SMALLEST), LARGEST))
    focal = edge / 2.0
    size = edge + 2 * MARGIN
    found = []
    turned = [looks @ Pose(orientation=quaternion_from_rpy(*side)).matrix for side in SIDES]
    ahead = np.stack([np.nan_to_num(look[:, :, 0], nan=-1.0) for look in turned])
    nearest = np.where(np.isnan(looks[:, :, 0]), -1, ahead.argmax(axis=0))
    for number, look in enumerate(turned):
        mask = nearest == number
        if not mask.any():
            continue
        with np.errstate(invalid="ignore", divide="ignore"):
            plane = -look[:, :, 1:] / look[:, :, :1]
        places = focal * plane + (size - 1) / 2.0
        found.append((number, np.nan_to_num(places).astype(np.float32), mask))
    return size, 2.0 * math.atan(size / (2.0 * focal)), tuple(found)


def wide_picture(draw: Draw, request: CameraRequest, rgb: Array | None = None) -> Array:
    """A picture through the Lens of a request; black where it sees nothing.

    Args:
        draw: function as Pictures.picture, which draws pinholes.
        request: CameraRequest with a lens.
        rgb: array that takes the result; None: a new one.

    Returns:
        (H, W, 3) uint8.
    """
    rgb = np.empty((request.height, request.width, 3), np.uint8) if rgb is None else rgb
    rgb[:] = 0
    for side, places, mask in _sides(request):
        colors, _ = draw(side)
        rgb[mask] = cv2.remap(colors, places, None, cv2.INTER_LINEAR)[mask]
    return rgb


def wide_labels(draw: DrawLabels, request: CameraRequest) -> Array:
    """A label image through the Lens of a request; 0 where it sees nothing.

    Args:
        draw: function as Pictures.label_picture.
        request: CameraRequest with a lens.

    Returns:
        (H, W) float32 of whole numbers, as draw gives them.
    """
    found = np.zeros((request.height, request.width), np.float32)
    for side, places, mask in _sides(request):
        seen = draw(side).astype(np.float32)  # exact below 2^24
        found[mask] = cv2.remap(seen, places, None, cv2.INTER_NEAREST)[mask]
    return found


def _sides(request: CameraRequest) -> Iterator[tuple[CameraRequest, Array, Array]]:
    """For each side that is seen: request of its pinhole, places of the pixels in it, mask."""
    size, angle, sides = plan_sides(request.width, request.height, request.lens)
    pose = Pose.from_xyz_rpy(*request.pose)
    pinhole = replace(
        request, width=size, height=size, horizontal_fov=angle, lens=None, depth=False
    )
    for number, places, mask in sides:
        side = pose * Pose(orientation=quaternion_from_rpy(*SIDES[number]))
        yield replace(pinhole, pose=(side.position, side.rpy)), places, mask
