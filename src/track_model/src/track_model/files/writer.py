"""A track's files: textures, meshes, worlds."""

from __future__ import annotations

import os
import pathlib
from collections.abc import Iterable, Iterator
from typing import Any, Tuple

import cv2
import numpy as np
import numpy.typing as npt

from track_model import geometry
from track_model.curves import left_normals, tangents
from track_model.geometry import Lane
from track_model.region import lane_area, rings
from track_model.spec import TrackSpec

Extent = Tuple[float, float, float, float]  # xmin, xmax, ymin, ymax [m]

RESOLUTION = 0.005  # [m/px], coarser if the image would be larger than MAX_PIXELS
MAX_PIXELS = 2048  # per side; tracks coarser than COARSE at this size get LARGE_PIXELS
COARSE = 0.008  # [m/px]
LARGE_PIXELS = 4096
MARGIN = 0.5  # grass beyond the outermost border [m]
SHIFT = 4  # fractional bits of OpenCV's polygon corners
FINE, BAND = 8, 64  # a pixel's parts along each axis, by which lines cover it; rows at a time


def extent(lane: Lane) -> Extent:
    """Return (xmin, xmax, ymin, ymax) [m] of the image of a lane."""
    distance = max(lane.left.max(), lane.right.max()) + MARGIN
    low, high = lane.curve.min(axis=0) - distance, lane.curve.max(axis=0) + distance
    return float(low[0]), float(high[0]), float(low[1]), float(high[1])


def resolution(area: Extent) -> float:
    """Return the size of a pixel [m] for an extent."""
    side = max(area[1] - area[0], area[3] - area[2])
    pixels = MAX_PIXELS if side / MAX_PIXELS <= COARSE else LARGE_PIXELS
    return max(RESOLUTION, side / pixels)


