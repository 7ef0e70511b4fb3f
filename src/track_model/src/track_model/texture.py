"""The picture on the ground: grass, asphalt, borders, dashes, start line."""
import cv2
import numpy as np

from track_model.geometry import closed_length, left_normals, offset, tangents

RESOLUTION = 0.005      # [m/px], coarser if the picture would be larger than MAX_PIXELS
MAX_PIXELS = 2048
MARGIN = 0.5            # grass beyond the outermost border [m]
SHIFT = 4               # fractional bits of OpenCV's polygon corners


def extent(curve, width):
    """Return (xmin, xmax, ymin, ymax) [m] of the picture of a lane around a curve."""
    low = curve.min(axis=0) - width / 2.0 - MARGIN
    high = curve.max(axis=0) + width / 2.0 + MARGIN
    return float(low[0]), float(high[0]), float(low[1]), float(high[1])


def resolution(area):
    """Return the metres that one pixel covers for an extent."""
    return max(RESOLUTION, (area[1] - area[0]) / MAX_PIXELS, (area[3] - area[2]) / MAX_PIXELS)


def whole_pixels(area):
    """Return (extent widened to the right and downwards to whole pixels, (rows, columns)).

    Columns come in fours: OpenGL takes rows of a texture to be aligned to four bytes, and
    PyBullet's EGL renderer draws any other width as coloured stripes.
    """
    pixel = resolution(area)
    rows, columns = (int(np.ceil(side / pixel - 1e-6))
                     for side in (area[3] - area[2], area[1] - area[0]))
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


def _fill(image, points, area, colour):
    # OpenCV's integer corner positions are pixel centres, hence the half.
    corners = np.round((to_pixels(points, area) - 0.5) * (1 << SHIFT)).astype(np.int32)
    cv2.fillPoly(image, [corners], colour, cv2.LINE_AA, SHIFT)


def _strip(curve, normals, low, high):
    return np.vstack([curve + low * normals, (curve + high * normals)[::-1]])


def dashes(curve, spec):
    """Yield the centre line's dashes as (M, 2) pieces of the curve, evenly spread over it."""
    length = closed_length(curve)
    period = spec.dash_length + spec.dash_gap
    count = max(1, int(round(length / period)))
    share = spec.dash_length / period
    along = np.linspace(0.0, length, len(curve) + 1)
    closed = np.vstack([curve, curve[:1]])
    for k in range(count):
        at = np.linspace(k, k + share, 6) * length / count
        yield np.stack([np.interp(at, along, closed[:, axis]) for axis in (0, 1)], axis=1)


def _noise(shape, generator, cell, strength):
    small = generator.standard_normal((shape[0] // cell + 2, shape[1] // cell + 2))
    large = cv2.resize(small.astype(np.float32), (shape[1], shape[0]),
                       interpolation=cv2.INTER_LINEAR)
    return large * strength


def paint(curve, spec):
    """Paint the ground seen from above.

    Args:
        curve: Centreline (N, 2) in the track's frame [m].
        spec: TrackSpec.

    Returns:
        (image (H, W, 3) uint8 BGR, extent (xmin, xmax, ymin, ymax) [m]); north (+y) is up.
    """
    area, shape = whole_pixels(extent(curve, spec.width))
    bgr = {name: tuple(rgb[::-1]) for name, rgb in spec.colours.items()}
    image = np.empty((*shape, 3), np.uint8)
    image[:] = bgr['grass']
    half, border = spec.width / 2.0, spec.border_width
    rings = sorted((offset(curve, side * half) for side in (-1.0, 1.0)), key=closed_length)
    inside = sorted((offset(curve, side * (half - border)) for side in (-1.0, 1.0)),
                    key=closed_length)
    _fill(image, rings[1], area, bgr['border'])
    _fill(image, inside[1], area, bgr['asphalt'])
    _fill(image, inside[0], area, bgr['border'])
    _fill(image, rings[0], area, bgr['grass'])
    line = spec.centre_line_width / 2.0
    for piece in dashes(curve, spec):
        direction = np.gradient(piece, axis=0)
        direction /= np.linalg.norm(direction, axis=1)[:, None]
        _fill(image, _strip(piece, direction[:, ::-1] * (-1.0, 1.0), -line, line), area,
              bgr['centre_line'])
    if spec.start_line:
        across, ahead = left_normals(curve)[0], tangents(curve)[0]
        ends = np.array([-1.0, 1.0])[:, None] * across * (half - border)
        _fill(image, np.vstack([curve[0] + ends - 0.02 * ahead,
                                (curve[0] + ends + 0.02 * ahead)[::-1]]), area, bgr['border'])
    generator = np.random.Generator(np.random.PCG64(spec.seed))
    grain = _noise(shape, generator, 2, 3.0) + _noise(shape, generator, 40, 2.5)
    return np.clip(image + grain[:, :, None], 0, 255).astype(np.uint8), area
