"""Heightmaps and polylines: meshes in closed form, in a world, and what cannot be used."""

import numpy as np
import pytest
from bullet_sim.engine.api import Rays
from bullet_sim.errors import ModelError
from bullet_sim.meshes import terrain
from bullet_sim.pose import Pose
from bullet_sim.world import World
from PIL import Image

SDF = (
    '<sdf version="1.6"><model name="m"><static>true</static><link name="l"><collision name="c">'
    '<geometry>{0}</geometry></collision><visual name="v"><geometry>{0}</geometry></visual></link>'
    "</model></sdf>"
)


@pytest.fixture(name="ramp")
def _ramp(tmp_path):
    """An image that gets brighter to the right, and black in its top row."""
    gray = np.tile(np.linspace(0, 255, 33).astype(np.uint8), (33, 1))
    gray[0] = 0
    path = tmp_path / "ramp.png"
    Image.fromarray(gray).save(path)
    return str(path)


def _volume(vertices, faces):
    """Of a closed mesh whose faces look outwards."""
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    return float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6.0)


@pytest.mark.parametrize(
    "points, area",
    [
        ([(0, 0), (2, 0), (2, 1), (0, 1)], 2.0),
        ([(0, 0), (0, 1), (2, 1), (2, 0), (0, 0)], 2.0),  # the other way round, closed
        ([(0, 0), (3, 0), (3, 3), (2, 3), (2, 1), (1, 1), (1, 3), (0, 3)], 7.0),  # a U
    ],
)
def test_an_extruded_polygon_has_its_volume(points, area):
    vertices, faces = terrain.extruded([points], 0.5)
    assert _volume(vertices, faces) == pytest.approx(0.5 * area)
    assert (vertices[:, 2].min(), vertices[:, 2].max()) == (0.0, 0.5)


@pytest.mark.parametrize(
    "points, words",
    [([(0, 0), (1, 0)], "2 corners"), ([(0, 0), (2, 2), (2, 0), (0, 2)], "sides that cross")],
)
def test_what_is_no_polygon_is_an_error(points, words):
    with pytest.raises(ModelError, match=words):
        terrain.extruded([points], 1.0)


def _square(x, y, size):
    return [(x, y), (x + size, y), (x + size, y + size), (x, y + size)]


@pytest.mark.parametrize(
    "outlines, area",
    [
        ([_square(0, 0, 4), _square(1, 1, 1)], 15.0),
        ([_square(1, 1, 1), _square(0, 0, 4)], 15.0),  # the hole first
        ([_square(0, 0, 4), _square(1, 1, 1), _square(2.5, 2.5, 1), _square(1, 2.5, 1)], 13.0),
        ([_square(0, 0, 9), _square(1, 1, 6), _square(2, 2, 3)], 81.0 - 36.0 + 9.0),
        ([_square(0, 0, 1), _square(3, 0, 2)], 5.0),  # side by side
    ],
)
def test_an_outline_within_another_is_a_hole(outlines, area):
    vertices, faces = terrain.extruded(outlines, 0.5)
    assert _volume(vertices, faces) == pytest.approx(0.5 * area)
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    up = np.cross(b - a, c - a)[:, 2] / 2.0
    assert up[up > 0].sum() == pytest.approx(area) and up.sum() == pytest.approx(0.0)


def test_a_heightmap_rises_with_the_grey_and_its_top_is_towards_y(ramp):
    vertices, faces = terrain.heightmap(ramp, (8.0, 4.0, 2.0))
    assert len(vertices) == 33 * 33 and len(faces) == 2 * 32 * 32
    assert vertices.min(0).tolist() == [-4.0, -2.0, 0.0]
    assert vertices.max(0).tolist() == [4.0, 2.0, 2.0]
    assert vertices[vertices[:, 1] == 2.0][:, 2].max() == 0.0
    bottom = vertices[vertices[:, 1] == -2.0]
    assert bottom[:, 2] == pytest.approx((bottom[:, 0] + 4.0) / 4.0, abs=2.0 / 255)
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    assert (np.cross(b - a, c - a)[:, 2] > 0).all()  # all look up


def test_great_images_are_thinned_out(tmp_path):
    path = tmp_path / "great.png"
    Image.fromarray(np.full((600, 300), 51, np.uint8)).save(path)
    vertices, _ = terrain.heightmap(str(path), (1.0, 1.0, 5.0))
    assert len(vertices) == terrain.MAX_POINTS * 300
    assert vertices[:, 2] == pytest.approx(np.full(len(vertices), 5.0))  # it is the brightest


@pytest.mark.parametrize("count, sampling, side", [(600, 2, 1199), (600, 1, 600), (5000, 2, 4097)])
def test_bodies_rest_on_all_points_of_great_images(tmp_path, count, sampling, side):
    """As in Gazebo, up to MAX_GRID a side; a ridge of one pixel is where and as high as it is."""
    gray = np.zeros((count, 3), np.uint8)
    gray[301] = 255
    path = tmp_path / "ridge.png"
    Image.fromarray(gray).save(path)
    heights = terrain.grid(str(path), (1.0, 1.0, 5.0), sampling)[:, 0]
    assert len(heights) == side
    high = np.flatnonzero(heights > 2.4)
    assert heights.max() == pytest.approx(5.0, abs=0.01 if side < terrain.MAX_GRID else 2.5)
    assert high.mean() / (side - 1) == pytest.approx(301 / (count - 1), abs=1.0 / side)


