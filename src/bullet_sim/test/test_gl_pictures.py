"""What the OpenGL renderer draws: colours, shadows, depth, textures, order, places."""

from dataclasses import replace

import cv2
import numpy as np
import pytest
from bullet_sim.description.model import Finish, Geometry, Light, Shape, VisualLink
from bullet_sim.description.world import SUN, Fog, Scene
from bullet_sim.engine.api import Rays
from bullet_sim.engine.bullet.client import Client
from bullet_sim.pose import Pose
from bullet_sim.render.gl.renderer import GlRenderer, projection
from bullet_sim.render.request import CameraRequest, Distortion, Intrinsics, Lens, Quality
from bullet_sim.sensors import camera
from bullet_sim.snapshot import BodySource, BodyState, Snapshot
from bullet_sim.world import World
from mirrored import source_of
from PIL import Image
from pinhole import OPTICAL_FROM_CAMERA

pytestmark = pytest.mark.usefixtures("sketches")

DOWN = ((0.0, 0.0, 5.0), (0.0, np.pi / 2, 0.0))  # 5 m high, looks down, the picture's top is +x
AHEAD = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
ZENITH = Light("sun", direction=(0.0, 0.0, -1.0), diffuse=(0.5, 0.5, 0.5), specular=(0.0,) * 3)
PLAIN = Scene(ambient=(0.2, 0.2, 0.2), background=(0.0, 0.0, 0.0), lights=(ZENITH,))


def view(pose=DOWN, width=200, height=200, **changes):
    values = dict(horizontal_fov=0.8, near=0.1, far=50.0)
    values.update(changes)
    return CameraRequest("eye", None, 0, pose, width=width, height=height, **values)


def box(size, place=(0.0, 0.0, 0.0), color=(1.0, 1.0, 1.0, 1.0), **changes):
    pose = Pose(tuple(map(float, place)))
    return Shape(Geometry("box", tuple(map(float, size))), pose, color, **changes)


def show(gl, scene, *shapes, moving=(), request=None, at=(0.0, 0.0, 0.0)):
    """The picture of shapes that stand still, and of some on a body of its own, which is `at`."""
    bodies = [BodySource(1, True, (VisualLink(shapes=tuple(shapes)),))]
    bodies.append(BodySource(2, False, (VisualLink(shapes=tuple(moving)),)))
    gl.sync_sources(bodies, scene)
    states = (BodyState(1, (0, 0, 0), (0, 0, 0, 1), ()), BodyState(2, at, (0, 0, 0, 1), ()))
    return gl.draw(Snapshot(0.0, 0, states), request or view())


FLOOR = box((20, 20, 0.1), (0, 0, -0.05))


@pytest.mark.parametrize(
    "color, finish, expected",
    [
        ((1.0, 0.5, 0.2, 1.0), Finish(), (0.7, 0.35, 0.14)),
        ((1.0, 0.5, 0.2, 1.0), Finish(ambient=(0.0, 0.0, 1.0)), (0.5, 0.25, 0.3)),
        ((0.2, 0.2, 0.2, 1.0), Finish(emissive=(0.5, 0.0, 0.0)), (0.64, 0.14, 0.14)),
        ((0.3, 0.6, 0.9, 1.0), Finish(lit=False), (0.3, 0.6, 0.9)),
        ((1.0, 1.0, 1.0, 1.0), Finish(opacity=0.25), (0.175, 0.175, 0.175)),
    ],
)
def test_known_colours_under_a_known_light(gl, color, finish, expected):
    picture = show(gl, PLAIN, replace(FLOOR, color=color, finish=finish))
    assert np.abs(picture[20:180, 20:180] - 255.0 * np.array(expected)).max() <= 2.0


