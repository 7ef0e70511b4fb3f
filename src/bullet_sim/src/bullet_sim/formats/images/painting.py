"""What drawings of images have in common: grain, wood, colors.

What is random continues over the image's edges, where Gazebo repeats it. Lengths are [px], colors
RGB 0..255, images float32 (height, width, 3).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Tuple

import cv2
import numpy as np

Array = Any  # float32 (height, width) or (height, width, 3)
Random = Any  # numpy.random.Generator
Color = Tuple[float, float, float]


def noise(random: Random, size: tuple[int, int], *layers: tuple[float, float, float]) -> Array:
    """Random values of mean 0 that continue over the edges.

    Args:
        size: height and width.
        layers: standard deviation, height and width of a grain, of each layer.
    """
    total = np.zeros(size, np.float32)
    for deviation, *grain in layers:
        count = [max(1, round(side / length)) for side, length in zip(size, grain)]
        small = random.standard_normal(count).astype(np.float32)
        padded = np.pad(small, 2, mode="wrap")
        down, right = (number / side for number, side in zip(count, size))
        at = np.float32([[right, 0, 1.5 + right / 2], [0, down, 1.5 + down / 2]])
        way = cv2.INTER_CUBIC | cv2.WARP_INVERSE_MAP
        layer = cv2.warpAffine(padded, at, size[::-1], flags=way)
        total += (layer - layer.mean()) * (deviation / max(float(layer.std()), 1e-6))
    return total


def bent(values: Array, random: Random, down: float, right: float, grain: tuple[int, int]) -> Array:
    """Values moved along smooth waves of a deviation downwards and to the right, as wood grows."""
    size = values.shape[:2]
    y, x = np.mgrid[: size[0], : size[1]].astype(np.float32)
    y += noise(random, size, (down, *grain))
    x += noise(random, size, (right, *grain))
    return cv2.remap(values.astype(np.float32), x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_WRAP)


_SHARES = (-2.05, -1.28, -0.52, 0.0, 0.52, 1.28, 2.05)  # 2, 10, 30, 50, 70, 90, 98 % are below


def toned(values: Array, palette: Sequence[Color]) -> Array:
    """Colors of random values of deviation 1.

    Args:
        palette: colors of the values _SHARES, from dark to light.
    """
    colors = np.float32(palette)
    parts = [np.interp(values, _SHARES, colors[:, channel]) for channel in range(3)]
    return np.stack(parts, axis=2).astype(np.float32)


def plain(size: tuple[int, int], color: Sequence[float]) -> Array:
    return np.full((*size, len(color)), color, np.float32)


def fill(picture: Array, x: float, y: float, width: float, height: float, color: Color) -> None:
    """Paint a rectangle."""
    picture[round(y) : round(y + height), round(x) : round(x + width)] = color
