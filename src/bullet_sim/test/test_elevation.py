"""Elevation data as heightmaps, held against Gazebo 11.10's Dem.cc and HeightmapShape.cc."""

import math
import sys

import numpy as np
import pytest
from bullet_sim.engine.api import Rays
from bullet_sim.meshes import elevation, terrain
from bullet_sim.pose import Pose
from bullet_sim.world import World
from osgeo import gdal, osr
from PIL import Image

SDF = (
    '<sdf version="1.6"><model name="m"><static>true</static><link name="l"><collision name="c">'
    "<geometry><heightmap><uri>{0}</uri>{1}</heightmap></geometry></collision></link></model></sdf>"
)
RISING = [[0, 0, 0], [100, 150, 300], [200, 200, 200]]


def _grid(path, rows, more=""):
    """Writes an ESRI ASCII grid; its last row is the south."""
    lines = [f"ncols {len(rows[0])}", f"nrows {len(rows)}", "xllcorner 0", "yllcorner 0"]
    lines += ["cellsize 2", more, *(" ".join(map(str, row)) for row in rows)]
    path.write_text("\n".join(filter(None, lines)) + "\n")
    return str(path)


def _geotiff(path, values, transform, code, bands=1):
    """Writes a GeoTIFF in the coordinates of an EPSG code."""
    values = np.asarray(values, np.float32)
    rows, columns = values.shape
    file = gdal.GetDriverByName("GTiff").Create(str(path), columns, rows, bands, gdal.GDT_Float32)
    system = osr.SpatialReference()
    system.ImportFromEPSG(code)
    file.SetProjection(system.ExportToWkt())
    file.SetGeoTransform(transform)
    file.GetRasterBand(1).WriteRaster(0, 0, columns, rows, values.tobytes())
    return file


def _spawned(path, size=""):
    world = World()
    model = world.spawn_sdf("ground", SDF.format(path, size), Pose(), str)
    return world, model.description.warnings


@pytest.mark.parametrize(
    "rows, more, height, expected",
    [
        # the lowest point stays at its height, the highest is <size> above it
        ([[100, 102, 104]] * 3, "", 8.0, [[100, 104, 108]] * 3),
        ([[-4, -3, -2]] * 3, "", 2.0, [[-4, -3, -2]] * 3),
        ([[7, 7, 7]] * 3, "", 5.0, [[7, 7, 7]] * 3),
        # gaps: at or below the file's value for them, or -9999, are as high as the lowest point
        ([[50, 40, -99], [40, 40, 45], [-200, 40, 40]], "NODATA_value -99", 10.0,
         [[50, 40, 40], [40, 40, 45], [40, 40, 40]]),
        ([[50, 40, -32768], [40, 40, 45], [40, 40, 40]], "", 10.0,
         [[50, 40, 40], [40, 40, 45], [40, 40, 40]]),
        # 4 x 2 points: 5 points a side, the nearest; 2 rows of it, as the ratio is 2; then zeros
        ([[10, 20, 30, 40], [50, 60, 70, 80]], "", 80.0,
         [[10, 20, 30, 30, 40], [50, 60, 70, 70, 80], [0] * 5, [0] * 5, [0] * 5]),
        ([[10, 20], [30, 40], [50, 60]], "", 120.0,
         [[20, 40, 0], [60, 80, 0], [100, 120, 0]]),
    ],
)  # fmt: skip
def test_heights_of_elevation_data(tmp_path, rows, more, height, expected):
    path = _grid(tmp_path / "ground.asc", rows, more)
    vertices, _ = terrain.heightmap(path, (8.0, 4.0, height))
    count = len(expected)
    assert vertices[:, 2].reshape(count, count) == pytest.approx(np.array(expected, float))
    assert vertices[0, :2].tolist() == [-4.0, 2.0] and vertices[-1, :2].tolist() == [4.0, -2.0]


def test_points_between_those_of_the_data_are_interpolated_and_great_ones_thinned_out(tmp_path):
    path = _grid(tmp_path / "ground.asc", RISING)
    row = terrain.heightmap(path, (4.0, 4.0, 300.0), 2)[0][10:15, 2]  # the middle one
    assert row == pytest.approx(np.array([100.0, 125.0, 150.0, 225.0, 300.0]))
    path = _grid(tmp_path / "great.asc", [range(1025)] * 1025)
    vertices, _ = terrain.heightmap(path, (1.0, 1.0, 1024.0), 2)
    assert len(vertices) == terrain.MAX_POINTS**2
    assert vertices[: terrain.MAX_POINTS, 2] == pytest.approx(np.arange(0.0, 1025.0, 2.0))


