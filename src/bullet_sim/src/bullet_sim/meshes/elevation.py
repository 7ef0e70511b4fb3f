"""Elevation data as heightmaps: USGS DEM, GeoTIFF, ESRI ASCII grids and others, by GDAL.

As Gazebo's common::Dem has them: one band, which fills a square of 2^n + 1 points a side; what its
other side leaves is 0 m high.
"""

from __future__ import annotations

import math
import os
from dataclasses import dataclass
from typing import Any

import numpy as np

from bullet_sim.errors import ModelError
from bullet_sim.files import limit, too_many
from bullet_sim.pose import Array, Vec3

# Names of GDAL's drivers -> endings of their files. No others are used: some follow URLs.
DRIVERS = {
    "AAIGrid": (".asc", ".grd"),
    "DTED": (".dt0", ".dt1", ".dt2"),
    "EHdr": (".bil", ".flt"),
    "GTiff": (".tif", ".tiff"),
    "HFA": (".img",),
    "SRTMHGT": (".hgt",),
    "USGSDEM": (".dem",),
}
NO_DATA = -9999.0  # [m] this and less is none, where a file does not say what is
EARTH = 6371000.0  # [m] radius


def is_elevation(path: str) -> bool:
    """Whether a heightmap's file is elevation data by its ending, and no picture."""
    return os.path.splitext(path)[1].lower() in sum(DRIVERS.values(), ())


def has_reader() -> bool:
    """Whether GDAL is installed for this Python."""
    try:
        from osgeo import gdal  # noqa: F401
    except ImportError:
        return False
    return True


@dataclass
class Elevation:
    """Elevation data that fills a square.

    Attributes:
        data: (rows, columns) of the file [m], from the north west corner.
        low, high: of what is no gap [m].
        side: points along each side of the square, 2^n + 1.
        extent: width and height on the earth [m]; None where the file does not have them.
    """

    data: Array
    low: float
    high: float
    side: int
    extent: tuple[float, float] | None

    def at(self, numbers: Array) -> Array:
        """Heights (n, n) [m] of some rows, and the same columns, of the square.

        The longer side of the data has all of the square's points, the nearest is taken; the other
        one has as many as keep the ratio.
        """
        rows, columns = self.data.shape
        ratio = np.float32(max(rows, columns)) / np.float32(min(rows, columns))
        found = np.zeros((len(numbers), len(numbers)), np.float32)
        places, inside = [], []
        for count in (rows, columns):
            points = self.side
            if count < max(rows, columns):
                points = int(np.float32(self.side) / ratio)
            within = numbers < points
            inside.append(within)
            places.append(((numbers[within] + 0.5) * count / max(points, 1)).astype(int))
        found[np.ix_(*inside)] = self.data[np.ix_(*places)]
        return found

    def scaled(self, heights: Array, height: float) -> Array:
        """Heights [m] as a <size> of a height [m] has them: the lowest point stays where it is, the
        highest is so much above it, and gaps are as high as the lowest."""
        span = self.high - self.low
        factor = height / span if span > 0.0 else 1.0
        heights = self.low + (heights.astype(float) - self.low) * factor
        return np.fmax(heights, self.low)  # also where it is not a number


def read(path: str) -> Elevation:
    """The elevation data of a file.

    Raises:
        ModelError: GDAL is missing or cannot read it, it has several bands, too many points, or
            gaps alone.
    """
    label = f"heightmap '{path}'"
    try:
        from osgeo import gdal
    except ImportError:
        raise ModelError(f"{label} is elevation data, and GDAL is missing") from None
    if not os.path.isfile(path):
        raise ModelError(f"{label} is no file")
    gdal.PushErrorHandler("CPLQuietErrorHandler")
    try:
        dataset = gdal.OpenEx(path, gdal.OF_RASTER, allowed_drivers=list(DRIVERS))
        if dataset is None:
            raise ModelError(f"{label} cannot be read: {gdal.GetLastErrorMsg()}")
        columns, rows = dataset.RasterXSize, dataset.RasterYSize
        if dataset.RasterCount != 1:
            raise ModelError(f"{label} has {dataset.RasterCount} bands, must have one")
        if rows * columns > limit("image_pixels"):
            raise ModelError(f"{label} has {columns} x {rows} points, {too_many('image_pixels')}")
        band = dataset.GetRasterBand(1)
        raw = band.ReadRaster(0, 0, columns, rows, buf_type=gdal.GDT_Float32)
        if raw is None:
            raise ModelError(f"{label} cannot be read: {gdal.GetLastErrorMsg()}")
        no_data, extent = band.GetNoDataValue(), _extent(dataset)
    finally:
        gdal.PopErrorHandler()
    data = np.frombuffer(raw, np.float32).reshape(rows, columns)
    side = max(_side(rows), _side(columns))
    low, high = _range(data, NO_DATA if no_data is None else no_data, rows != columns)
    if low > high:
        raise ModelError(f"{label} has no heights above its value for gaps, {no_data}")
    return Elevation(data, low, high, side, extent)


def size(path: str, given: Vec3 | None) -> Vec3:
    """Width, depth and height [m] of a heightmap: its <size>, without one what its data have.

    Raises:
        ModelError: see read(), or the file does not say where on the earth it is.
    """
    found = read(path)
    if given is not None:
        return given
    if found.extent is None:
        raise ModelError(f"heightmap '{path}' needs a <size>: it does not have its place on earth")
    return (*found.extent, found.high - found.low)


def _range(data: Array, no_data: float, is_padded: bool) -> tuple[float, float]:
    """Lowest and highest point above a value, also of the 0 that a square is filled up with."""
    there = data[data > no_data]
    ends = [float(there.min()), float(there.max())] if there.size else []
    ends += [0.0] if is_padded and no_data < 0.0 else []
    return min(ends, default=math.inf), max(ends, default=-math.inf)


def _side(count: int) -> int:
    """The least 2^n + 1 that is not less than a count."""
    return (1 << max(count - 2, 0).bit_length()) + 1


def _extent(dataset: Any) -> tuple[float, float] | None:
    """Distances along the earth [m] from the first corner of a dataset to those beside it; grounds
    of the moon and Mars are as large as between the same angles on the earth, as in Gazebo."""
    from osgeo import osr

    transform, system = dataset.GetGeoTransform(can_return_null=True), dataset.GetSpatialRef()
    angles = None if transform is None or system is None else system.CloneGeogCS()
    if angles is None:
        return None
    for each in (system, angles):
        each.SetAxisMappingStrategy(osr.OAMS_TRADITIONAL_GIS_ORDER)  # longitude first
    a, b, c, d, e, f = transform
    corners = [(0, 0), (dataset.RasterXSize, 0), (0, dataset.RasterYSize)]
    to_angles = osr.CoordinateTransformation(system, angles)
    places = [to_angles.TransformPoint(a + x * b + y * c, d + x * e + y * f) for x, y in corners]
    first, *others = [np.radians(place[:2]) for place in places]
    width, depth = (_distance(first, other) for other in others)
    return (width, depth) if math.isfinite(width + depth) and min(width, depth) > 0.0 else None


def _distance(one: Array, other: Array) -> float:
    """Along a great circle [m] between two (longitude, latitude) [rad], by haversines."""
    longitude, latitude = np.sin((other - one) / 2.0) ** 2
    part = latitude + longitude * math.cos(one[1]) * math.cos(other[1])
    return 2.0 * EARTH * math.atan2(math.sqrt(part), math.sqrt(1.0 - part))