def test_a_pixel_of_value_1_makes_white_the_full_height(tmp_path):
    """As in Gazebo 11.1: boxes on pixels of 196 of 255 of such an image rest at 3.1 of 4 m."""
    gray = np.array([[0, 1, 196], [0, 51, 199], [0, 0, 0]], np.uint8)
    path = tmp_path / "odd.png"
    Image.fromarray(gray).save(path)
    heights = terrain.heightmap(str(path), (1.0, 1.0, 4.0))[0][:, 2]
    assert heights == pytest.approx(gray.ravel() / 255.0 * 4.0)


def test_of_colors_blue_counts_and_its_value_in_the_brightest_pixel(tmp_path):
    """As in Gazebo 11.1, where spheres rest on such a map."""
    image = np.zeros((3, 3, 4), np.uint8)
    image[..., 2] = (0, 40, 200), (80, 120, 160), (10, 20, 30)
    image[1, 1, :2] = 200, 100  # the brightest one
    path = tmp_path / "colors.png"
    Image.fromarray(image, "RGBA").save(path)
    heights = terrain.grid(str(path), (1.0, 1.0, 4.0), 1)
    assert heights.dtype == np.float32
    assert heights == pytest.approx(image[..., 2] / 120.0 * 4.0)


def test_sampling_interpolates_between_pixels_and_the_brightest_has_the_full_height(tmp_path):
    """As Gazebo 11.1: boxes rest at 2 and 4 m on pixels of 64 and 128, of a map of 4 m."""
    gray = np.full((5, 5), 64, np.uint8)
    gray[:, 3:] = 128
    path = tmp_path / "step.png"
    Image.fromarray(gray).save(path)
    vertices, faces = terrain.heightmap(str(path), (8.0, 8.0, 4.0), 4)
    assert len(vertices) == 17**2 and len(faces) == 2 * 16**2
    row = vertices[:17]
    assert row[:, 0].tolist() == np.linspace(-4.0, 4.0, 17).tolist()
    expected = np.interp(row[:, 0], [-4.0, 0.0, 2.0, 4.0], [2.0, 2.0, 4.0, 4.0])
    assert row[:, 2] == pytest.approx(expected)
    text = SDF.format(f"<heightmap><uri>{path}</uri><size>8 8 4</size></heightmap>")
    world = World()
    world.spawn_sdf("ground", text, Pose(), str)
    assert (_hit(world, -3.0, 0.1), _hit(world, 3.0, 0.1)) == pytest.approx((2.0, 4.0), abs=1e-3)
    world.close()


def test_a_road_has_its_width_at_its_ends_and_at_a_right_angle():
    corners, triangles = terrain.road([(0, 0, 1), (10, 0, 1), (10, 10, 1)], 2.0)
    expected = [(0, 1), (0, -1), (9, 1), (11, -1), (9, 10), (11, 10)]
    assert corners[:, :2] == pytest.approx(np.array(expected))
    assert set(corners[:, 2]) == {1.0} and corners[:, 7].tolist() == [0, 0, -5, -5, -10, -10]
    a, b, c = (corners[triangles[:, k], :3] for k in range(3))
    assert (np.cross(b - a, c - a)[:, 2] > 0).all() and len(triangles) == 4


def _hit(world, x, y):
    """Height at which a ray from above hits."""
    center, down = np.array((x, y, 10.0)), np.array([(0.0, 0.0, -1.0)])
    (distance,) = world.engine.cast_rays(Rays(center, down, 0.0, 20.0))
    return 10.0 - distance if np.isfinite(distance) else None


def test_both_are_hit_by_rays_where_they_should_be(ramp):
    world = World()
    heightmap = f"<heightmap><uri>{ramp}</uri><size>8 4 2</size><pos>10 0 1</pos></heightmap>"
    world.spawn_sdf("ground", SDF.format(heightmap), Pose(), lambda uri: uri)
    block = (
        "<polyline><point>0 0</point><point>3 0</point><point>3 3</point><point>2 3</point>"
        "<point>2 1</point><point>1 1</point><point>1 3</point><point>0 3</point>"
        "<height>0.5</height></polyline>"
    )
    model = world.spawn_sdf("block", SDF.format(block), Pose((20.0, 0.0, 0.0)), str)
    assert model.description.warnings == []
    for x in (-2.0, 0.1, 3.0):  # of the <pos> of a collision Gazebo takes the height alone
        assert _hit(world, x, -1.0) == pytest.approx(1.0 + (x + 4.0) / 4.0, abs=0.02)
    assert _hit(world, 20.5, 2.0) == pytest.approx(0.5, abs=1e-3)
    assert _hit(world, 21.5, 2.0) is None  # between the arms of the U
    world.close()


def test_all_polylines_of_a_shape_make_one_with_the_height_of_the_first():
    """Those within others are holes, as in Gazebo."""
    square = "<polyline><point>{0} {0}</point><point>{1} {0}</point><point>{1} {1}</point>"
    square += "<point>{0} {1}</point><height>{2}</height></polyline>"
    text = SDF.format("".join(square.format(*each) for each in ((0, 4, 0.5), (1, 3, 2), (5, 6, 3))))
    world = World()
    model = world.spawn_sdf("block", text, Pose(), str)
    assert model.description.warnings == []
    assert _hit(world, 0.5, 2.0) == pytest.approx(0.5, abs=1e-3) and _hit(world, 2.0, 2.0) is None
    assert _hit(world, 5.5, 5.5) == pytest.approx(0.5, abs=1e-3)
    world.close()


def test_a_heightmap_that_is_missing_or_no_image_is_a_warning(tmp_path):
    world = World()
    (tmp_path / "text.png").write_text("no image")
    for number, name in enumerate(("none.png", "text.png")):
        text = SDF.format(f"<heightmap><uri>{tmp_path}/{name}</uri></heightmap>")
        model = world.spawn_sdf(f"m{number}", text, Pose(), lambda uri: uri)
        assert name in str(model.description.warnings)
    world.close()
