"""Rays of a lidar against PyBullet's own and closed forms, among all kinds of shapes."""

import json
import math
import subprocess
import sys

import numpy as np
import pytest
from bullet_sim.engine.api import Rays
from bullet_sim.engine.bullet.mirror import Mirror
from bullet_sim.formats.sdf import world as sdf
from bullet_sim.plugins.lidars import RaySpec
from bullet_sim.pose import Pose, rotation_matrix
from bullet_sim.sensors.lidar import Lidar
from bullet_sim.world import World
from urdf_texts import joint, link, robot

NEAR, FAR = 0.2, 12.0
CENTER = np.array((0.3, -0.2, 0.4))
MASS = (
    "<inertial><mass>1</mass><inertia><ixx>1</ixx><iyy>1</iyy><izz>1</izz>"
    "<ixy>0</ixy><ixz>0</ixz><iyz>0</iyz></inertia></inertial>"
)
SHAPES = {
    "box": "<box><size>0.5 1.5 2</size></box>",
    "cylinder": "<cylinder><radius>0.4</radius><length>1.5</length></cylinder>",
    "sphere": "<sphere><radius>0.7</radius></sphere>",
    "slope": "<plane><normal>0 0 1</normal></plane>",
}


def model(shapes, static=True, bits=None):
    """SDF text of a model with one link of some collision shapes, each 0.6 m beside the last."""
    surface = (
        ""
        if bits is None
        else (f"<surface><contact><collide_bitmask>{bits}</collide_bitmask></contact></surface>")
    )
    collisions = "".join(
        f'<collision name="c{number}"><pose>0 {0.6 * number} 0 0 0 0.3</pose>'
        f"<geometry>{shape}</geometry>{surface}</collision>"
        for number, shape in enumerate(shapes)
    )
    return (
        f'<sdf version="1.6"><model name="m"><static>{str(static).lower()}</static>'
        f'<link name="l">{MASS}{collisions}</link></model></sdf>'
    )


@pytest.fixture(name="world")
def _world(request):
    """A world with a ground, of the solver 'ode' or of a parameter's."""
    made = World(solver=getattr(request, "param", "ode"))
    made.spawn(sdf.ground_plane())
    yield made
    made.close()


with_both = pytest.mark.parametrize("world", ["ode", "bullet"], indirect=True)


def directions(count=400, seed=0, flat=False):
    """Unit vectors (n, 3) to all sides."""
    vectors = np.random.default_rng(seed).normal(size=(count, 3))
    if flat:
        vectors[:, 2] = 0.0
    return vectors / np.linalg.norm(vectors, axis=1)[:, None]


def cast(world, rays):
    """Distances from NEAR to FAR by the world's engine."""
    return world.engine.cast_rays(Rays(CENTER, rays, NEAR, FAR))


def in_bullet(world, rays, start=NEAR, end=FAR, center=CENTER):
    """Distances by PyBullet alone."""
    client = getattr(world.engine, "mirror", world.engine).client
    return client.cast_rays(Rays(center, rays, start, end))


def assert_same(world, rays=None):
    """A scan is PyBullet's, but for a ray in 100 that may graze an edge.

    PyBullet's cylinders have 32 sides, of 2 mm at these radii.
    """
    rays = directions() if rays is None else rays
    ours, expected = cast(world, rays), in_bullet(world, rays)
    with np.errstate(invalid="ignore"):
        differ = ~((ours == expected) | (np.abs(ours - expected) < 5e-3))
    assert differ.mean() <= 0.01, list(zip(ours[differ], expected[differ]))
    return ours


def spread(world, seed=3, static=True, count=12):
    """Spawns models of all shapes around the lidar."""
    rng = np.random.default_rng(seed)
    kinds = [kind for kind in SHAPES if kind != "slope"]
    for number in range(count):
        shapes = [SHAPES[kind] for kind in rng.choice(kinds, 1 + number % 3)]
        angle, distance = rng.uniform(0, 2 * math.pi), rng.uniform(2.5, 9.0)
        at = (distance * math.cos(angle), distance * math.sin(angle), rng.uniform(0.5, 2.0))
        pose = Pose.from_xyz_rpy(at, tuple(rng.uniform(-0.5, 0.5, 3)))
        world.spawn_sdf(f"m{static}{number}", model(shapes, static), pose, str)