@pytest.mark.parametrize(
    "flags, seen", [(0xFFFFFFFF, True), (0x30, True), (0x40, False), (3, False)]
)
def test_a_camera_sees_what_shares_a_bit_with_its_mask(gl, flags, seen):
    shape = replace(FLOOR, color=(0.2, 0.4, 0.6, 1.0), visibility=flags)
    picture = show(gl, PLAIN, shape, request=view(visibility=0x10))
    assert (np.abs(picture[100, 100] - 0.7 * 255 * np.array((0.2, 0.4, 0.6))).max() <= 2.0) == seen


def test_gazebos_sun_on_a_floor_and_on_a_wall(gl):
    """0.4 of ambient light, and 0.8 times the cosine between the sun and the normal."""
    gray = replace(FLOOR, color=(0.5, 0.5, 0.5, 1.0))
    picture = show(gl, Scene(), gray)
    assert abs(picture[100, 100, 0] - 255 * 0.5 * (0.4 + 0.8 * 0.870102)) <= 2.0
    wall = box((0.1, 20, 20), (2.05, 0, 0), (0.5, 0.5, 0.5, 1.0))
    picture = show(gl, Scene(), wall, request=view(AHEAD))  # its side away from the sun
    assert abs(picture[100, 100, 0] - 255 * 0.5 * 0.4) <= 2.0
    picture = show(gl, Scene(), wall, request=view(((9.0, 0, 0), (0, 0, np.pi))))
    assert abs(picture[100, 100, 0] - 255 * 0.5 * (0.4 + 0.8 * 0.48339)) <= 2.0


def test_no_two_faces_of_a_box_alike(gl):
    """Each face has one colour, and that of no other."""
    seen = {}
    for name, pose in {
        "top": ((0, 0, 4), (0, np.pi / 2, 0)),
        "front": ((4, 0, 0), (0, 0, np.pi)),
        "back": ((-4, 0, 0), (0, 0, 0)),
        "left": ((0, 4, 0), (0, 0, -np.pi / 2)),
        "right": ((0, -4, 0), (0, 0, np.pi / 2)),
    }.items():
        scene = Scene(lights=(SUN, Light("l", "directional", direction=(0.6, 0.64, 0.48))))
        face = show(gl, scene, box((1, 1, 1), color=(0.6, 0.6, 0.6, 1)), request=view(pose))
        inner = face[85:115, 85:115].reshape(-1, 3)
        assert (inner == inner[0]).all(), f"{name} is not of one colour"
        seen[name] = int(inner[0, 0])
    assert len(set(seen.values())) == len(seen), seen


def test_a_lamp_falls_off_and_a_spot_ends(gl):
    lamp = Light("lamp", "point", (0.0, 0.0, 2.0), specular=(0.0,) * 3, linear=0.5, quadratic=0.25)
    dark = Scene(ambient=(0.0,) * 3, background=(0.0,) * 3, lights=(lamp,))
    picture = show(gl, dark, FLOOR)
    assert abs(picture[100, 100, 0] - 255 / (1 + 0.5 * 2 + 0.25 * 4)) <= 2.0
    beyond = replace(dark, lights=(replace(lamp, reach=1.9),))
    assert show(gl, beyond, FLOOR).max() == 0
    spot = replace(lamp, kind="spot", inner=0.2, outer=0.4, falloff=1.0, linear=0.0, quadratic=0.0)
    picture = show(gl, replace(dark, lights=(spot,)), FLOOR)
    focal = 100 / np.tan(0.4)
    edge = 2.0 * np.tan(0.2) / 5.0 * focal  # [px] where the outer cone meets the floor
    lit = np.flatnonzero(picture[100, :, 0] > 3)
    assert abs(picture[100, 100, 0] - 255) <= 2.0
    assert (lit.max() - lit.min()) / 2.0 == pytest.approx(edge, abs=2.0)


