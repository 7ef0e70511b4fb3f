"""Track files: YAML text checked key by key into a TrackSpec. Needs no numpy."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from typing import Any, Tuple

from paddock_common.settings import Flag, Number, Rule, Text
from paddock_common.yaml_file import formatted

from paddock_common import yaml_file
from track_model.spec import COLORS, DEFAULTS, WALLS, TrackError, TrackSpec, WallSpec, stem

MAX_SIZE = 200_000  # [bytes] of a file
Points = Tuple[Tuple[float, float], ...]
KINDS: dict[type, Rule] = {
    bool: Flag(),
    int: Number(integer=True),
    float: Number(),
    str: Text(empty=True),
}
RULES: dict[str, Rule] = {
    "width": Number(min=0.3, max=3.0),
    "border_width": Number(min=0.005, max=0.2),
    "centre_line_width": Number(min=0.005, max=0.2),
    "dash_length": Number(min=0.02, max=2.0),
    "dash_gap": Number(min=0.02, max=2.0),
    "friction": Number(min=0.0, max=10.0),
    "start_distance": Number(min=0.0, max=1000.0),
    "seed": Number(min=0, max=2**32 - 1, integer=True),
    "walls.height": Number(min=0.02, max=3.0),
    "walls.thickness": Number(min=0.005, max=0.5),
    "walls.gap": Number(min=0.0, max=3.0),
}


def _checked(path: str, item: str, value: Any, default: Any = 0.0) -> Any:
    """Return a value that is what its rule, or the type of its default, asks for."""
    valid = RULES.get(item, KINDS[type(default)]).complaint(value)
    if valid:
        raise TrackError(path, item, formatted(value), valid)
    return float(value) if isinstance(default, float) else value


def _section(path: str, prefix: str, data: Any, valid: Collection[str]) -> dict[str, Any]:
    if not isinstance(data, dict):
        raise TrackError(
            path,
            prefix or "content",
            formatted(data),
            "a mapping with keys of {}".format(", ".join(sorted(valid))),
        )
    for key in data:
        if key not in valid:
            raise TrackError(
                path, "%skey" % (prefix and prefix + " "), formatted(key), ", ".join(sorted(valid))
            )
    return data


def _points(path: str, data: Any, closed: bool) -> Points:
    if not isinstance(data, list):
        raise TrackError(path, "points", formatted(data), "a list of at least 3 pairs [x, y]")
    points: list[tuple[float, float]] = []
    for index, pair in enumerate(data):
        item = f"points[{index}]"
        if not isinstance(pair, list) or len(pair) != 2:
            raise TrackError(path, item, formatted(pair), "a pair [x, y] in meters")
        point = _checked(path, item, pair[0]), _checked(path, item, pair[1])
        if max(abs(value) for value in point) > 50.0:
            raise TrackError(path, item, formatted(pair), "coordinates of -50 to 50 m")
        if points and math.dist(point, points[-1]) < 1e-3:
            raise TrackError(
                path, item, formatted(pair), "at least 1 mm away from the previous point"
            )
        points.append(point)
    # The last point may repeat the first, as closed polygons often do.
    if closed and len(points) > 1 and math.dist(points[0], points[-1]) < 1e-3:
        points.pop()
    if len(set(points)) < 3:
        raise TrackError(path, "points", f"{len(set(points))} distinct points", "at least 3")
    return tuple(points)


def _width(path: str, data: dict[str, Any], points: Points) -> Sequence[float]:
    """Return the lane's widths, one per point, from one number or a list of them."""
    width = data.get("width", DEFAULTS["width"])
    if not isinstance(width, list):
        return [_checked(path, "width", width)] * len(points)
    if len(width) != len(data["points"]):
        raise TrackError(
            path,
            "width",
            f"{len(width)} numbers",
            f"one number, or one per point ({len(data['points'])})",
        )
    for index, value in enumerate(width):
        width[index] = _checked(path, "width", value)
    return width[: len(points)]


def _colors(path: str, data: Any) -> dict[str, tuple[int, ...]]:
    """Return the colors of all items, defaults where none is given."""
    colors: dict[str, tuple[int, ...]] = dict(COLORS)
    for key, value in _section(path, "colours", data, COLORS).items():
        valid = (
            isinstance(value, list)
            and len(value) == 3
            and all(type(channel) is int and 0 <= channel <= 255 for channel in value)
        )
        if not valid:
            raise TrackError(
                path, "colours." + key, formatted(value), "[red, green, blue], each 0 to 255"
            )
        colors[key] = tuple(value)
    return colors


def _walls(path: str, data: Any) -> WallSpec:
    given = _section(path, "walls", data, WALLS)
    return WallSpec(
        **{
            key: _checked(path, "walls." + key, given.get(key, default), default)
            for key, default in WALLS.items()
        }
    )


def parse(text: str | bytes, path: str) -> TrackSpec:
    """Parse a track file's text.

    Args:
        text: YAML.
        path: File name for messages; its stem is the track's name.

    Raises:
        TrackError: It is not valid.
    """
    if len(text) > MAX_SIZE:
        raise TrackError(path, "content", f"{len(text)} bytes long", f"at most {MAX_SIZE} bytes")
    try:
        data = yaml_file.parse(text, "")
    except ValueError as error:
        why = f"not YAML ({str(error).partition(': ')[2]})"
        raise TrackError(path, "content", why, "a YAML mapping") from error
    _section(path, "", data, {*DEFAULTS, "points", "colours", "walls"})
    if "points" not in data:
        raise TrackError(path, "points", "missing", "a list of at least 3 pairs [x, y]")
    values = {
        key: _checked(path, key, data.get(key, default), default)
        for key, default in DEFAULTS.items()
        if key != "width"
    }
    points = _points(path, data["points"], values["closed"])
    widths = _width(path, data, points)
    if 2.0 * values["border_width"] + values["centre_line_width"] >= min(widths):
        raise TrackError(
            path, "width", min(widths), "more than both borders and the center line together"
        )
    return TrackSpec(
        path=path,
        name=stem(path),
        points=points,
        width=max(widths),
        sides=tuple((width / 2.0, width / 2.0) for width in widths),
        colors=_colors(path, data.get("colours", {})),
        walls=_walls(path, data.get("walls", {})),
        **values,
    )