@pytest.mark.parametrize("seed", range(4))
def test_scenes_of_everything(world, seed):
    spread(world, seed)
    spread(world, seed + 10, static=False)
    world.step(3)
    ours = assert_same(world)
    assert 0.3 < np.isfinite(ours).mean() < 1.0
    assert_same(world, directions(flat=True))
    world.step(50)  # what moves has fallen a bit
    assert_same(world)


@pytest.mark.parametrize("tilt", [0.0, 0.1, 0.6, math.pi])
def test_tilted_planes(world, tilt):
    world.spawn_sdf(
        "slope", model([SHAPES["slope"]]), Pose.from_xyz_rpy((2, 0, -0.5), (tilt, tilt / 3, 0)), str
    )
    assert np.isfinite(assert_same(world)).any()


def test_a_mesh_is_hit_as_it_is_from_both_sides(world, tmp_path):
    """A roof of two triangles, its corners far apart; a hull would fill what is below it."""
    path = tmp_path / "roof.obj"
    path.write_text("v -4 -4 0\nv 4 -4 0\nv 4 4 3\nv -4 4 0\nf 1 2 3\nf 1 3 4\n")
    mesh = f"<mesh><uri>{path}</uri><scale>1 1 0.5</scale></mesh>"
    world.spawn_sdf("roof", model([mesh]), Pose((0.0, 0.0, 1.0)), str)
    below = assert_same(world)
    assert np.isfinite(below).mean() > 0.7
    world.model("roof").set_state(Pose((0.0, 0.0, -2.0)))
    world.step()
    assert_same(world)


def test_what_is_moved_deleted_reset_and_restored(world):
    spread(world, 5)
    box = model([SHAPES["box"]])
    world.spawn_sdf("box", box, Pose((1.5, 0.0, 0.5)), str)
    world.step()
    first = assert_same(world)
    state = world.save_state()
    for x in (2.0, 2.5, 3.0, 3.5, 4.0, 4.5):
        world.model("box").set_state(Pose((x, 0.0, 0.5)))
        world.step()
        assert (assert_same(world) != first).any()
    world.restore_state(state)
    world.step()
    np.testing.assert_allclose(assert_same(world), first, atol=5e-6)
    world.delete("box")
    world.step()
    assert (assert_same(world) != first).any()
    world.reset()
    world.step()
    assert_same(world)


def test_a_model_in_the_place_of_a_deleted_one_is_another(world):
    """PyBullet gives it the same number; tracks stand at the origin all of them."""
    rays, place = directions(flat=True), Pose((2.0, 0.0, 0.5))
    world.spawn_sdf("first", model([SHAPES["box"]]), place, str)
    world.step()
    first = assert_same(world, rays)
    world.delete("first")
    world.spawn_sdf("second", model(["<box><size>0.1 4 2</size></box>"]), place, str)
    world.step()
    assert (assert_same(world, rays) != first).any()


def seen(world, bits, static):
    """Ranges of a box with a collide_bitmask, or None, which is removed again."""
    world.spawn_sdf("box", model([SHAPES["box"]], static, bits), Pose((1.5, 0.0, 0.4)), str)
    world.step()
    ranges = cast(world, directions(flat=True))
    world.delete("box")
    return ranges


@pytest.mark.parametrize("bits", [0, 1, 4])
@pytest.mark.parametrize("static", [True, False])
@with_both
def test_a_link_is_seen_whatever_its_bits(world, monkeypatch, bits, static):
    """As by Gazebo's lidar: worlds that Gazebo has saved have bits everywhere.

    PyBullet's rays do not meet what has none.
    """
    expected = seen(world, None, static)
    assert np.isfinite(expected).any()
    if world.engine.settings is not None:
        monkeypatch.setattr(Mirror, "client", None)  # PyBullet is not asked
    elif not bits:
        expected = np.full(len(expected), np.inf)
    np.testing.assert_allclose(seen(world, bits, static), expected, atol=5e-3)


@with_both
def test_what_is_nearer_than_the_least_range_is_not_seen_as_in_gazebo(world):
    rays = directions(200, flat=True)
    box = ["<box><size>0.05 0.4 0.4</size></box>"]
    world.spawn_sdf("box", model(box), Pose(tuple(CENTER + (0.15, 0.0, 0.0))), str)
    world.step()
    assert np.isposinf(world.engine.cast_rays(Rays(CENTER, rays, 0.9, FAR))).all()
    assert np.isfinite(world.engine.cast_rays(Rays(CENTER, rays, 0.05, FAR))).any()