def test_a_light_goes_with_its_link(gl):
    """A spot on a slide that a body carries: its disk is below it, wherever that is."""
    spot = Light(
        "torch", "spot", (0.0, 0.2, 0.0), specular=(0.0,) * 3, linear=0.0, inner=0.3, outer=0.3
    )
    chain = (VisualLink(), VisualLink(0, Pose(), "prismatic", (1.0, 0.0, 0.0), lights=(spot,)))
    floor = BodySource(1, True, (VisualLink(shapes=(FLOOR,)),))
    dark = Scene(ambient=(0.0,) * 3, background=(0.0,) * 3, lights=())
    gl.sync_sources([floor, BodySource(2, False, chain)], dark)
    focal = 100 / np.tan(0.4)
    for along in (0.0, 0.5):
        state = BodyState(2, (-0.3, 0.0, 2.0), (0.0, 0.0, 0.0, 1.0), (along,))
        rows, columns = np.nonzero(gl.draw(Snapshot(0.0, 0, (state,)), view())[:, :, 0] > 100)
        assert rows.mean() == pytest.approx(99.5 - (along - 0.3) / 5.0 * focal, abs=1.0)
        assert columns.mean() == pytest.approx(99.5 - 0.2 / 5.0 * focal, abs=1.0)


@pytest.mark.parametrize("given", [Intrinsics(300, 200, 90, 120), Intrinsics(200, 200, 80, 70, 40)])
def test_intrinsics_put_points_where_they_say(gl, given):
    """Each mark at its pixel, of the colors, the depths and the sky alike."""
    marks = [(2.0, y, z) for y in (-0.3, 0.1, 0.4) for z in (-0.35, 0.0, 0.3)]
    parts = [box((0.02,) * 3, place) for place in marks]
    dark = Scene(ambient=(1.0,) * 3, background=(0.0,) * 3, lights=())
    picture = show(gl, dark, *parts, request=view(AHEAD, intrinsics=given))[:, :, 0] > 128
    count, _, _, centers = cv2.connectedComponentsWithStats(picture.astype(np.uint8))
    for x, y, z in marks:
        right, down = -y / x, -z / x
        at = (
            given.fx * right - given.s * down + given.cx - 0.5,
            given.fy * down + given.cy - 0.5,
        )
        if all(3.0 < value < 196.0 for value in at):
            assert np.linalg.norm(centers[1:] - at, axis=1).min() < 0.7, (at, centers)
    assert count > 6
    same = Intrinsics(100 / np.tan(0.4), 100 / np.tan(0.4), 100.0, 100.0)
    sky = Scene(background=None)
    plain = show(gl, sky, FLOOR, request=view(AHEAD))
    assert np.abs(show(gl, sky, FLOOR, request=view(AHEAD, intrinsics=same)) - plain).max() == 0
    wide = show(gl, sky, request=view(AHEAD, intrinsics=given))
    moved = show(gl, sky, request=view(AHEAD, 400, 400, horizontal_fov=1.2)).astype(int)
    focal = 200 / np.tan(0.6)
    down, right = (150 - given.cy + 0.5) / given.fy, (20 - given.cx + 0.5) / given.fx
    right += given.s * down / given.fx
    other = moved[round(199.5 + focal * down), round(199.5 + focal * right)]
    assert np.abs(wide[150, 20] - other).max() <= 3


def test_both_renderers_agree_about_intrinsics():
    given = Intrinsics(300, 200, 90, 120, 40)
    shown = camera.shown_intrinsics(200, 150, 1.0, given)
    clip = projection(shown, 200, 150, 0.1, 10.0)
    other = camera.projection_matrix(
        1.0, 200 / 150, 0.1, 10.0, shown=shown / np.array([[200], [150]])
    )
    flipped = np.reshape(other, (4, 4)).T * np.array([[1.0], [-1.0], [1.0], [1.0]])
    np.testing.assert_allclose(clip[[0, 1, 3]], flipped[[0, 1, 3]], atol=1e-12)


