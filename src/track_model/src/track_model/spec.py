"""The content of a track file: TrackSpec, its defaults, TrackError; imports no numpy."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import Any

DEFAULTS: dict[str, Any] = {
    "width": 0.76,
    "border_width": 0.03,
    "centre_line_width": 0.025,
    "dash_length": 0.15,
    "dash_gap": 0.10,
    "friction": 1.0,
    "start_distance": 0.0,
    "seed": 0,
    "start_line": True,
    "closed": True,
    "description": "",
}
COLORS: dict[str, tuple[int, ...]] = {
    "asphalt": (52, 53, 56),
    "border": (242, 242, 240),
    "centre_line": (245, 140, 20),
    "grass": (52, 122, 58),
    "wall": (190, 190, 195),
}
WALLS: dict[str, Any] = {"enabled": False, "height": 0.25, "thickness": 0.03, "gap": 0.15}


class TrackError(ValueError):
    """A track file is not valid; the message has file, item, value and what is valid."""

    def __init__(self, path: str, item: str, value: object, valid: str) -> None:
        super().__init__(f"{path}: {item} is {value}; valid: {valid}")


@dataclass(frozen=True)
class WallSpec:
    """Walls along both borders; lengths in meters, gap is border to wall."""

    enabled: bool
    height: float
    thickness: float
    gap: float


@dataclass(frozen=True)
class TrackSpec:
    """A checked track file; lengths in meters, colors RGB 0..255.

    Attributes:
        points: Centreline points (x, y) in the file's frame, in driving direction.
        closed: Whether the last point is followed by the first (a circuit).
        width: Lane from outer edge to outer edge of the white borders, at the widest point.
        sides: (left, right) from each point to the lane's outer edges.
        imported: Whether it is from a route file, which may have tight bends and overlaps.
        start_distance: Start pose, measured along the centreline from the first point.
    """

    path: str
    name: str
    description: str
    points: tuple[tuple[float, ...], ...]
    closed: bool
    width: float
    sides: tuple[tuple[float, ...], ...]
    border_width: float
    centre_line_width: float
    dash_length: float
    dash_gap: float
    friction: float
    start_distance: float
    start_line: bool
    seed: int
    colors: dict[str, tuple[int, ...]]
    walls: WallSpec
    imported: bool = False


def stem(path: str) -> str:
    """Return a track's name: its file's name without folder and suffix."""
    return os.path.splitext(os.path.basename(path))[0]