@pytest.mark.parametrize(
    "shape, up, level",
    [("<box><size>1 1 1</size></box>", 0.638303, (0.5, 0.541196, 0.707107)),
     ("<sphere><radius>0.5</radius></sphere>", 0.5, (0.5, 0.5, 0.5)),
     ("<cylinder><radius>0.5</radius><length>1</length></cylinder>", 0.638303, (0.5, 0.5, 0.5))],
)  # fmt: skip
def test_rays_that_begin_inside_a_solid_meet_it_from_inside(world, shape, up, level):
    """As a lidar in its own housing does; the ranges are those of Gazebo 11.1."""
    world.spawn_sdf("around", model([shape]), Pose(tuple(CENTER)), str)
    world.step()
    angles = np.array([0.3, 0.3 + math.pi / 8.0, 0.3 + math.pi / 4.0])
    flat = np.column_stack([np.cos(angles), np.sin(angles), np.zeros(3)])
    rays = np.vstack([flat, (math.cos(0.9), 0.0, math.sin(0.9))])
    np.testing.assert_allclose(cast(world, rays)[:3], level, atol=1e-6)
    assert cast(world, rays)[3] == pytest.approx(up, abs=1e-6)


@pytest.mark.parametrize("static", [True, False])
@with_both
def test_round_shapes_are_round(world, static):
    """The distances are those of closed forms, along and beside the middle."""
    sphere, cylinder = model([SHAPES["sphere"]], static), model([SHAPES["cylinder"]], static)
    world.spawn_sdf("sphere", sphere, Pose((3.3, -0.2, 0.7)), str)
    world.spawn_sdf("cylinder", cylinder, Pose((0.3, 2.8, 0.75)), str)
    offset = np.array((0.0, 0.2))
    rays = np.array([(3.0, 0.0, 0.0), (3.0, 0.2, 0.0), (0.0, 3.0, 0.0), (0.2, 3.0, 0.0)])
    rays /= np.linalg.norm(rays, axis=1)[:, None]
    found = cast(world, rays)
    height = 0.7 - CENTER[2]
    sine = offset / np.hypot(3.0, offset)
    cosine = 3.0 / np.hypot(3.0, offset)
    ball = 3.0 * cosine - np.sqrt(0.7**2 - height**2 - (3.0 * sine) ** 2)
    tube = 3.0 * cosine - np.sqrt(0.4**2 - (3.0 * sine) ** 2)
    np.testing.assert_allclose(
        found, [*ball, *tube], atol=5e-3 if world.engine.settings is None else 1e-9
    )


WITHOUT_NUMBA = """
import json, sys
sys.modules["numba"] = None
import numpy as np
from bullet_sim.engine.api import Rays
from bullet_sim.pose import Pose
from bullet_sim.world import World
world = World(solver="bullet")
world.spawn_sdf("box", sys.argv[1], Pose((2.0, 0.0, 0.5)), str)
rays = np.array([(np.cos(a), np.sin(a), 0.0) for a in (-1.0, 0.0, 0.1)])
print(json.dumps(world.engine.cast_rays(Rays(np.array((0.0, 0.0, 0.4)), rays, 0.1, 9.0)).tolist()))
"""


def test_the_solver_bullet_casts_without_numba():
    text = model(["<box><size>1 4 2</size></box>"]).replace("0 0.0 0 0 0 0.3", "0 0 0 0 0 0")
    printed = subprocess.check_output([sys.executable, "-c", WITHOUT_NUMBA, text], text=True)
    expected = [math.inf, 1.5, 1.5 / math.cos(0.1)]
    assert json.loads(printed) == pytest.approx(expected, abs=1e-3)


