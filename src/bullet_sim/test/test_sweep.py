"""Rays of a lidar by way of the scenery against PyBullet's own, among all kinds of shapes."""

import importlib
import math
import platform
import subprocess
import sys

import numpy as np
import pytest
from bullet_sim.engine import Engine
from bullet_sim.formats.sdf import world as sdf
from bullet_sim.plugins.lidars import RaySpec
from bullet_sim.pose import Pose, rotation_matrix
from bullet_sim.sensors.lidar import Lidar
from bullet_sim.world import World

HAS_WHEEL = platform.machine() == "x86_64"
CASTERS = ("pybullet", "embree", "embree and ode") if HAS_WHEEL else ("pybullet",)
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


@pytest.fixture(name="world", params=CASTERS)
def _world(request, monkeypatch):
    """A world with a ground; Embree's wheel is there or not."""
    if request.param != "pybullet":
        importlib.import_module("embreex.rtcore_scene")
    else:
        monkeypatch.setitem(sys.modules, "embreex.rtcore_scene", None)  # cannot be imported
    made = World(solver="ode" if request.param.endswith("ode") else "bullet")
    made.spawn(sdf.ground_plane())
    yield made
    made.close()


def directions(count=400, seed=0, flat=False):
    """Unit vectors (n, 3) to all sides."""
    vectors = np.random.default_rng(seed).normal(size=(count, 3))
    if flat:
        vectors[:, 2] = 0.0
    return vectors / np.linalg.norm(vectors, axis=1)[:, None]


def everywhere(far=FAR):
    """The box of a sweep to all sides."""
    return CENTER - far, CENTER + far


def cast(world, rays, start=NEAR, end=FAR):
    """Distances by PyBullet alone."""
    fractions, bodies = world.engine.rays.cast(CENTER + start * rays, CENTER + end * rays)
    return np.where(bodies >= 0, start + fractions * (end - start), np.inf)


def assert_same(world, rays=None):
    """A sweep is PyBullet's, but for a ray in 100 that may graze an edge.

    PyBullet's cylinders have 32 sides, of 2 mm at these radii.
    """
    rays = directions() if rays is None else rays
    ours = world.engine.rays.sweep(CENTER, rays, everywhere(), NEAR, FAR, None, False)
    expected = cast(world, rays)
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
    for x in (2.0, 2.5, 3.0, 3.5, 4.0, 4.5):  # in the end it is none that never moves
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
    rays = directions(flat=True)
    ranges = world.engine.rays.sweep(CENTER, rays, everywhere(), NEAR, FAR, None, False)
    world.delete("box")
    return ranges


@pytest.mark.parametrize("bits", [0, 1, 4])
@pytest.mark.parametrize("static", [True, False])
def test_a_link_is_seen_whatever_its_bits(world, request, monkeypatch, bits, static):
    """As by Gazebo's lidar, and at once: worlds that Gazebo has saved have bits everywhere.

    PyBullet's rays do not meet what has none.
    """
    expected = seen(world, None, static)
    assert np.isfinite(expected).any()
    caster = request.node.callspec.params["world"]
    if caster == "embree and ode" or (static and caster == "embree"):
        monkeypatch.setattr(world.engine.rays, "cast", None)  # PyBullet is not asked
    elif not bits:
        expected = np.full(len(expected), np.inf)
    np.testing.assert_allclose(seen(world, bits, static), expected, atol=5e-3)


def test_what_is_nearer_than_the_least_range(world):
    rays = directions(200, flat=True)
    box = everywhere()
    sweep = world.engine.rays.sweep
    assert np.isposinf(sweep(CENTER, rays, box, NEAR, FAR)).all()
    world.spawn_sdf("static", model([SHAPES["box"]]), Pose((0.65, -0.2, 0.4)), str)
    world.step()
    ours = sweep(CENTER, rays, box, NEAR, FAR)
    expected = np.isfinite(cast(world, rays, 0.0, NEAR))
    assert expected.any() and (np.isneginf(ours) == expected).mean() > 0.98
    body = world.model("static").body
    assert not np.isneginf(sweep(CENTER, rays, box, NEAR, FAR, own=body)).any()
    assert not np.isneginf(sweep(CENTER, rays, box, NEAR, FAR, look_near=False)).any()
    world.delete("static")
    world.spawn_sdf("free", model([SHAPES["box"]], static=False), Pose((0.65, -0.2, 1.0)), str)
    world.step()
    body = world.model("free").body
    assert np.isneginf(sweep(CENTER, rays, box, NEAR, FAR)).any()
    housed = sweep(CENTER, rays, box, NEAR, FAR, own=body)
    assert not np.isneginf(housed).any() and np.isfinite(housed).any()


