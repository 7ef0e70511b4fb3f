"""Occupancy grids in map_server's form: an image (.pgm) and its YAML file."""

from __future__ import annotations

import math
import os
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
import yaml  # type: ignore[import]

FREE, OCCUPIED, UNKNOWN = 0, 100, -1  # as in nav_msgs/OccupancyGrid
SHADES = {FREE: 254, OCCUPIED: 0, UNKNOWN: 205}  # as map_saver writes them
FREE_THRESHOLD, OCCUPIED_THRESHOLD = 0.196, 0.65
LARGEST = 16_000  # cells of a side


class MapError(ValueError):
    """A map or its YAML file is not as it must be."""


@dataclass(frozen=True)
class Grid:
    """An occupancy grid.

    Attributes:
        cells: (rows, columns) int8 of FREE, OCCUPIED, UNKNOWN; row 0 has the smallest y.
        resolution: side of a cell [m].
        origin: (x, y) of the corner of cell [0, 0] in the map's frame [m].
        yaw: of the grid in the map's frame [rad].
    """

    cells: np.ndarray
    resolution: float
    origin: tuple[float, float]
    yaw: float = 0.0

    def save(self, base: str) -> None:
        """Write base.pgm and base.yaml, which map_server reads."""
        image = np.full(self.cells.shape, SHADES[UNKNOWN], np.uint8)
        for value in (FREE, OCCUPIED):
            image[self.cells == value] = SHADES[value]
        rows, columns = image.shape
        with open(f"{base}.pgm", "wb") as file:
            file.write(b"P5\n%d %d\n255\n" % (columns, rows) + image[::-1].tobytes())
        about = {
            "image": os.path.basename(base) + ".pgm",
            "resolution": self.resolution,
            "origin": [float(value) for value in (*self.origin, self.yaw)],
            "negate": 0,
            "occupied_thresh": OCCUPIED_THRESHOLD,
            "free_thresh": FREE_THRESHOLD,
        }
        with open(f"{base}.yaml", "w", encoding="utf-8") as file:
            yaml.safe_dump(about, file, sort_keys=False)


def load(path: str) -> Grid:
    """Read a map as map_server does in its mode "trinary".

    Args:
        path: of the YAML file.

    Raises:
        MapError: it, or its image, cannot be read.
    """
    try:
        with open(path, encoding="utf-8") as file:
            about = yaml.safe_load(file)
    except (OSError, UnicodeDecodeError, yaml.YAMLError) as error:
        raise MapError(f"{path} cannot be read: {error}") from error
    if not isinstance(about, dict):
        raise MapError(f"{path} must have image, resolution and origin, as map_server wants them")
    resolution = _number(path, about, "resolution")
    if resolution <= 0.0:
        raise MapError(f"{path}: resolution is {resolution}, must be above 0")
    origin = about.get("origin")
    if not isinstance(origin, list) or len(origin) != 3 or not all(map(_is_number, origin)):
        raise MapError(f"{path}: origin is {origin!r}, must be [x, y, yaw] in metres and radians")
    image = os.path.join(os.path.dirname(path), str(about.get("image", "")))
    shades = cv2.imread(image, cv2.IMREAD_UNCHANGED)
    if shades is None:
        raise MapError(f"{path}: image is {about.get('image')!r}, which is no image at {image}")
    if max(shades.shape[:2]) > LARGEST:
        raise MapError(f"{image} is {shades.shape[1]}x{shades.shape[0]}, at most {LARGEST} a side")
    shades = shades.astype(float)
    if shades.ndim == 3:
        shades = shades[..., :3].mean(axis=2)
    share = shades / 255.0 if about.get("negate") else (255.0 - shades) / 255.0
    cells = np.full(share.shape, UNKNOWN, np.int8)
    cells[share > _number(path, about, "occupied_thresh", OCCUPIED_THRESHOLD)] = OCCUPIED
    cells[share < _number(path, about, "free_thresh", FREE_THRESHOLD)] = FREE
    x, y, yaw = map(float, origin)
    return Grid(cells[::-1], resolution, (x, y), yaw)


def _is_number(value: Any) -> bool:
    return type(value) in (int, float) and math.isfinite(value)


def _number(path: str, about: dict[str, Any], name: str, default: float | None = None) -> float:
    value = about.get(name, default)
    if not _is_number(value):
        raise MapError(f"{path}: {name} is {value!r}, must be a number")
    return float(value)  # type: ignore[arg-type]