def closed_mesh(path, rings=12, sides=16):
    """Writes an OBJ of a ball of radius 1 without gaps."""
    points = [(0.0, 0.0, 1.0)]
    for ring in range(1, rings):
        for side in range(sides):
            a, b = math.pi * ring / rings, 2.0 * math.pi * side / sides
            points.append((math.sin(a) * math.cos(b), math.sin(a) * math.sin(b), math.cos(a)))
    points.append((0.0, 0.0, -1.0))
    faces, last = [], len(points)
    for side in range(sides):
        other = (side + 1) % sides
        faces.append((1, 2 + side, 2 + other))
        for ring in range(rings - 2):
            one, two = 2 + ring * sides, 2 + (ring + 1) * sides
            faces += [(one + side, two + side, two + other), (one + side, two + other, one + other)]
        faces.append((last, 2 + (rings - 2) * sides + other, 2 + (rings - 2) * sides + side))
    lines = ["v {:.17g} {:.17g} {:.17g}".format(*point) for point in points]
    path.write_text("\n".join([*lines, *("f {} {} {}".format(*face) for face in faces)]) + "\n")
    return points, faces


@pytest.mark.parametrize("static", [True, False])
def test_no_ray_slips_between_the_triangles_of_a_mesh(world, tmp_path, static):
    """Not even through its corners and the middles of its edges; and distances are of planes."""
    points, faces = closed_mesh(tmp_path / "ball.obj")
    text = model([f"<mesh><uri>{tmp_path / 'ball.obj'}</uri><scale>2 2 2</scale></mesh>"], static)
    text = text.replace("0 0.0 0 0 0 0.3", "0 0 0 0 0 0")
    world.spawn_sdf("ball", text, Pose((0.3, -0.2, 3.4)), str)
    corners = 2.0 * np.array(points)[np.array(faces) - 1]
    edges = 0.5 * (corners + np.roll(corners, 1, axis=1))
    middles = corners.mean(axis=1)
    targets = np.concatenate([corners.reshape(-1, 3), edges.reshape(-1, 3), middles])
    lengths = np.linalg.norm(targets, axis=1)
    center = np.array((0.3, -0.2, 3.4))
    rays = targets / lengths[:, None]
    found = world.engine.cast_rays(Rays(center, rays, 0.0, FAR))
    np.testing.assert_allclose(found, lengths, atol=1e-12)
    assert np.isfinite(world.engine.cast_rays(Rays(center, directions(5000), 0.0, FAR))).all()


def test_what_is_nowhere_hides_nothing(world):
    """A body whose position is not a number any more."""
    spread(world, 3, static=False)
    world.step()
    expected = cast(world, directions())
    world.spawn_sdf("lost", model([SHAPES["sphere"]], static=False), Pose((0.0, 5.0, 0.7)), str)
    world.spawn_sdf("far", model([SHAPES["box"]], static=False), Pose((0.0, 9.0, 1.0)), str)
    assert (cast(world, directions()) != expected).any()
    for name, place in (("lost", np.nan), ("far", np.inf)):
        world.engine.refresh()
        world.model(name).body.rows[:, :7] = place
    np.testing.assert_array_equal(cast(world, directions()), expected)
    world.spawn_sdf("behind", model([SHAPES["box"]]), Pose((50.0, 0.0, 0.5)), str)
    np.testing.assert_array_equal(cast(world, directions()), expected)


def test_a_world_of_nothing_is_seen_as_such():
    world = World(solver="ode")
    assert np.isposinf(cast(world, directions())).all()
    world.close()


def test_a_mesh_that_cannot_be_read_is_pybullets(world, tmp_path, monkeypatch):
    closed_mesh(tmp_path / "ball.obj")
    spread(world, 7, count=6)
    mesh = f"<mesh><uri>{tmp_path / 'ball.obj'}</uri></mesh>"
    world.spawn_sdf("ball", model([mesh]), Pose((2.5, 0.0, 0.5)), str)
    expected = cast(world, directions())
    cache = type(world.engine._shapes)
    monkeypatch.setattr(cache, "tree", lambda cache, shape: None)
    world.spawn_sdf("other", model([SHAPES["box"]]), Pose((50.0, 0.0, 0.5)), str)
    np.testing.assert_allclose(cast(world, directions()), expected, atol=5e-3)


ARM = robot(
    '<link name="world"/>', joint("fixed", "fixed", "world", "post"),
    link("post", 1, 1, '<box size="0.2 0.2 2"/>'),
    joint("turn", "continuous", "post", "hand", "0 0 0.4", "0 0 1"),
    link("hand", 1, 1, '<sphere radius="0.3"/>').replace("<origin rpy", '<origin xyz="0 1 0" rpy'),
)  # fmt: skip


