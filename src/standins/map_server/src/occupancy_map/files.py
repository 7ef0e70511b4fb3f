"""Maps: their cells and files."""

import math
import os
from dataclasses import dataclass

import cv2
import numpy as np

from paddock_common import yaml_file

OCCUPIED, FREE, UNKNOWN = 100, 0, -1
MODES = ("trinary", "scale", "raw")
BLACK, WHITE, GRAY = 0, 254, 205  # pixels of cells: occupied, free, unknown


def from_pixels(pixels, occupied_thresh, free_thresh, negate=False, mode="trinary"):
    """Cells of an image.

    A pixel's darkness is 1 for black and 0 for white, of the mean over its channels. Above
    occupied_thresh the cell is occupied (100), below free_thresh it is free (0). Between them:
    trinary: unknown (-1); scale: 1..99 in proportion, unknown where the image is transparent.
    raw: the mean itself, 0..255 as a signed byte.

    Args:
        pixels: (H, W) or (H, W, channels) uint8; with two or four channels the last is alpha.
        occupied_thresh: Darkness, 0..1.
        free_thresh: Darkness, 0..1.
        negate: Whether black and white are swapped.

    Returns:
        (H, W) int8; row 0 is the image's lowest.
    """
    pixels = np.asarray(pixels)
    if pixels.ndim == 2:
        pixels = pixels[:, :, None]
    alpha = pixels[:, :, -1] if pixels.shape[2] in (2, 4) else None
    # Alpha counts as a channel in trinary mode: maps in use were made for that.
    channels = pixels if alpha is None or mode == "trinary" else pixels[:, :, :-1]
    mean = channels.mean(axis=2)
    if negate:
        mean = 255.0 - mean
    if mode == "raw":
        cells = mean.astype(np.uint8).astype(np.int8)
    else:
        darkness = (255.0 - mean) / 255.0
        cells = np.full(mean.shape, UNKNOWN, np.int8)
        if mode == "scale":
            ratio = (darkness - free_thresh) / max(occupied_thresh - free_thresh, 1e-12)
            between = (1.0 + 98.0 * np.clip(ratio, 0.0, 1.0)).astype(np.int8)
            cells = between if alpha is None else np.where(alpha == 0, cells, between)
        cells[darkness > occupied_thresh] = OCCUPIED
        cells[darkness < free_thresh] = FREE
    return np.ascontiguousarray(cells[::-1], np.int8)


def to_pixels(cells, occupied=65, free=25):
    """Pixels of cells.

    Args:
        cells: (H, W) int8, row 0 lowest.
        occupied: Cells from here on are black, 1..100.
        free: Cells up to here, from 0, are white, 0..100.

    Returns:
        (H, W) uint8, row 0 highest.
    """
    cells = np.asarray(cells, np.int16)[::-1]
    pixels = np.full(cells.shape, GRAY, np.uint8)
    pixels[cells >= occupied] = BLACK
    pixels[(cells >= 0) & (cells <= free)] = WHITE
    return pixels


OCCUPIED_THRESH, FREE_THRESH = 0.65, 0.196  # the usual ones


@dataclass(frozen=True)
class Map:
    """An occupancy grid.

    Attributes:
        cells: (H, W) int8, row 0 lowest: 0 free .. 100 occupied, -1 unknown.
        resolution: Size of a cell [m].
        origin: Pose of the lowest left corner (x [m], y [m], yaw [rad]).
    """

    cells: np.ndarray
    resolution: float
    origin: tuple


def load(path):
    """Reads a map file.

    Raises:
        ValueError: Names the file, the item, its value and what is valid.
    """
    try:
        content = yaml_file.read(path)
    except ValueError as error:
        raise ValueError(f"map file {error}") from None
    if not isinstance(content, dict):
        raise ValueError(f"map file {path} must be a map of image, resolution, origin and so on")
    try:
        return _map(content, os.path.dirname(os.path.abspath(path)))
    except ValueError as error:
        raise ValueError(f"map file {path}: {error}") from None


def _map(content, folder):
    missing = [
        key
        for key in (
            "image",
            "resolution",
            "origin",
            "negate",
            "occupied_thresh",
            "free_thresh",
        )
        if key not in content
    ]
    if missing:
        raise ValueError(f"it has no {', '.join(missing)}")
    origin = content["origin"]
    if not isinstance(origin, list) or len(origin) < 3:
        raise ValueError(f"origin is {yaml_file.formatted(origin)}, must be [x, y, yaw]")
    mode = content.get("mode", "trinary")
    if mode not in MODES:
        raise ValueError(f"mode is {yaml_file.formatted(mode)}, must be one of {', '.join(MODES)}")
    return from_image(
        os.path.join(folder, str(content["image"])),
        _number("resolution", content["resolution"]),
        tuple(_number("origin", value) for value in origin[:3]),
        bool(_number("negate", content["negate"])),
        _number("occupied_thresh", content["occupied_thresh"]),
        _number("free_thresh", content["free_thresh"]),
        mode,
    )


def from_image(
    path,
    resolution,
    origin=(0.0, 0.0, 0.0),
    negate=False,
    occupied_thresh=OCCUPIED_THRESH,
    free_thresh=FREE_THRESH,
    mode="trinary",
):
    """Reads an image as a map.

    Raises:
        ValueError: The image cannot be read, or the resolution is not positive.
    """
    if not resolution > 0.0:
        raise ValueError(f"resolution is {resolution:g} m, must be above 0")
    if not os.path.isfile(path):
        raise ValueError(f"image {path} does not exist")
    pixels = cv2.imread(path, cv2.IMREAD_UNCHANGED)
    if pixels is None:
        raise ValueError(f"image {path} is not an image that can be read")
    if pixels.dtype == np.uint16:
        pixels = (pixels >> 8).astype(np.uint8)
    cells = from_pixels(pixels, occupied_thresh, free_thresh, negate, mode)
    return Map(cells, resolution, tuple(origin))


def _number(name, value):
    try:
        number = float(value)
    except (TypeError, ValueError, OverflowError):
        raise ValueError(f"{name} is {yaml_file.formatted(value)}, must be a number") from None
    if not math.isfinite(number):
        raise ValueError(f"{name} is {value!r}, must be finite")
    return number


def save(name, grid, occupied=65, free=25):
    """Writes NAME.pgm and NAME.yaml.

    Args:
        name: Path without suffix.
        occupied: See to_pixels.
        free: See to_pixels.

    Raises:
        OSError: A file cannot be written.
    """
    image, path = f"{name}.pgm", f"{name}.yaml"
    success, data = cv2.imencode(".pgm", to_pixels(grid.cells, occupied, free))
    if not success:
        raise OSError(f"{image} cannot be encoded")
    with open(image, "wb") as stream:
        stream.write(data.tobytes())
    with open(path, "w", encoding="utf-8") as stream:
        stream.write(
            f"image: {os.path.basename(image)}\n"
            f"resolution: {grid.resolution:f}\n"
            "origin: [{:f}, {:f}, {:f}]\n".format(*grid.origin)
            + f"negate: 0\noccupied_thresh: {OCCUPIED_THRESH}\nfree_thresh: {FREE_THRESH}\n"
        )
    return image, path
