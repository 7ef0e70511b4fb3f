"""Lenses that bend lines: pictures of a wider pinhole, warped.

The model is that of sensor_msgs/CameraInfo's plumb_bob and of OpenCV (Brown 1966): with x and y on
the plane at distance 1 and r^2 = x^2 + y^2
    x' = x (1 + k1 r^2 + k2 r^4 + k3 r^6) + 2 p1 x y + p2 (r^2 + 2 x^2), and y' alike.
"""

import math
from dataclasses import replace
from functools import lru_cache

import cv2
import numpy as np

from bullet_sim.sensors import camera

WIDEST = math.tan(math.radians(80.0))  # of the pinhole that is warped, half its width at distance 1
ITERATIONS = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 100, 1e-10)


@lru_cache(maxsize=16)
def plan(width, height, horizontal_fov, distortion):
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
    return (*size, fov), places.reshape(height, width, 2).astype(np.float32)


def picture(draw, request, rgb=None, depth=None):
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
    rgb = cv2.remap(colors, places, None, cv2.INTER_LINEAR, dst=rgb)
    if metres is not None:  # distances are not mixed across edges
        depth = cv2.remap(metres, places, None, cv2.INTER_NEAREST, dst=depth)
        return rgb, depth
    return rgb, None


def labels(draw, request):
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


def _pinhole(request):
    """The request of the pinhole to draw, and where the lens's pixels are in its picture."""
    (width, height, fov), places = plan(
        request.width, request.height, request.horizontal_fov, request.distortion
    )
    wide = replace(request, width=width, height=height, horizontal_fov=fov, distortion=())
    return wide, places
