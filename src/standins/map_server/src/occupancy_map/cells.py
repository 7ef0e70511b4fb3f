"""Pixels of a picture as cells of an occupancy grid, and back."""

import numpy as np

OCCUPIED, FREE, UNKNOWN = 100, 0, -1
MODES = ("trinary", "scale", "raw")
BLACK, WHITE, GRAY = 0, 254, 205  # how cells are drawn: occupied, free, unknown


def from_pixels(pixels, occupied_thresh, free_thresh, negate=False, mode="trinary"):
    """Cells of a picture.

    A pixel's darkness is 1 for black and 0 for white, of the mean over its channels. Above
    occupied_thresh the cell is occupied (100), below free_thresh it is free (0). Between them:
    trinary: unknown (-1); scale: 1..99 in proportion, unknown where the picture is transparent.
    raw: the mean itself, 0..255 as a signed byte.

    Args:
        pixels: (H, W) or (H, W, channels) uint8; with two or four channels the last is alpha.
        occupied_thresh: Darkness, 0..1.
        free_thresh: Darkness, 0..1.
        negate: Whether black and white swap their meaning.
        mode: One of MODES.

    Returns:
        (H, W) int8; row 0 is the picture's lowest.
    """
    pixels = np.asarray(pixels)
    if pixels.ndim == 2:
        pixels = pixels[:, :, None]
    alpha = pixels[:, :, -1] if pixels.shape[2] in (2, 4) else None
    # Alpha counts as a channel in trinary mode: that is what maps in use were made for.
    colours = pixels if alpha is None or mode == "trinary" else pixels[:, :, :-1]
    mean = colours.mean(axis=2)
    if negate:
        mean = 255.0 - mean
    if mode == "raw":
        cells = mean.astype(np.uint8).astype(np.int8)
    else:
        darkness = (255.0 - mean) / 255.0
        cells = np.full(mean.shape, UNKNOWN, np.int8)
        if mode == "scale":
            way = (darkness - free_thresh) / max(occupied_thresh - free_thresh, 1e-12)
            between = (1.0 + 98.0 * np.clip(way, 0.0, 1.0)).astype(np.int8)
            cells = between if alpha is None else np.where(alpha == 0, cells, between)
        cells[darkness > occupied_thresh] = OCCUPIED
        cells[darkness < free_thresh] = FREE
    return np.ascontiguousarray(cells[::-1], np.int8)


def to_pixels(cells, occupied=65, free=25):
    """Draws cells.

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
