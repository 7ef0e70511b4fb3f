"""The drawn image of each of Gazebo's standard materials that has one.

Each has the size and the layout of Gazebo's image: where courses, joints, boards and lane lines
are, how wide they are, their colors, how much and how coarsely they vary. All lengths are [px] of
the image, x to the right and y down, colors RGB 0..255. What is random has a seed of its own, so
that an image always has the same bytes.
"""

from __future__ import annotations

import zlib
from collections.abc import Callable

import cv2
import numpy as np

from bullet_sim.description.model import RGB
from bullet_sim.formats.images import roads, signs, walls
from bullet_sim.formats.images.painting import Array, Random

_DRAWN: dict[str, Callable[[Random], Array]] = {
    "WoodFloor": walls.hardwood,
    "CeilingTiled": walls.ceiling,
    "PaintedWall": walls.painted_wall,
    "WoodPallet": walls.pallet,
    "Wood": walls.parquet,
    "Bricks": walls.bricks,
    "Road": roads.PRIMARY,
    "Residential": roads.RESIDENTIAL,
    "Pedestrian": roads.pedestrian,
    "Motorway": roads.MOTORWAY,
    "Trunk": roads.TRUNK,
    "Primary": roads.PRIMARY,
    "Secondary": roads.SECONDARY,
    "Steps": roads.steps,
    "BuildingFrame": signs.frame,
    "Runway": signs.runway,
    "Grass": walls.grass,
    "CoM": signs.center_of_mass,
}


def png(name: str, mean: RGB) -> bytes:
    """The image of Gazebo/NAME as PNG.

    Args:
        mean: RGB 0..1 that it gets by a factor for each color; black stays black.
    """
    picture = drawing(name)
    wanted, factors = np.multiply(mean, 255.0), np.ones(picture.shape[2])
    for _ in range(4):  # what is white stays so, hence several times
        whole = cv2.convertScaleAbs(np.maximum(picture, 0) * factors.astype(np.float32))
        missing = wanted / cv2.mean(whole)[:3]
        if np.abs(missing - 1).max() < 0.004:
            break
        factors[:3] *= missing
    order = cv2.COLOR_RGBA2BGRA if whole.shape[2] == 4 else cv2.COLOR_RGB2BGR
    return bytes(cv2.imencode(".png", cv2.cvtColor(whole, order))[1])


def drawing(name: str) -> Array:
    """Float image (height, width, 3 or 4) of Gazebo/NAME, before it gets its mean."""
    return _DRAWN[name](np.random.default_rng(zlib.crc32(name.encode())))