@pytest.mark.parametrize("moves", [False, True])
def test_a_shadows_edge_is_where_geometry_says(gl, moves):
    """A slab 1 m above the floor; the sun shines at an angle of known slope."""
    slope = np.array((0.6, 0.3))
    direction = np.array((*slope, -1.0)) / np.linalg.norm((*slope, 1.0))
    sun = replace(ZENITH, direction=tuple(direction), cast_shadows=True)
    slab = box((0.6, 0.6, 0.02), (-1.0, -1.0, 1.0))
    parts = dict(moving=[slab]) if moves else {}
    still = (FLOOR,) if moves else (FLOOR, slab)
    asked = view(width=400, height=400)
    picture = show(gl, replace(PLAIN, lights=(sun,)), *still, request=asked, **parts).astype(int)
    focal = 200 / np.tan(0.4)
    level = 255 * 0.2
    dark = np.abs(picture[:, :, 0] - level) < 12
    rows, columns = np.nonzero(dark)
    # Where the slab's lower edge at z = 0.99 and its upper one at 1.01 throw their shadows.
    low, high = -1.3 + 0.99 * slope, -0.7 + 1.01 * slope
    first, last = 199.5 - focal * high / 5.0, 199.5 - focal * low / 5.0  # row: x, column: y
    assert rows.min() == pytest.approx(first[0], abs=1.5)
    assert rows.max() == pytest.approx(last[0], abs=1.5)
    assert columns.min() == pytest.approx(first[1], abs=1.5)
    assert columns.max() == pytest.approx(last[1], abs=1.5)
    lit = show(gl, replace(PLAIN, shadows=False, lights=(sun,)), *still, request=asked, **parts)
    assert np.abs(lit[rows, columns, 0] - level).min() > 50


@pytest.mark.parametrize("pitch", [0.2, 0.8, 1.5])
def test_what_the_sun_sees_is_not_in_the_shadow(gl, pitch):
    """From the sun no shadow is seen: neither spots of the surfaces on themselves nor stripes."""
    away = (np.cos(pitch), 0.0, -np.sin(pitch))
    sun = replace(SUN, direction=tuple(away), specular=(0.0,) * 3)
    ball = Shape(Geometry("sphere", (0.5,)), Pose((0.0, 0.0, 0.5)), (0.5, 0.5, 0.5, 1.0))
    tower = box((0.4, 0.4, 2.0), (0.3, 1.0, 1.0))
    wide = box((100, 100, 0.002), (0, 0, -0.001))
    scene = Scene(lights=(sun,), background=(0.0,) * 3)
    asked = view((tuple(-40.0 * np.array(away)), (0.0, pitch, 0.0)), horizontal_fov=0.12)
    with_shadows = show(gl, scene, wide, ball, moving=[tower], request=asked).astype(int)
    plain = show(gl, replace(scene, shadows=False), wide, ball, moving=[tower], request=asked)
    differs = np.abs(with_shadows - plain).max(axis=2) > 2
    assert differs.mean() < 0.01, "beside the outlines"


def test_depth_is_that_of_rays(gl, tmp_path):
    text = "<link name='l'>" + "".join(
        f'<{kind}><origin xyz="{x} {y} {z}" rpy="0.3 0.2 {yaw}"/>'
        f"<geometry>{shape}</geometry></{kind}>"
        for x, y, z, yaw, shape in (
            (3, 0.5, 0, 0.4, '<box size="1 0.7 0.5"/>'),
            (5, -1, 0.5, 1.0, '<box size="0.5 2 1"/>'),
            (8, 1, -0.5, 0.0, '<box size="2 3 0.6"/>'),
        )
        for kind in ("visual", "collision")
    )
    text = f'<robot name="r">{text}</link></robot>'
    gl.sync_sources([source_of(text, 1)], Scene())
    asked = view(AHEAD, 64, 48, depth=True, near=0.02, far=30.0)
    gl.apply(Snapshot(0.0, 0, (BodyState(1, (0, 0, 0), (0, 0, 0, 1), ()),)))
    _, depth = gl.render_with_depth(asked)
    client = Client()
    try:
        client.load_text(1, text, "l", fixed_base=True)
        k = camera.intrinsics(64, 48, asked.horizontal_fov)
        rays = camera.points(np.ones((48, 64), np.float32), k).reshape(-1, 3)
        ends = 30.0 * rays @ OPTICAL_FROM_CAMERA
        lengths = np.linalg.norm(ends, axis=1)
        rays = ends / lengths[:, None]
        fractions = client.cast_rays(Rays(np.zeros(3), rays, 0.0, lengths.max())) / lengths
    finally:
        client.close()
    expected = np.where(np.asarray(fractions) < 1.0, 30.0 * np.asarray(fractions), 30.0)
    expected = expected.reshape(48, 64)
    inner = np.abs(np.gradient(expected)[0]) + np.abs(np.gradient(expected)[1]) < 0.1
    assert inner.mean() > 0.7 and (expected[inner] < 29.0).mean() > 0.05
    assert np.abs(depth - expected)[inner].max() < 1e-3  # [m]


