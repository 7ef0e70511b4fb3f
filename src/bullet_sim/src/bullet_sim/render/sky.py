"""A sky behind everything, for renderers that leave the background white or grey."""

from functools import lru_cache

import cv2
import numpy as np

from bullet_sim.sensors.camera import FAR_DEPTH

ZENITH = (110, 160, 220)
HORIZON = (205, 222, 240)


def gradient(height):
    """Sky colours of one image column, (H, 1, 3) uint8: ZENITH on top, HORIZON from the middle
    down (in image rows: it does not tilt with the camera)."""
    mix = np.minimum(np.arange(height) / max(height / 2.0, 1.0), 1.0)[:, None, None]
    return np.rint((1 - mix) * np.array(ZENITH) + mix * np.array(HORIZON)).astype(np.uint8)


@lru_cache(maxsize=16)
def _whole(height, width):
    return np.ascontiguousarray(np.broadcast_to(gradient(height), (height, width, 3)))


def paint_sky(rgb, depth):
    """Replace pixels where nothing was drawn.

    Args:
        rgb: (H, W, 3) uint8, contiguous, changed in place.
        depth: (H, W) float32 OpenGL depth buffer, 0 near ... 1 nothing.

    Returns:
        rgb.
    """
    empty = (depth >= FAR_DEPTH).view(np.uint8)
    return cv2.copyTo(_whole(*rgb.shape[:2]), empty, rgb)  # 20 times as fast as numpy's masks
