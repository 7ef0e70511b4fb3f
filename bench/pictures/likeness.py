"""How alike two images of one camera are, and what is recorded of Gazebo's.

Recorded are numbers alone: the mean colors of CELL x CELL pixels, and depths at their centers.
"""

from __future__ import annotations

import json
import pathlib
from dataclasses import dataclass

import cv2
import numpy as np

RECORDED = pathlib.Path(__file__).resolve().parent / "recorded.json"
CELL = 16  # [px]
ALIKE, MEAN = 0.90, 4.0  # similarity from which, and difference of means up to which they are alike
NEAR = 0.005  # [m] of two depths that are alike
STABLE = 0.04  # [m] depths that differ by more from pixel to pixel are at an edge


def similarity(one, other):
    """Structural similarity of two images (Wang et al. 2004): gray, Gaussian 11x11, sigma 1.5.

    Args:
        one, other: (H, W, 3) uint8 RGB.
    """
    a, b = (cv2.cvtColor(image, cv2.COLOR_RGB2GRAY).astype(float) for image in (one, other))

    def blurred(image):
        return cv2.GaussianBlur(image, (11, 11), 1.5)

    mean_a, mean_b = blurred(a), blurred(b)
    var_a, var_b = blurred(a * a) - mean_a**2, blurred(b * b) - mean_b**2
    both = blurred(a * b) - mean_a * mean_b
    c1, c2 = (0.01 * 255.0) ** 2, (0.03 * 255.0) ** 2
    top = (2.0 * mean_a * mean_b + c1) * (2.0 * both + c2)
    return float((top / ((mean_a**2 + mean_b**2 + c1) * (var_a + var_b + c2))).mean())


def cells(rgb):
    """Mean colors (H / CELL, W / CELL, 3) of an image."""
    height, width = (side // CELL for side in rgb.shape[:2])
    blocks = rgb[: height * CELL, : width * CELL].reshape(height, CELL, width, CELL, 3)
    return blocks.mean(axis=(1, 3))


def samples(depth):
    """Depths at the centers of the cells, (H / CELL, W / CELL); inf at edges.

    Args:
        depth: (H, W) float32 [m], NaN: unknown.
    """
    middle = slice(CELL // 2, None, CELL)
    known = np.nan_to_num(depth, nan=0.0)
    kernel = np.ones((5, 5), np.uint8)
    jump = cv2.dilate(known, kernel) - cv2.erode(known, kernel)
    slanted = np.maximum(STABLE, 0.2 * known)
    return np.where(jump > slanted, np.inf, depth)[middle, middle]


@dataclass(frozen=True)
class Pair:
    """One camera's images in Gazebo (or what is recorded of it) and in Paddock.

    Attributes:
        means: (2, 3) of the channels.
        cells: greatest difference of a cell's channels, and the share of cells within MEAN.
        similarity: None where Gazebo's image is not there.
        depth: share of depths that are alike, and of those unknown in one alone; None: no depths.
    """

    means: tuple
    cells: tuple[float, float]
    similarity: float | None = None
    depth: tuple[float, float] | None = None

    @property
    def alike(self):
        """Whether the images are alike: by similarity, or by their cells where it is missing."""
        means = np.abs(np.subtract(*self.means)).max() <= MEAN
        close = self.cells[1] >= ALIKE if self.similarity is None else self.similarity >= ALIKE
        return bool(means and close)


def pair_of(gazebo, paddock):
    """Pair of two images (H, W, 3) uint8 RGB."""
    return _pair(cells(gazebo), cells(paddock), similarity(gazebo, paddock))


def recorded_pair(record, seen):
    """Pair of what is recorded of a camera and a features.Seen."""
    theirs = np.array(record["cells"], float).reshape(cells(seen.rgb).shape)
    depth = None
    if "depth" in record:
        one = np.array([np.nan if value is None else value for value in record["depth"]])
        other = samples(seen.depth).ravel()
        judged = ~np.isinf(one) & ~np.isinf(other)
        one, other = one[judged], other[judged]
        known = ~np.isnan(one) & ~np.isnan(other)
        near = np.abs(one[known] - other[known]) <= NEAR
        depth = float(near.mean()), float((np.isnan(one) != np.isnan(other)).mean())
    return _pair(theirs, cells(seen.rgb), None, depth)


def _pair(one, other, alike, depth=None):
    difference = np.abs(one - other).max(axis=2)
    means = one.mean(axis=(0, 1)), other.mean(axis=(0, 1))
    share = float((difference <= MEAN).mean())
    return Pair(means, (float(difference.max()), share), alike, depth)


def record_of(seen):
    """What is recorded of a features.Seen, for JSON."""
    record = {"cells": [round(float(value), 1) for value in cells(seen.rgb).ravel()]}
    if seen.depth is not None:
        record["depth"] = [
            None if np.isnan(value) else float(np.round(value, 4))
            for value in samples(seen.depth).ravel()
        ]
    return record


def recorded():
    """What is recorded of Gazebo, by place."""
    return json.loads(RECORDED.read_text())["places"]