def test_depth_is_true_far_away(gl):
    wall = box((0.1, 300, 300))
    for distance, near in ((200.0, 0.02), (9.0, 0.01)):
        shifted = replace(wall, pose=Pose((distance + 0.05, 0.0, 0.0)))
        asked = view(AHEAD, 16, 16, near=near, far=500.0, depth=True)
        show(gl, PLAIN, shifted, request=asked)
        _, depth = gl.render_with_depth(asked)
        assert np.abs(depth - distance).max() < max(1e-4, 1e-4 * distance)


@pytest.mark.parametrize("order", [(0, 1), (1, 0)])
def test_transparent_in_front_of_opaque(gl, order):
    """Half of a red pane's colour and half of what is behind it, in whatever order they come."""
    pane = box((1, 1, 0.01), (0, 0, 1.0), (1.0, 0.0, 0.0, 0.5))
    green = replace(FLOOR, color=(0.0, 1.0, 0.0, 1.0))
    shapes = [(pane, green)[i] for i in order]
    picture = show(gl, replace(PLAIN, shadows=False), *shapes)
    assert np.abs(picture[100, 100] - 255 * np.array((0.35, 0.35, 0.0))).max() <= 2.0
    behind = replace(pane, pose=Pose((0.0, 0.0, -1.0)))
    assert show(gl, PLAIN, green, behind)[100, 100, 0] <= 1


def test_a_textured_quad_is_upright_and_not_mirrored(gl, tmp_path):
    """Four quarters of four colours, on a box's side and on a mesh of two triangles."""
    quarters = np.zeros((64, 64, 3), np.uint8)
    colors = {(0, 0): (255, 0, 0), (0, 1): (0, 255, 0), (1, 0): (0, 0, 255), (1, 1): (255, 255, 0)}
    for (row, column), color in colors.items():
        quarters[32 * row : 32 * row + 32, 32 * column : 32 * column + 32] = color
    Image.fromarray(quarters).save(tmp_path / "q.png")
    (tmp_path / "quad.mtl").write_text("newmtl q\nKa 1 1 1\nKd 1 1 1\nmap_Kd q.png\n")
    (tmp_path / "quad.obj").write_text(
        "mtllib quad.mtl\nusemtl q\nv 2 1 -1\nv 2 -1 -1\nv 2 -1 1\nv 2 1 1\n"
        "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3\nf 1/1 3/3 4/4\n"
    )
    bright = Scene(ambient=(1.0,) * 3, background=(0.0,) * 3, lights=())
    mesh = Shape(Geometry("mesh", path=str(tmp_path / "quad.obj")))
    side = box((0.1, 2, 2), (2.05, 0, 0), texture=str(tmp_path / "q.png"))
    for shape in (mesh, side):
        picture = show(gl, bright, shape, request=view(AHEAD))
        for (row, column), color in colors.items():
            pixel = picture[60 + 80 * row, 60 + 80 * column].astype(int)
            assert np.abs(pixel - color).max() <= 2, (shape.geometry.kind, row, column)


