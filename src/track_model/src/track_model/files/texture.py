"""The picture on the ground: grass, asphalt, borders, dashes, start line."""

import cv2
import numpy as np

from track_model.curves import left_normals, tangents
from track_model.region import lane_area, rings

RESOLUTION = 0.005  # [m/px], coarser if the picture would be larger than MAX_PIXELS
MAX_PIXELS = 2048  # a side; tracks coarser than COARSE with that get LARGE_PIXELS
COARSE = 0.008  # [m/px]
LARGE_PIXELS = 4096
MARGIN = 0.5  # grass beyond the outermost border [m]
SHIFT = 4  # fractional bits of OpenCV's polygon corners


def extent(lane):
    """Return (xmin, xmax, ymin, ymax) [m] of the picture of a lane."""
    reach = max(lane.left.max(), lane.right.max()) + MARGIN
    low, high = lane.curve.min(axis=0) - reach, lane.curve.max(axis=0) + reach
    return float(low[0]), float(high[0]), float(low[1]), float(high[1])


def resolution(area):
    """Return the metres that one pixel covers for an extent."""
    side = max(area[1] - area[0], area[3] - area[2])
    pixels = MAX_PIXELS if side / MAX_PIXELS <= COARSE else LARGE_PIXELS
    return max(RESOLUTION, side / pixels)


def whole_pixels(area):
    """Return (extent widened to the right and downwards to whole pixels, (rows, columns)).

    Columns come in fours: OpenGL takes rows of a texture to be aligned to four bytes, and
    PyBullet's EGL renderer draws any other width as coloured stripes.
    """
    pixel = resolution(area)
    rows, columns = (
        int(np.ceil(side / pixel - 1e-6)) for side in (area[3] - area[2], area[1] - area[0])
    )
    columns = -(-columns // 4) * 4
    return (area[0], area[0] + columns * pixel, area[3] - rows * pixel, area[3]), (rows, columns)


def to_pixels(points, area):
    """Convert ground points to pixel positions: x to the right, y up, (0, 0) the top left corner.

    Args:
        points: (N, 2) in the track's frame [m].
        area: (xmin, xmax, ymin, ymax) of the picture [m].

    Returns:
        (N, 2) column and row as floats.
    """
    points = np.asarray(points, dtype=float)
    return np.stack([points[:, 0] - area[0], area[3] - points[:, 1]], axis=1) / resolution(area)


def _fill(image, polygons, area, colour):
    # OpenCV's integer corner positions are pixel centres, hence the half.
    corners = [
        np.round((to_pixels(points, area) - 0.5) * (1 << SHIFT)).astype(np.int32)
        for points in polygons
    ]
    cv2.fillPoly(image, corners, colour, cv2.LINE_AA, SHIFT)


def _strip(curve, normals, low, high):
    return np.vstack([curve + low * normals, (curve + high * normals)[::-1]])


def dashes(lane, spec):
    """Yield the centre line's dashes as (M, 2) pieces of the curve, evenly spread over it."""
    whole = lane.length
    period = spec.dash_length + spec.dash_gap
    count = max(1, int(round(whole / period)))
    share = spec.dash_length / period
    line = np.vstack([lane.curve, lane.curve[:1]]) if lane.closed else lane.curve
    along = np.linspace(0.0, whole, len(line))
    for k in range(count):
        at = np.linspace(k, k + share, 6) * whole / count
        yield np.stack([np.interp(at, along, line[:, axis]) for axis in (0, 1)], axis=1)


def cross_lines(lane, spec):
    """Yield the corners (4, 2) of the lines across the lane: start, and finish if it is open."""
    across, ahead = (f(lane.curve, lane.closed) for f in (left_normals, tangents))
    for k in (0,) if lane.closed else (0, -1):
        left = lane.curve[k] + (lane.left[k] - spec.border_width) * across[k]
        right = lane.curve[k] - (lane.right[k] - spec.border_width) * across[k]
        half = 0.02 * ahead[k]
        yield np.array([right - half, left - half, left + half, right + half])


def _noise(shape, generator, cell, strength):
    small = generator.standard_normal((shape[0] // cell + 2, shape[1] // cell + 2))
    large = cv2.resize(
        small.astype(np.float32), (shape[1], shape[0]), interpolation=cv2.INTER_LINEAR
    )
    return large * strength


def paint(lane, spec):
    """Paint the ground seen from above.

    Args:
        lane: geometry.Lane.
        spec: TrackSpec.

    Returns:
        (image (H, W, 3) uint8 BGR, extent (xmin, xmax, ymin, ymax) [m]); north (+y) is up.
    """
    area, shape = whole_pixels(extent(lane))
    bgr = {name: tuple(rgb[::-1]) for name, rgb in spec.colours.items()}
    image = np.empty((*shape, 3), np.uint8)
    image[:] = bgr["grass"]
    # lines are drawn at least a pixel and a half wide
    least = 1.5 * resolution(area)
    _fill(image, rings(lane_area(lane)), area, bgr["border"])
    _fill(image, rings(lane_area(lane, max(spec.border_width, least))), area, bgr["asphalt"])
    line = max(spec.centre_line_width, least) / 2.0
    for piece in dashes(lane, spec):
        direction = np.gradient(piece, axis=0)
        direction /= np.linalg.norm(direction, axis=1)[:, None]
        _fill(
            image,
            [_strip(piece, direction[:, ::-1] * (-1.0, 1.0), -line, line)],
            area,
            bgr["centre_line"],
        )
    if spec.start_line:
        for corners in cross_lines(lane, spec):
            _fill(image, [corners], area, bgr["border"])
    generator = np.random.Generator(np.random.PCG64(spec.seed))
    grain = _noise(shape, generator, 2, 3.0) + _noise(shape, generator, 40, 2.5)
    return np.clip(image + grain[:, :, None], 0, 255).astype(np.uint8), area
