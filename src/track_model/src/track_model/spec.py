"""Track files: YAML text checked key by key into a TrackSpec. Needs no numpy."""

import math
import os
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import Any

import yaml  # type: ignore[import]

DEFAULTS = {
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
Points = tuple[tuple[float, float], ...]

COLOURS = {
    "asphalt": (52, 53, 56),
    "border": (242, 242, 240),
    "centre_line": (245, 140, 20),
    "grass": (52, 122, 58),
    "wall": (190, 190, 195),
}
WALLS = {"enabled": False, "height": 0.25, "thickness": 0.03, "gap": 0.15}
# Allowed ranges, both ends included.
RANGES = {
    "width": (0.3, 3.0),
    "border_width": (0.005, 0.2),
    "centre_line_width": (0.005, 0.2),
    "dash_length": (0.02, 2.0),
    "dash_gap": (0.02, 2.0),
    "friction": (0.0, 10.0),
    "start_distance": (0.0, 1000.0),
    "walls.height": (0.02, 3.0),
    "walls.thickness": (0.005, 0.5),
    "walls.gap": (0.0, 3.0),
}


class TrackError(ValueError):
    """A track file is wrong; the message names file, item, value and what is valid."""

    def __init__(self, path: str, item: str, value: object, valid: str) -> None:
        super().__init__(f"{path}: {item} is {value}; valid: {valid}")


@dataclass(frozen=True)
class WallSpec:
    """Walls along both borders; lengths in metres, gap is border to wall."""

    enabled: bool
    height: float
    thickness: float
    gap: float


@dataclass(frozen=True)
class TrackSpec:
    """A checked track file; lengths in metres, colours RGB 0..255.

    Attributes:
        points: Centreline points (x, y) in the file's own frame, in driving direction.
        closed: Whether the last point is followed by the first (a circuit).
        width: Lane from outer edge to outer edge of the white borders, the widest place.
        sides: (left, right) from each point to the lane's outer edges.
        imported: Whether it is from a route file, which may have tight bends and overlaps.
        start_distance: Start pose, measured along the centreline from the first point.
    """

    path: str
    name: str
    description: str
    points: tuple
    closed: bool
    width: float
    sides: tuple
    border_width: float
    centre_line_width: float
    dash_length: float
    dash_gap: float
    friction: float
    start_distance: float
    start_line: bool
    seed: int
    colours: dict
    walls: WallSpec
    imported: bool = False


def _number(path: str, item: str, value: Any) -> float:
    # bool is an int in Python; YAML's yes and no are not numbers.
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise TrackError(path, item, repr(value), "a number")
    if not math.isfinite(value):
        raise TrackError(path, item, repr(value), "a finite number")
    low, high = RANGES.get(item, (-math.inf, math.inf))
    if not low <= value <= high:
        raise TrackError(path, item, repr(value), f"{low:g} to {high:g}")
    return float(value)


def _typed(path: str, item: str, value: Any, default: Any) -> Any:
    if isinstance(default, float):
        return _number(path, item, value)
    if not isinstance(value, type(default)) or (
        isinstance(value, bool) and not isinstance(default, bool)
    ):
        kinds = {bool: "true or false", int: "a whole number", str: "text"}
        raise TrackError(path, item, repr(value), kinds[type(default)])
    if item == "seed" and not 0 <= value < 2**32:
        raise TrackError(path, item, value, "0 to 4294967295")
    return value


def _section(path: str, prefix: str, data: Any, valid: Collection[str]) -> dict:
    if not isinstance(data, dict):
        raise TrackError(
            path,
            prefix or "content",
            repr(data),
            "a mapping with keys of {}".format(", ".join(sorted(valid))),
        )
    for key in data:
        if key not in valid:
            raise TrackError(
                path, "%skey" % (prefix and prefix + " "), repr(key), ", ".join(sorted(valid))
            )
    return data


def _points(path: str, data: Any, closed: bool) -> Points:
    if not isinstance(data, list):
        raise TrackError(path, "points", repr(data), "a list of at least 3 pairs [x, y]")
    points: list[tuple[float, float]] = []
    for index, pair in enumerate(data):
        item = f"points[{index}]"
        if not isinstance(pair, list) or len(pair) != 2:
            raise TrackError(path, item, repr(pair), "a pair [x, y] in metres")
        point = _number(path, item, pair[0]), _number(path, item, pair[1])
        if max(abs(value) for value in point) > 50.0:
            raise TrackError(path, item, repr(pair), "coordinates of -50 to 50 m")
        if points and math.dist(point, points[-1]) < 1e-3:
            raise TrackError(path, item, repr(pair), "at least 1 mm away from the point before")
        points.append(point)
    # The last point may repeat the first, as closed polygons often do.
    if closed and len(points) > 1 and math.dist(points[0], points[-1]) < 1e-3:
        points.pop()
    if len(set(points)) < 3:
        raise TrackError(path, "points", f"{len(set(points))} distinct points", "at least 3")
    return tuple(points)


def _width(path: str, data: dict, points: Points) -> Sequence[float]:
    """Return the lane's widths, one per point, from one number or a list of them."""
    width = data.get("width", DEFAULTS["width"])
    if not isinstance(width, list):
        return [_number(path, "width", width)] * len(points)
    if len(width) != len(data["points"]):
        raise TrackError(
            path,
            "width",
            f"{len(width)} numbers",
            f"one number, or one per point ({len(data['points'])})",
        )
    for index, value in enumerate(width):
        width[index] = _number(path, "width", value)
    return width[: len(points)]


def parse(text: str | bytes, path: str) -> TrackSpec:
    """Parse a track file's text.

    Args:
        text: YAML.
        path: File name for messages; its stem is the track's name.

    Returns:
        TrackSpec.

    Raises:
        TrackError: Something in it is not valid.
    """
    try:
        data = yaml.safe_load(text)
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        raise TrackError(
            path, "content", "not YAML ({})".format(" ".join(str(error).split())), "a YAML mapping"
        ) from error
    _section(path, "", data, {*DEFAULTS, "points", "colours", "walls"})
    if "points" not in data:
        raise TrackError(path, "points", "missing", "a list of at least 3 pairs [x, y]")
    values = {
        key: _typed(path, key, data.get(key, default), default)
        for key, default in DEFAULTS.items()
        if key != "width"
    }
    points = _points(path, data["points"], values["closed"])
    widths = _width(path, data, points)
    if 2.0 * values["border_width"] + values["centre_line_width"] >= min(widths):
        raise TrackError(
            path, "width", min(widths), "more than both borders and the centre line together"
        )
    colours: dict[str, tuple[int, ...]] = dict(COLOURS)
    for key, value in _section(path, "colours", data.get("colours", {}), COLOURS).items():
        good = (
            isinstance(value, list)
            and len(value) == 3
            and all(type(channel) is int and 0 <= channel <= 255 for channel in value)
        )
        if not good:
            raise TrackError(
                path, "colours." + key, repr(value), "[red, green, blue], each 0 to 255"
            )
        colours[key] = tuple(value)
    given = _section(path, "walls", data.get("walls", {}), WALLS)
    walls = WallSpec(
        **{
            key: _typed(path, "walls." + key, given.get(key, default), default)
            for key, default in WALLS.items()
        }
    )
    return TrackSpec(
        path=path,
        name=stem(path),
        points=points,
        width=max(widths),
        sides=tuple((width / 2.0, width / 2.0) for width in widths),
        colours=colours,
        walls=walls,
        **values,
    )


def stem(path: str) -> str:
    """Return a track's name: its file's name without folder and suffix."""
    return os.path.splitext(os.path.basename(path))[0]