def test_materials_of_one_file_have_their_colours(gl, tmp_path):
    (tmp_path / "two.mtl").write_text(
        "newmtl a\nKa 1 0 0\nKd 1 0 0\nnewmtl b\nKa 0 0 1\nKd 0 0 1\n"
    )
    (tmp_path / "two.obj").write_text(
        "mtllib two.mtl\nv 2 1 -1\nv 2 0 -1\nv 2 0 1\nv 2 1 1\nv 2 -1 -1\nv 2 -1 1\n"
        "usemtl a\nf 1 2 3 4\nusemtl b\nf 2 5 6 3\n"
    )
    bright = Scene(ambient=(1.0,) * 3, background=(0.0,) * 3, lights=())
    mesh = Shape(Geometry("mesh", path=str(tmp_path / "two.obj")))
    picture = show(gl, bright, mesh, request=view(AHEAD))
    assert picture[100, 60].tolist() == [255, 0, 0]
    assert picture[100, 140].tolist() == [0, 0, 255]
    mirrored = replace(mesh, geometry=replace(mesh.geometry, scale=(1.0, -1.0, 1.0)))
    picture = show(gl, bright, mirrored, request=view(AHEAD))
    assert picture[100, 60].tolist() == [0, 0, 255], "mirrored, and not inside out"


def test_background_sky_and_fog(gl):
    high = view(((0, 0, 1), (0, -0.3, 0)))
    assert show(gl, replace(PLAIN, background=(0.2, 0.4, 0.6)), request=high)[0, 0].tolist() == [
        51,
        102,
        153,
    ]
    gray = show(gl, Scene(), request=high)
    assert (gray == 178).all() or (gray == 179).all(), "a world without sky"
    sky = show(gl, Scene(background=None), request=high).astype(int)
    red = sky[:, 100, 0]
    assert (np.diff(red) >= -1).all() and red[0] + 50 < red[-1]
    fog = Fog("linear", (1.0, 0.0, 0.0), 0.0, 10.0)
    picture = show(gl, replace(PLAIN, fog=fog), FLOOR)  # 5 m away
    assert np.abs(picture[100, 100] - 255 * np.array((0.85, 0.35, 0.35))).max() <= 2.0


def test_far_from_the_worlds_origin_it_is_as_near(gl):
    shift = np.array((123456.0, -98765.0, 0.0))
    marks = [box((0.01, 0.01, 0.01), (x, x / 2, 0.2)) for x in np.linspace(-1, 1, 9)]
    near = show(gl, PLAIN, moving=[FLOOR, *marks])
    moved = view(((*(shift[:2]), 5.0), DOWN[1]))
    far = show(gl, PLAIN, moving=[FLOOR, *marks], request=moved, at=tuple(shift))
    assert (near != far).any(axis=2).mean() < 0.002


def test_the_same_bytes_twice(gl):
    shapes = [FLOOR, box((0.5, 0.5, 0.5), (0.3, 0, 0.25))]
    scene = Scene()
    first = show(gl, scene, *shapes, moving=[box((0.2, 0.2, 0.2), (0, 0.5, 0.5))])
    show(gl, scene, *shapes, moving=[FLOOR], request=view(((30, 3, 5), DOWN[1]), 64, 64))
    again = show(gl, scene, *shapes, moving=[box((0.2, 0.2, 0.2), (0, 0.5, 0.5))])
    np.testing.assert_array_equal(first, again)