def whole_pixels(area: Extent) -> tuple[Extent, tuple[int, int]]:
    """Return (extent widened to the right and downwards to whole pixels, (rows, columns)).

    The number of columns is a multiple of four: OpenGL expects rows of a texture to be aligned to
    four bytes, and PyBullet's EGL renderer shows any other width as colored stripes.
    """
    pixel = resolution(area)
    rows, columns = (
        int(np.ceil(side / pixel - 1e-6)) for side in (area[3] - area[2], area[1] - area[0])
    )
    columns = -(-columns // 4) * 4
    return (area[0], area[0] + columns * pixel, area[3] - rows * pixel, area[3]), (rows, columns)


def to_pixels(points: npt.ArrayLike, area: Extent) -> npt.NDArray[Any]:
    """Convert ground points to pixel positions: x to the right, y up, (0, 0) the top left corner.

    Args:
        points: (N, 2) in the track's frame [m].
        area: (xmin, xmax, ymin, ymax) of the image [m].

    Returns:
        (N, 2) column and row as floats.
    """
    points = np.asarray(points, dtype=float)
    return np.stack([points[:, 0] - area[0], area[3] - points[:, 1]], axis=1) / resolution(area)


def _fill(
    image: npt.NDArray[Any],
    polygons: Iterable[npt.NDArray[Any]],
    area: Extent,
    color: tuple[int, ...],
) -> None:
    """Mix a color into each pixel by the share of it that polygons cover.

    cv2.LINE_AA leaves steps in edges that are nearly level, which a camera close by sees.
    """
    corners = [to_pixels(points, area) for points in polygons]
    low = np.maximum(0, np.floor(np.min([c.min(axis=0) for c in corners], axis=0)).astype(int))
    high = np.ceil(np.max([c.max(axis=0) for c in corners], axis=0)).astype(int) + 1
    for top in range(low[1], min(high[1], len(image)), BAND):
        band = image[top : min(top + BAND, high[1]), low[0] : high[0]]
        rows, columns = band.shape[:2]
        fine = np.zeros((rows * FINE, columns * FINE), np.uint8)
        # OpenCV's integer corner positions are pixel centers, hence the half.
        placed = [((c - (low[0], top)) * FINE - 0.5) * (1 << SHIFT) for c in corners]
        cv2.fillPoly(fine, [np.round(c).astype(np.int32) for c in placed], 255, cv2.LINE_8, SHIFT)
        share = cv2.resize(fine, (columns, rows), interpolation=cv2.INTER_AREA)[..., None] / 255.0
        band[:] = np.round(band + share * (np.array(color) - band))


def _strip(
    curve: npt.NDArray[Any], normals: npt.NDArray[Any], low: float, high: float
) -> npt.NDArray[Any]:
    return np.vstack([curve + low * normals, (curve + high * normals)[::-1]])


def dashes(lane: Lane, spec: TrackSpec) -> Iterator[npt.NDArray[Any]]:
    """Yield the center line's dashes as (M, 2) parts of the curve, evenly distributed."""
    length = lane.length
    period = spec.dash_length + spec.dash_gap
    count = max(1, int(round(length / period)))
    fraction = spec.dash_length / period
    line = np.vstack([lane.curve, lane.curve[:1]]) if lane.closed else lane.curve
    along = np.linspace(0.0, length, len(line))
    for k in range(count):
        at = np.linspace(k, k + fraction, 6) * length / count
        yield np.stack([np.interp(at, along, line[:, axis]) for axis in (0, 1)], axis=1)


def cross_lines(lane: Lane, spec: TrackSpec) -> Iterator[npt.NDArray[Any]]:
    """Yield the corners (4, 2) of the lines across the lane: start, and finish if it is open."""
    across, ahead = (f(lane.curve, lane.closed) for f in (left_normals, tangents))
    for k in (0,) if lane.closed else (0, -1):
        left = lane.curve[k] + (lane.left[k] - spec.border_width) * across[k]
        right = lane.curve[k] - (lane.right[k] - spec.border_width) * across[k]
        half = 0.02 * ahead[k]
        yield np.array([right - half, left - half, left + half, right + half])


def _noise(
    shape: tuple[int, int], generator: np.random.Generator, cell: int, strength: float
) -> npt.NDArray[Any]:
    small = generator.standard_normal((shape[0] // cell + 2, shape[1] // cell + 2))
    large = cv2.resize(
        small.astype(np.float32), (shape[1], shape[0]), interpolation=cv2.INTER_LINEAR
    )
    return large * strength


def render(lane: Lane, spec: TrackSpec) -> tuple[npt.NDArray[Any], Extent]:
    """Render the ground from above.

    Returns:
        (image (H, W, 3) uint8 BGR, extent (xmin, xmax, ymin, ymax) [m]); north (+y) is up.
    """
    area, shape = whole_pixels(extent(lane))
    bgr = {name: tuple(rgb[::-1]) for name, rgb in spec.colors.items()}
    image = np.empty((*shape, 3), np.uint8)
    image[:] = bgr["grass"]
    # lines are at least a pixel and a half wide
    minimum = 1.5 * resolution(area)
    _fill(image, rings(lane_area(lane)), area, bgr["border"])
    _fill(image, rings(lane_area(lane, max(spec.border_width, minimum))), area, bgr["asphalt"])
    line = max(spec.centre_line_width, minimum) / 2.0
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


SURROUNDINGS = 30.0  # width of the plain grass around the image [m]

GROUND_LINK = """    <link name="ground">
      <collision name="plane">
        <geometry><plane><normal>0 0 1</normal><size>100 100</size></plane></geometry>
        <surface><friction><ode><mu>{mu:g}</mu><mu2>{mu:g}</mu2></ode></friction></surface>
      </collision>
      <visual name="picture">
        <geometry><mesh><uri>{uri}</uri></mesh></geometry>
      </visual>
    </link>
"""
WALL = """      <{tag} name="wall_{index}">
        <pose>{x:.4f} {y:.4f} {z:.4f} 0 0 {yaw:.5f}</pose>
        <geometry><box><size>{length:.4f} {thickness:g} {height:g}</size></box></geometry>
{extra}      </{tag}>
"""
WORLD = """<?xml version="1.0"?>
<sdf version="1.6">
  <world name="{name}">
    <physics type="ode">
      <max_step_size>0.001</max_step_size>
      <real_time_factor>1.0</real_time_factor>
      <real_time_update_rate>1000</real_time_update_rate>
      <ode>
        <solver><type>quick</type><iters>100</iters><sor>1.3</sor></solver>
      </ode>
    </physics>
    <include><uri>model://sun</uri></include>
{model}  </world>
</sdf>
"""


def ground_obj(area: Extent) -> str:
    """Return the OBJ text of the ground: the image in the center, eight plain tiles around it.

    Args:
        area: (xmin, xmax, ymin, ymax) of the image [m]; v = 0 is its lower edge (ymin).
    """
    xs = (area[0] - SURROUNDINGS, area[0], area[1], area[1] + SURROUNDINGS)
    ys = (area[2] - SURROUNDINGS, area[2], area[3], area[3] + SURROUNDINGS)
    lines = ["mtllib track.mtl", "o track", "usemtl track", "vn 0 0 1", "vt 0.002 0.002"]
    faces: list[str] = []
    for i in range(3):
        for j in range(3):
            corners = (
                (xs[i], ys[j]),
                (xs[i + 1], ys[j]),
                (xs[i + 1], ys[j + 1]),
                (xs[i], ys[j + 1]),
            )
            first = 4 * len(faces) // 2 + 1
            lines += ["v {:.5f} {:.5f} 0".format(*corner) for corner in corners]
            # Only the center tile has the image; the others repeat its grass corner.
            uv = (2, 3, 4, 5) if i == j == 1 else (1, 1, 1, 1)
            faces += [
                "f " + " ".join(f"{first + k}/{uv[k]}/1" for k in order)
                for order in ((0, 1, 2), (0, 2, 3))
            ]
    lines += ["vt 0 0", "vt 1 0", "vt 1 1", "vt 0 1"]
    return "\n".join(lines + faces) + "\n"


def wall_boxes(lane: Lane, spec: TrackSpec) -> Iterator[tuple[float, float, float, float]]:
    """Yield (x, y, yaw, length) of wall boxes along both borders [m], [rad]."""
    distance = spec.walls.gap + spec.walls.thickness / 2.0
    for side, sides in ((-1.0, lane.right), (1.0, lane.left)):
        line = lane.edge(side, -distance)
        # An inner wall behind a tight bend folds over: skip boxes too close to the lane.
        half = np.minimum(lane.left, lane.right) if spec.imported else sides
        near = (
            np.linalg.norm(line[:, None] - lane.curve[None, ::4], axis=2)
            < half[None, ::4] + distance - 0.02
        ).any(axis=1)
        if np.count_nonzero(~near) < 2:
            continue  # no space for a wall on this side
        corners = cv2.approxPolyDP((line * 1000.0).astype(np.int32)[~near], 10, lane.closed)
        corners = corners[:, 0].astype(float) / 1000.0
        ends = np.roll(corners, -1, axis=0) if lane.closed else corners[1:]
        for a, b in zip(corners, ends):
            yield (
                (a[0] + b[0]) / 2.0,
                (a[1] + b[1]) / 2.0,
                float(np.arctan2(b[1] - a[1], b[0] - a[0])),
                float(np.hypot(*(b - a))) + spec.walls.thickness / 2.0,
            )


def model_sdf(lane: Lane, spec: TrackSpec, directory: str) -> str:
    """Return the `<model name="track">` element; mesh URIs point into a directory."""
    text = '  <model name="track">\n    <static>true</static>\n'
    uri = pathlib.Path(directory, "track.obj").as_uri()
    text += GROUND_LINK.format(mu=spec.friction, uri=uri)
    if spec.walls.enabled:
        color = " ".join("%.3f" % (channel / 255.0) for channel in spec.colors["wall"])
        material = (
            f"        <material><ambient>{color} 1</ambient>"
            f"<diffuse>{color} 1</diffuse></material>\n"
        )
        text += '    <link name="walls">\n'
        for index, (x, y, yaw, length) in enumerate(wall_boxes(lane, spec)):
            for tag, extra in (("collision", ""), ("visual", material)):
                text += WALL.format(
                    tag=tag,
                    index=index,
                    x=x,
                    y=y,
                    z=spec.walls.height / 2.0,
                    yaw=yaw,
                    length=length,
                    thickness=spec.walls.thickness,
                    height=spec.walls.height,
                    extra=extra,
                )
        text += "    </link>\n"
    return text + "  </model>\n"


def sdf_file(model: str) -> str:
    """Return the content of track.sdf.

    Args:
        model: Of model_sdf().
    """
    return f'<?xml version="1.0"?>\n<sdf version="1.6">\n{model}</sdf>\n'


def preview(image: npt.NDArray[Any], area: Extent) -> npt.NDArray[Any]:
    """Return the image at 1000 px with the start frame's axes and a 1 m scale."""
    scale = 1000.0 / max(image.shape[:2])
    small = cv2.resize(image, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)

    def at(x: float, y: float) -> tuple[int, int]:
        column, row = to_pixels(np.array([(x, y)]), area)[0] * scale
        return int(round(column)), int(round(row))

    cv2.arrowedLine(small, at(0, 0), at(0.6, 0), (40, 40, 255), 2, cv2.LINE_AA, 0, 0.3)
    cv2.arrowedLine(small, at(0, 0), at(0, 0.6), (80, 255, 80), 2, cv2.LINE_AA, 0, 0.3)
    x, y = area[0] + 0.2, area[2] + 0.15
    cv2.line(small, at(x, y), at(x + 1.0, y), (255, 255, 255), 2)
    cv2.putText(
        small,
        "1 m",
        at(x + 0.35, y + 0.08),
        cv2.FONT_HERSHEY_SIMPLEX,
        0.45,
        (255, 255, 255),
        1,
        cv2.LINE_AA,
    )
    return small


def write(spec: TrackSpec, directory: str, final: str) -> None:
    """Write all files of a track.

    Args:
        spec: The track.
        directory: Existing folder to write into.
        final: Absolute path of the final folder, for the URIs.

    Raises:
        TrackError: The geometry is not valid.
    """
    lane = geometry.lane(spec)
    image, area = render(lane, spec)
    model = model_sdf(lane, spec, final)
    texts = {
        "track.obj": ground_obj(area),
        "track.mtl": "newmtl track\nKa 1 1 1\nKd 1 1 1\nKs 0 0 0\nillum 1\nmap_Kd track.png\n",
        "track.sdf": sdf_file(model),
        "track.world": WORLD.format(name="track_world", model=model),
    }
    for name, text in texts.items():
        with open(os.path.join(directory, name), "w", encoding="utf-8") as stream:
            stream.write(text)
    for name, pixels in (("track.png", image), ("preview.png", preview(image, area))):
        if not cv2.imwrite(os.path.join(directory, name), pixels):
            raise OSError(f"cannot write {os.path.join(directory, name)}")