METERS = (500000.0, 30.0, 0.0, 4000000.0, 0.0, -20.0)
DEGREES = (10.0, 0.001, 0.0, 60.0, 0.0, -0.002)
DEGREE = math.radians(elevation.EARTH)  # of latitude [m]; of longitude, at 60 degrees, half of it


@pytest.mark.parametrize(
    "transform, code, expected, tolerance",
    [
        (DEGREES, 4326, (0.0015 * DEGREE, 0.006 * DEGREE), 1e-6),
        (METERS, 32633, (90.0, 60.0), 4e-3),  # the ellipsoid's meters on Gazebo's sphere
    ],
)
def test_without_a_size_the_ground_is_as_large_as_on_the_earth(
    tmp_path, transform, code, expected, tolerance
):
    path = str(tmp_path / "ground.tif")
    _geotiff(path, RISING, transform, code).FlushCache()
    x, y, z = elevation.size(path, None)
    assert (x, y) == pytest.approx(expected, rel=tolerance) and z == 300.0
    world, warnings = _spawned(path)
    above, down = np.array((x / 2 - 1e-3, 0.0, 1000.0)), np.array([(0.0, 0.0, -1.0)])
    assert world.engine.cast_rays(Rays(above, down, 0.0, 2e3)) == pytest.approx([700.0], abs=0.1)
    assert warnings == []
    world.close()


def test_a_usgs_dem_is_read(tmp_path):
    file = _geotiff(tmp_path / "ground.tif", np.full((20, 20), 7.0), DEGREES, 4326)
    path = str(tmp_path / "ground.dem")
    gdal.GetDriverByName("USGSDEM").CreateCopy(path, file).FlushCache()
    found = elevation.read(path)
    assert found.high == 7.0 and found.side >= 21


def test_heights_at_which_textures_begin_are_above_the_lowest_point(tmp_path):
    path = _grid(tmp_path / "ground.asc", [[100, 102, 104]] * 3)
    Image.new("RGB", (2, 2)).save(tmp_path / "a.png")
    texture = f"<texture><diffuse>{tmp_path / 'a.png'}</diffuse></texture>"
    more = f"<size>8 8 8</size>{texture * 2}<blend><min_height>3</min_height></blend>"
    text = SDF.replace("collision", "visual").format(path, more)
    world = World()
    description = world.spawn_sdf("ground", text, Pose(), str).description
    (shape,) = description.links["l"].visuals
    assert [layer.blend[0] for layer in shape.finish.layers] == [103.0]
    world.close()


def _two_bands(path):
    _geotiff(path, RISING, DEGREES, 4326, 2).FlushCache()


@pytest.mark.parametrize(
    "name, write, size, words",
    [
        ("bands.tif", _two_bands, "", "has 2 bands, must have one"),
        ("place.asc", lambda path: _grid(path, RISING), "", "needs a <size>"),
        ("gaps.asc", lambda path: _grid(path, [[-9999] * 3] * 3), "<size>1 1 1</size>", "gaps"),
        ("text.dem", lambda path: path.write_text("no ground"), "", "cannot be read"),
        ("link.tif", lambda path: path.write_text('<VRTDataset rasterXSize="2"/>'), "", "be read"),
    ],
)
def test_what_is_no_ground_is_left_out_with_a_sentence(tmp_path, name, write, size, words):
    write(tmp_path / name)
    world, (warning,) = _spawned(tmp_path / name, size)
    assert name in warning and words in warning and "left out" in warning
    world.close()


def test_without_gdal_a_sentence_names_its_package(tmp_path, monkeypatch):
    path = _grid(tmp_path / "ground.asc", RISING)
    monkeypatch.setitem(sys.modules, "osgeo", None)
    world, (warning,) = _spawned(path, "<size>1 1 1</size>")
    assert "apt-get install python3-gdal" in warning and warning.cause.endswith("left out")
    world.close()