def test_a_robot_that_stands_fast_is_seen_where_its_links_are(world):
    world.spawn_urdf("arm", ARM, Pose((3.3, -0.2, 0.0)), str)
    arm = world.model("arm")
    rays = np.array([(3.0, 0.0, 0.0), (3.0, 1.0, 0.0), (2.0, 0.0, 0.0)])
    rays /= np.linalg.norm(rays, axis=1)[:, None]
    expected = [2.9, math.sqrt(10.0) - 0.3, 2.9]
    np.testing.assert_allclose(cast(world, rays), expected, atol=1e-6)
    arm.body.motor(arm.body.joints[0]).set_position(math.pi / 2)  # the hand is in front of the post
    np.testing.assert_allclose(cast(world, rays), [1.7, math.inf, 1.7], atol=1e-6)


def test_the_same_far_from_the_origin(world):
    """Single precision has 6 cm at 1,000 km."""
    away, place = np.array((1e6, -1e6, 0.0)), np.array((3.0, 0.0, 0.5))
    rays = directions(200, flat=True)
    for number, at in enumerate((place, away + place)):
        world.spawn_sdf(f"box{number}", model([SHAPES["box"]]), Pose(tuple(at.tolist())), str)
    world.step()
    ours = world.engine.cast_rays(Rays(away + CENTER, rays, NEAR, FAR))
    assert np.isfinite(ours).any()
    np.testing.assert_allclose(ours, cast(world, rays), atol=1e-8)


def test_scenes_that_are_too_large_for_single_precision(world):
    for x in (-20e3, 20e3, 3.0):
        world.spawn_sdf(f"b{x:.0f}", model([SHAPES["box"]]), Pose((x, 0.0, 0.5)), str)
    world.step()
    assert np.isfinite(assert_same(world, directions(flat=True))).any()


def test_all_rays_of_a_turned_lidar_in_a_room(world):
    room = [f"<box><size>{size}</size></box>" for size in ("8 0.1 8", "0.1 8 8", "8 8 0.1")]
    for number, at in enumerate([(0, 3, 0), (0, -3, 0), (3, 0, 0), (-3, 0, 0), (0, 0, 3)]):
        shape = room[(0, 0, 1, 1, 2)[number]]
        text = model([shape]).replace("0 0.0 0 0 0 0.3", "0 0 0 0 0 0")
        world.spawn_sdf(f"wall{number}", text, Pose(tuple(map(float, at))), str)
    world.step()
    spec = RaySpec(
        name="l",
        link="l",
        samples=100,
        min_angle=-1.0,
        max_angle=2.0,
        range_min=0.1,
        range_max=20.0,
    )
    for seed in range(5):
        quaternion = np.random.default_rng(seed).normal(size=4)
        quaternion /= np.linalg.norm(quaternion)
        ranges = Lidar(spec).scan(world.engine, CENTER, quaternion)
        rays = Lidar(spec).directions @ rotation_matrix(quaternion).T
        np.testing.assert_allclose(ranges, in_bullet(world, rays, 0.1, 20.0), atol=1e-3)


def test_a_merged_links_motion_is_that_of_its_state():
    """What a lidar asks for at each scan: the faster way gives the same."""
    world = World()
    text = (
        '<robot name="r"><link name="base"><inertial><mass value="1"/><inertia ixx="1" ixy="0" '
        'ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link><link name="laser"/>'
        '<joint name="j" type="fixed"><origin xyz="0.3 0.1 0.2" rpy="0.1 0.2 0.3"/>'
        '<parent link="base"/><child link="laser"/></joint></robot>'
    )
    robot = world.spawn_urdf("r", text, Pose.from_xyz_rpy((1, 2, 3), (0.3, -0.2, 1.0)), str)
    robot.set_state(robot.pose, (1.0, 0.5, 0.0), (0.3, -2.0, 1.0))
    world.step(10)
    pose, linear, angular = robot.link_state("laser")
    motion = robot.link_motion("laser")
    for got, expected in zip(motion, (pose.position, pose.orientation, linear, angular)):
        assert got == pytest.approx(tuple(expected), abs=1e-12)
    assert np.linalg.norm(motion[2]) > 0.5
    world.close()
