"""A sky behind everything, for renderers that leave the background white or grey."""
from functools import lru_cache

import numpy as np

from bullet_sim.sensors.camera import FAR_DEPTH

ZENITH = (110, 160, 220)
HORIZON = (205, 222, 240)


@lru_cache(maxsize=16)
def gradient(height):
    """Sky colours of one image column, (H, 1, 3) uint8: ZENITH on top, HORIZON from the middle
    down (in image rows: it does not tilt with the camera)."""
    mix = np.minimum(np.arange(height) / max(height / 2.0, 1.0), 1.0)[:, None, None]
    return np.rint((1 - mix) * np.array(ZENITH) + mix * np.array(HORIZON)).astype(np.uint8)


def paint_sky(rgb, depth):
    """Replace pixels where nothing was drawn.

    Args:
        rgb: (H, W, 3) uint8, changed in place.
        depth: (H, W) float32 OpenGL depth buffer, 0 near ... 1 nothing.

    Returns:
        rgb.
    """
    sky = gradient(len(rgb))
    empty = depth >= FAR_DEPTH
    count = np.count_nonzero(empty, axis=1)
    whole = np.flatnonzero(count == empty.shape[1])
    if len(whole) and whole[-1] - whole[0] + 1 == len(whole):
        whole = slice(whole[0], whole[-1] + 1)      # one block: several times faster
    rgb[whole] = sky[whole]
    mixed = np.flatnonzero((count > 0) & (count < empty.shape[1]))
    row, column = np.nonzero(empty[mixed])
    rgb[mixed[row], column] = sky[mixed[row], 0]
    return rgb