def test_rays_that_begin_inside_a_box_see_what_is_beyond_it(world):
    """As PyBullet's: a solid is hit from outside only."""
    world.spawn_sdf("around", model(["<box><size>2 2 2</size></box>"]), Pose((0.3, -0.2, 0.4)), str)
    spread(world, 6)
    world.step()
    assert np.isfinite(assert_same(world)).any()


@pytest.mark.parametrize("static", [True, False])
def test_round_shapes_are_round(world, static):
    """The distances are those of closed forms, along and beside the middle."""
    sphere, cylinder = model([SHAPES["sphere"]], static), model([SHAPES["cylinder"]], static)
    world.spawn_sdf("sphere", sphere, Pose((3.3, -0.2, 0.7)), str)
    world.spawn_sdf("cylinder", cylinder, Pose((0.3, 2.8, 0.75)), str)
    exact = static or type(world.engine) is not Engine  # else they are PyBullet's
    offset = np.array((0.0, 0.2))
    rays = np.array([(3.0, 0.0, 0.0), (3.0, 0.2, 0.0), (0.0, 3.0, 0.0), (0.2, 3.0, 0.0)])
    rays /= np.linalg.norm(rays, axis=1)[:, None]
    found = world.engine.rays.sweep(CENTER, rays, everywhere(), NEAR, FAR, None, False)
    height = 0.7 - CENTER[2]
    sine = offset / np.hypot(3.0, offset)
    cosine = 3.0 / np.hypot(3.0, offset)
    ball = 3.0 * cosine - np.sqrt(0.7**2 - height**2 - (3.0 * sine) ** 2)
    tube = 3.0 * cosine - np.sqrt(0.4**2 - (3.0 * sine) ** 2)
    np.testing.assert_allclose(found, [*ball, *tube], atol=1e-9 if exact else 5e-3)


WITHOUT_NUMBA = """
import sys
sys.modules["numba"] = None
import numpy as np
from bullet_sim.pose import Pose
from bullet_sim.world import World
world = World(solver="bullet")
for number, shape in enumerate(sys.argv[1:]):
    world.spawn_sdf(f"m{number}", shape, Pose((2.0 + number, 0.0, 0.5)), str)
rays = np.array([(np.cos(a), np.sin(a), 0.0) for a in np.linspace(-0.3, 0.3, 61)])
center, reach = np.array((0.0, 0.0, 0.4)), np.full(3, 9.0)
print(world.engine.rays.sweep(center, rays, (center - reach, center + reach), 0.1, 9.0).tolist())
"""


def test_rays_are_the_same_without_numba():
    """The closed forms are then computed by Python; the solver 'bullet' does not need numba."""
    shapes = [model([SHAPES["cylinder"]]), model([SHAPES["sphere"]])]
    slow = WITHOUT_NUMBA, WITHOUT_NUMBA.replace('sys.modules["numba"] = None', "")
    found = [
        subprocess.check_output([sys.executable, "-c", program, *shapes], text=True)
        for program in slow
    ]
    assert found[0] == found[1] and "inf" in found[0]


def test_the_same_far_from_the_origin(world):
    """Single precision has 6 cm at 1,000 km; distances are counted from the scenery's middle."""
    away = np.array((1e6, -1e6, 0.0))
    world.spawn_sdf("box", model([SHAPES["box"]]), Pose(tuple(away + (3.0, 0.0, 0.5))), str)
    world.step()
    rays = directions(200, flat=True)
    center = away + CENTER
    caster, box = world.engine.rays, (center - FAR, center + FAR)
    ours = caster.sweep(center, rays, box, NEAR, FAR, None, False)
    fractions, bodies = caster.cast(center + NEAR * rays, center + FAR * rays)
    expected = np.where(bodies >= 0, NEAR + fractions * (FAR - NEAR), np.inf)
    assert np.isfinite(expected).any()
    with np.errstate(invalid="ignore"):
        assert ((ours == expected) | (np.abs(ours - expected) < 1e-3)).mean() > 0.98


def test_scenery_that_is_too_large_for_single_precision_is_pybullets(world):
    for x in (-20e3, 20e3, 3.0):
        world.spawn_sdf(f"b{x:.0f}", model([SHAPES["box"]]), Pose((x, 0.0, 0.5)), str)
    world.step()
    assert np.isfinite(assert_same(world, directions(flat=True))).any()


def test_the_box_of_a_turned_lidar_holds_its_rays(world):
    """A box that is too small loses hits: all rays of a lidar in a room, turned any way."""
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
        np.testing.assert_allclose(ranges, cast(world, rays, 0.1, 20.0), atol=1e-3)


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