def test_joints_carry_their_links(gl):
    """A slide on a hinge, against the poses that PyBullet computes (test_camera covers a hinge)."""
    chain = (
        VisualLink(),
        VisualLink(0, Pose((0.0, 0.0, 1.0)), "revolute", (0.0, 0.0, 1.0)),
        VisualLink(1, Pose((1.0, 0.0, 0.0)), "prismatic", (0.0, 1.0, 0.0)),
        VisualLink(2, Pose((0.0, 0.0, 0.5)), "fixed"),
    )
    gl.sync_sources([BodySource(7, False, chain)], Scene())
    state = BodyState(7, (5.0, 0.0, 0.0), (0.0, 0.0, 0.0, 2.0), (np.pi / 2, 0.25))
    gl.apply(Snapshot(0.0, 0, (state,)))
    position, rotation = gl.camera_pose(replace(view(((0, 0, 0), (0, 0, 0))), key=7, link_index=3))
    np.testing.assert_allclose(position, (4.75, 1.0, 1.5), atol=1e-12)
    np.testing.assert_allclose(rotation[:, 0], (0.0, 1.0, 0.0), atol=1e-12)


def test_antialiasing_smooths_edges(gl):
    edge = box((3, 3, 0.1), (1.5, 0, 0))
    asked = view(((0, 0.3, 5.0), (0.0, np.pi / 2, 0.35)))
    hard = show(gl, PLAIN, edge, request=asked)
    smooth = GlRenderer(Quality("false", "true"))
    try:
        soft = show(smooth, PLAIN, edge, request=asked)
    finally:
        smooth.close()
    assert len(np.unique(hard[:, :, 0])) == 2 and len(np.unique(soft[:, :, 0])) > 3


@pytest.mark.parametrize("samples", [0, 1, 3])
def test_cameras_without_antialiasing_have_hard_edges(samples):
    """As in Gazebo also with a number of samples that the driver does not have."""
    smooth = GlRenderer(Quality("false", "true"))
    asked = view(((0, 0.3, 5.0), (0.0, np.pi / 2, 0.35)), samples=samples)
    try:
        picture = show(smooth, PLAIN, box((3, 3, 0.1), (1.5, 0, 0)), request=asked)
    finally:
        smooth.close()
    assert len(np.unique(picture[:, :, 0])) == 2


def test_labels_tell_which_body_each_pixel_shows(gl):
    """Also of two bodies alike, behind glass, in the dark and through a lens; never a mixture."""
    cube = VisualLink(shapes=(box((1, 1, 1)),))
    glass = VisualLink(shapes=(box((0.5, 0.5, 0.1), color=(1, 1, 1, 0.2)),))
    bodies = {70000: (cube, (0, 0.8, 0)), 2: (cube, (0, -0.8, 0)), 3: (glass, (0, -0.8, 1))}
    sources = [BodySource(key, False, (link,)) for key, (link, _) in bodies.items()]
    gl.sync_sources(sources, replace(PLAIN, ambient=(0.0,) * 3, lights=()))
    states = tuple(BodyState(key, at, (0, 0, 0, 1), ()) for key, (_, at) in bodies.items())
    gl.apply(Snapshot(0.0, 0, states))
    straight = gl.labels(view())
    assert straight.dtype == np.int32 and straight.shape == (200, 200)
    focal = 100 / np.tan(0.4)
    left, right = 99.5 - 0.8 / 4.5 * focal, 99.5 + 0.8 / 4.5 * focal  # +y is to the left
    assert straight[100, round(left)] == 70000 and straight[100, round(right)] == 3
    assert straight[100, round(right - 0.4 / 4.5 * focal)] == 2
    assert straight[10, 10] == 0 and straight[100, 100] == 0
    area = (straight == 70000).sum() / (focal / 4.5) ** 2  # the cube's top, and a strip of a side
    assert 1.0 <= area <= 1.15
    for lens in (
        {"distortion": Distortion(-0.3, 0.1, crop=True)},
        {"lens": Lens(fov=2.0, function="tan"), "horizontal_fov": 0.8},
    ):
        bent = gl.labels(view(**lens))
        assert set(np.unique(bent)) == {0, 2, 3, 70000}, lens


def test_labels_do_not_change_the_picture(gl):
    before = show(gl, PLAIN, FLOOR, box((1, 1, 1)))
    gl.labels(view())
    assert np.array_equal(gl.render(view()), before)


