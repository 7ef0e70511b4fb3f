"""The observation `camera`: 160x120 pixels, grey or in colour."""

import cv2
import numpy as np

WIDTH, HEIGHT = 160, 120  # [px]
GREY_SHAPE = (HEIGHT, WIDTH, 1)
COLOUR_SHAPE = (HEIGHT, WIDTH, 3)


def picture(rgb, colour=False):
    """Observe a camera picture.

    Args:
        rgb: (H, W, 3) uint8 of any size.
        colour: False: grey (ITU-R BT.601 weights).

    Returns:
        (120, 160, 1) or (120, 160, 3) uint8.
    """
    if rgb.shape[:2] != (HEIGHT, WIDTH):
        rgb = cv2.resize(rgb, (WIDTH, HEIGHT), interpolation=cv2.INTER_AREA)
    if colour:
        return np.ascontiguousarray(rgb)
    return cv2.cvtColor(rgb, cv2.COLOR_RGB2GRAY)[:, :, None]
