"""Routes of other projects as tracks: DeepRacer .npy files and F1TENTH centreline .csv files."""

from __future__ import annotations

import io
from typing import Any, Tuple

import numpy as np
import numpy.typing as npt

from track_model import spec as track_spec
from track_model.spec import TrackError, TrackSpec

MAX_COORDINATE = 500.0  # [m]
MERGE_DISTANCE = 1e-3  # points closer than this are merged [m]
CLOSING_GAP = 4.0  # a route whose ends are closer than this many median spacings is closed
MIN_WIDTH = 0.2  # of a lane [m]
# Points (N, 2), distances to the left and to the right edge (N,) [m].
Columns = Tuple[npt.NDArray[Any], npt.NDArray[Any], npt.NDArray[Any]]


def parse(content: bytes, path: str) -> TrackSpec:
    """Convert a route file to a TrackSpec; borders, colors and walls have a track file's defaults.

    A .npy contains N x 6: center, inner and outer edge points (DeepRacer's route files; the last
    point may repeat the first, points may repeat, the route may be open). A .csv contains x, y,
    distance to the right edge, distance to the left edge (F1TENTH and TUM centrelines; '#' starts
    a comment; more columns are ignored).

    Raises:
        TrackError: The message has file, row, value and what is valid.
    """
    if path.lower().endswith(".npy"):
        points, left, right = _deepracer(_read_npy(content, path), path)
    else:
        array = _read_csv(content, path)
        points, left, right = array[:, 0:2], array[:, 3], array[:, 2]
    points, sides, closed = _distinct(points, np.stack([left, right], axis=1), path)
    narrow = int(np.argmin(sides.sum(axis=1)))
    width = float(sides.sum(axis=1)[narrow])
    if width < MIN_WIDTH or (sides < 0).any():
        raise TrackError(
            path,
            f"width near point {narrow}",
            f"{width:.3f} m",
            f"at least {MIN_WIDTH:g} m, with the center between the edges",
        )
    values = {
        key: value
        for key, value in track_spec.DEFAULTS.items()
        if key not in ("width", "closed", "description")
    }
    values["border_width"] = min(values["border_width"], width / 8.0)
    return track_spec.TrackSpec(
        path=path,
        name=track_spec.stem(path),
        description=f"route of {len(points)} points",
        points=tuple(map(tuple, points.tolist())),
        sides=tuple(map(tuple, sides.tolist())),
        closed=closed,
        width=float(sides.sum(axis=1).max()),
        colors=dict(track_spec.COLORS),
        walls=track_spec.WallSpec(**track_spec.WALLS),
        imported=True,
        **values,
    )


def _read_npy(content: bytes, path: str) -> npt.NDArray[Any]:
    try:
        array = np.load(io.BytesIO(content), allow_pickle=False)
    except Exception as error:  # pylint: disable=broad-except  # a header may contain anything
        raise TrackError(
            path,
            "content",
            "not an array file ({})".format(" ".join(str(error).split())),
            "a NumPy .npy file of numbers",
        ) from error
    if (
        not isinstance(array, np.ndarray)
        or array.ndim != 2
        or array.shape[1] != 6
        or array.dtype.kind not in "fiu"
    ):
        raise TrackError(
            path,
            "array",
            "{} of {}".format(getattr(array, "shape", "?"), getattr(array, "dtype", type(array))),
            "N x 6 numbers: center x y, inner x y, outer x y",
        )
    return _checked(array.astype(float), path)


def _read_csv(content: bytes, path: str) -> npt.NDArray[Any]:
    try:
        lines = content.decode("utf-8-sig").splitlines()
    except UnicodeDecodeError as error:
        raise TrackError(path, "content", f"not text ({error})", "a CSV file") from error
    rows = []
    for number, line in enumerate(lines, 1):
        text = line.split("#")[0].replace(";", ",").strip()
        if not text:
            continue
        cells = [cell.strip() for cell in text.split(",")]
        try:
            rows.append([float(cell) for cell in cells[:4]])
        except ValueError as error:
            if not rows and not any(_is_number(cell) for cell in cells):
                continue  # a header without '#'
            raise TrackError(
                path,
                f"line {number}",
                repr(line.strip()),
                "numbers x, y, right width, left width [m]",
            ) from error
        if len(rows[-1]) < 4:
            raise TrackError(
                path,
                f"line {number}",
                f"{len(rows[-1])} columns",
                "4: x, y, right width, left width [m]",
            )
    if not rows:
        raise TrackError(path, "content", "no rows", "at least 3 points")
    return _checked(np.array(rows), path)


def _is_number(text: str) -> bool:
    try:
        float(text)
        return True
    except ValueError:
        return False


def _checked(array: npt.NDArray[Any], path: str) -> npt.NDArray[Any]:
    bad = np.argwhere(~np.isfinite(array))
    if len(bad):
        row, column = bad[0]
        raise TrackError(path, f"row {row}, column {column}", array[row, column], "a finite number")
    if len(array) and np.abs(array).max() > MAX_COORDINATE:
        row = int(np.argmax(np.abs(array).max(axis=1)))
        raise TrackError(
            path, f"row {row}", np.abs(array[row]).max(), f"at most {MAX_COORDINATE:g} m"
        )
    return array


def _deepracer(array: npt.NDArray[Any], path: str) -> Columns:
    """Return points and distances to the left and right edge."""
    center, inner, outer = array[:, 0:2], array[:, 2:4], array[:, 4:6]
    to_inner, to_outer = (np.linalg.norm(edge - center, axis=1) for edge in (inner, outer))
    if len(array) < 3:
        raise TrackError(path, "points", f"{len(array)} points", "at least 3 distinct")
    ahead = np.gradient(center, axis=0)
    across = inner - outer
    side = np.sum(ahead[:, 0] * across[:, 1] - ahead[:, 1] * across[:, 0])
    return (center, to_inner, to_outer) if side > 0 else (center, to_outer, to_inner)


def _distinct(
    points: npt.NDArray[Any], sides: npt.NDArray[Any], path: str
) -> tuple[npt.NDArray[Any], npt.NDArray[Any], bool]:
    """Drop repeated points; also return whether the route is closed."""
    indices = [0]
    for index in range(1, len(points)):
        if np.linalg.norm(points[index] - points[indices[-1]]) >= MERGE_DISTANCE:
            indices.append(index)
    points, sides = points[indices], sides[indices]
    closed = False
    if len(points) > 1:
        spacing = np.median(np.linalg.norm(np.diff(points, axis=0), axis=1))
        gap = np.linalg.norm(points[0] - points[-1])
        closed = gap < CLOSING_GAP * spacing and len(points) > 2 * CLOSING_GAP
        if gap < MERGE_DISTANCE:
            closed = True
            points, sides = points[:-1], sides[:-1]
    distinct = len(np.unique(points, axis=0))
    if distinct < 3:
        raise TrackError(path, "points", f"{distinct} distinct points", "at least 3")
    return points, sides, closed