@pytest.mark.parametrize(
    "geometry",
    [
        "<heightmap><uri>{image}</uri><size>4 4 0.5</size></heightmap>",
        "<polyline><point>-2 -2</point><point>2 -2</point><point>2 2</point><point>-2 2</point>"
        "<height>0.5</height></polyline>",
    ],
    ids=["heightmap", "polyline"],
)
def test_generated_meshes_are_rendered(gl, tmp_path, geometry):
    image = tmp_path / "white.png"
    Image.fromarray(np.full((9, 9), 255, np.uint8)).save(image)
    visual = f"<visual name='v'><geometry>{geometry.format(image=image)}</geometry></visual>"
    text = f"<sdf version='1.6'><model name='m'><static>1</static><link name='l'>{visual}</link>"
    world = World()
    model = world.spawn_sdf("m", f"{text}</model></sdf>", Pose(), str)
    gl.sync_sources(world.sources(), PLAIN)
    gl.apply(world.snapshot())
    asked = view(width=32, height=32, depth=True)
    rgb, depth = gl.render_with_depth(asked)
    world.close()
    assert model.description.warnings == [] and rgb.min() > 0
    assert depth == pytest.approx(np.full((32, 32), asked.pose[0][2] - 0.5), abs=1e-3)


def test_textures_of_a_heightmap_cover_each_other_by_height(gl, tmp_path):
    """Red, above 1 m within 2 m green: in images of Gazebo 11.1 hills of this kind are alike."""
    gray = np.tile(np.linspace(0, 255, 65).astype(np.uint8), (65, 1))  # rises towards +x to 4 m
    Image.fromarray(gray).save(tmp_path / "ramp.png")
    textures = ""
    for name, color in (("red", (255, 0, 0, 0)), ("green", (0, 255, 0, 0))):
        Image.fromarray(np.full((8, 8, 4), color, np.uint8)).save(tmp_path / f"{name}.png")
        textures += f"<texture><diffuse>{tmp_path}/{name}.png</diffuse><size>1</size></texture>"
    text = (
        "<sdf version='1.6'><model name='m'><static>1</static><link name='l'><visual name='v'>"
        f"<geometry><heightmap><uri>{tmp_path}/ramp.png</uri><size>16 16 4</size>{textures}<blend>"
        "<min_height>1</min_height><fade_dist>2</fade_dist></blend></heightmap></geometry>"
        "</visual></link></model></sdf>"
    )
    world = World()
    model = world.spawn_sdf("m", text, Pose(), str)
    gl.sync_sources(world.sources(), PLAIN)
    gl.apply(world.snapshot())
    world.close()
    assert model.description.warnings == []
    light = 0.2 + 0.5 * np.cos(np.arctan(0.25))
    for x in (-7.0, -3.0, 0.0, 2.0, 6.0):
        picture = gl.render(
            view(((x, 0.3, 9.0), (0.0, np.pi / 2, 0.0)), 32, 32, horizontal_fov=0.1)
        )
        share = np.clip(((x + 8.0) / 4.0 - 1.0) / 2.0, 0.0, 1.0)
        expected = 255.0 * light * np.array((1.0 - share, share, 0.0))
        assert picture[16, 16] == pytest.approx(expected, abs=4.0), x


def test_a_heightmap_whose_texture_is_missing_has_one_color(tmp_path):
    Image.fromarray(np.full((9, 9), 255, np.uint8)).save(tmp_path / "white.png")
    text = (
        "<sdf version='1.6'><model name='m'><static>1</static><link name='l'><visual name='v'>"
        f"<geometry><heightmap><uri>{tmp_path}/white.png</uri><texture><diffuse>{tmp_path}/no.png"
        "</diffuse></texture></heightmap></geometry></visual></link></model></sdf>"
    )
    world = World()
    model = world.spawn_sdf("m", text, Pose(), str)
    world.close()
    assert "no.png' is not found; it has one color" in model.description.warnings[0]
