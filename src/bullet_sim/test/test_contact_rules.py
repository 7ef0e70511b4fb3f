"""Which bodies meet, weigh something, move out of each other, sleep, or go astray."""

import math

import numpy as np
import pytest
import trimesh
from bullet_sim.engine.api import Rays
from bullet_sim.formats.sdf.world import parse_model, parse_world
from bullet_sim.formats.urdf import parse_urdf
from bullet_sim.models.changes import step_range
from bullet_sim.pose import Pose
from bullet_sim.world import World
from contact_scenes import friction, ground, nowhere, sdf_box, skid_base, world_of
from PIL import Image
from urdf_texts import joint, link, robot

pytestmark = pytest.mark.usefixtures("sketches")

both_solvers = pytest.mark.parametrize("solver", ["ode", "bullet"])
RADIUS, SIZE = 0.2, 0.3


def heights(world, name, time, every=20):
    """Heights [m] of a model's root link over some time [s]."""
    found = []
    for _ in range(round(time / world.time_step / every)):
        world.step(every)
        found.append(world.models[name].pose.position[2])
    return found


# masks, weight -----------------------------------------------------------------------------------
def mask(bits):
    return f"<contact><collide_bitmask>{bits}</collide_bitmask></contact>"


@both_solvers
@pytest.mark.parametrize(
    "first, second, touch",
    [
        ("0x01", "0x02", False),
        ("0x01", "0x01", True),
        ("0x01", "0x03", True),
        ("1", "2", False),
        (None, "0x02", True),
        (None, "0x00", False),
    ],
)
def test_bitmasks(first, second, touch, solver):
    """A box falls onto another, or through it."""
    surfaces = ["" if bits is None else mask(bits) for bits in (first, second)]
    lower = sdf_box("lower", (0.4, 0.4, 0.2), mass=10.0, surface=surfaces[0])
    upper = sdf_box("upper", (0.2, 0.2, 0.2), surface=surfaces[1])
    places = (ground(), None), (lower, Pose((0, 0, 0.1))), (upper, Pose((0, 0, 0.4)))
    world = world_of(*places, solver=solver)
    world.step(1000)
    z = world.models["upper"].pose.position[2]
    world.close()
    if second == "0x00":
        assert z < -1.0  # touches not even the ground
    else:
        assert z == pytest.approx(0.3 if touch else 0.1, abs=0.005)


@both_solvers
def test_a_link_without_gravity_floats(solver):
    world = world_of(
        (sdf_box("balloon", (0.2, 0.2, 0.2), more="<gravity>false</gravity>"), Pose((0, 0, 5))),
        (sdf_box("stone", (0.2, 0.2, 0.2)), Pose((2, 0, 5))),
        solver=solver,
    )
    world.step(500)
    drop = {name: 5 - model.pose.position[2] for name, model in world.models.items()}
    world.close()
    assert drop["stone"] == pytest.approx(0.5 * 9.81 * 0.25, rel=0.01)
    assert abs(drop["balloon"]) < 1e-9


def test_a_merged_link_without_gravity_takes_its_weight_from_the_model():
    """Half the weight at one end: it falls at half of g and turns to that side."""
    text = (
        '<sdf version="1.6"><model name="two">'
        + "".join(
            f'<link name="{name}"><pose>{x} 0 0 0 0 0</pose><gravity>{on}</gravity><inertial><mass>'
            "1</mass><inertia><ixx>0.01</ixx><iyy>0.01</iyy><izz>0.01</izz></inertia></inertial>"
            "</link>"
            for name, x, on in (("a", 0, "true"), ("b", 1, "false"))
        )
        + '<joint name="j" type="fixed"><parent>a</parent><child>b</child></joint></model></sdf>'
    )
    two = parse_model(text, nowhere, "two")[0]
    world = world_of((two, Pose((4, 0, 5))), solver="bullet")
    world.step(100)
    _, _, linear, angular = world.models["two"].link_motion("a")
    world.close()
    # about the middle: m g / 2 at 0.5 m turns 2 (0.01 + 1 0.5^2); the end falls faster
    assert angular[1] == pytest.approx(-0.5 * 9.81 / 0.52 * 0.1, rel=0.02)
    assert linear[2] == pytest.approx(-(0.5 + 0.25 / 0.52) * 9.81 * 0.1, rel=0.02)


# spawned inside something ------------------------------------------------------------------------
@pytest.mark.parametrize("depth", [0.002, 0.02, 0.1, 0.235])
@pytest.mark.parametrize("step", [0.001, 0.004])
def test_a_base_spawned_in_the_ground_stands_on_it_and_does_not_jump(depth, step):
    base = skid_base(48.0, 0.3, 0.3, RADIUS, 1.0)
    world = world_of((ground(), None), (base, Pose((1, 2, RADIUS - depth))), step=step)
    found = heights(world, "skid", 3.0)
    x, y, z = world.models["skid"].pose.position
    world.close()
    assert max(found) < RADIUS + 0.001
    assert z == pytest.approx(RADIUS, abs=0.001)
    assert (x, y) == pytest.approx((1.0, 2.0), abs=0.02)


def test_a_box_spawned_in_a_wall_leaves_it_sideways():
    wall = sdf_box("wall", (0.2, 4.0, 2.0), static=True)
    box = sdf_box("box", (0.4, 0.4, 0.4))
    world = world_of((ground(), None), (wall, Pose((0, 0, 1.0))), (box, Pose((0.25, 0, 0.2))))
    found = heights(world, "box", 3.0)
    x, y, _ = world.models["box"].pose.position
    world.close()
    assert max(found) < 0.25
    assert x == pytest.approx(0.3, abs=0.02) and y == pytest.approx(0.0, abs=0.02)


def test_what_is_not_deeper_than_min_depth_stays_there():
    deep = "<contact><ode><min_depth>0.03</min_depth></ode></contact>"
    box = sdf_box("box", (0.4, 0.4, 0.4), surface=deep)
    world = world_of((ground(), None), (box, Pose((0, 0, 0.18))))
    world.spawn(sdf_box("deeper", (0.4, 0.4, 0.4), surface=deep), Pose((2, 0, 0.15)))
    world.step(2000)
    found = [world.models[name].pose.position[2] for name in ("box", "deeper")]
    world.close()
    assert found == pytest.approx([0.18, 0.17], abs=1e-3)


# sleep -------------------------------------------------------------------------------------------
def box(name, mu=0.6):
    """A box, resting at a height of SIZE / 2."""
    return sdf_box(name, (SIZE, SIZE, SIZE), surface=friction(mu))


def sleeps(world, name="a"):
    return world.models[name].body.is_resting()


@pytest.fixture
def sleeper():
    """World of a box 'a' that sleeps."""
    world = world_of((ground(), None), (box("a"), Pose((0, 0, SIZE / 2))))
    world.step(1500)
    assert sleeps(world)
    yield world
    world.close()


@pytest.mark.parametrize("step", [0.0005, 0.001, 0.004])
def test_it_takes_a_second_of_simulated_time(step):
    world = world_of((ground(), None), (box("a"), Pose((0, 0, 0.151))), step=step)
    world.step(round(0.9 / step))
    assert not sleeps(world)
    world.step(round(1.2 / step))
    assert sleeps(world)
    world.close()


def test_what_is_set_wakes_at_once(sleeper):
    model = sleeper.models["a"]
    model.set_velocity((1.0, 0, 0))
    sleeper.step(1)
    assert not sleeps(sleeper)
    assert model.link_motion("l")[2][0] == pytest.approx(1.0 - 0.6 * 9.81 * 0.001, abs=2e-3)
    model.set_state(Pose((5, 5, 1.0)))
    sleeper.step(200)
    assert model.pose.position[2] == pytest.approx(1.0 - 0.5 * 9.81 * 0.2**2, abs=2e-3)
    sleeper.step(4000)
    assert sleeps(sleeper)
    sleeper.engine.set_gravity((0, 0, 1.0))
    sleeper.step(100)
    assert model.link_motion("l")[2][2] > 0.09


@pytest.mark.parametrize("start", [0.0, 9.0])
def test_a_wrench_of_one_step_is_not_lost(sleeper, start):
    steps = step_range(sleeper.step_count, sleeper.time_step, start, 0.001)
    sleeper.forces.apply_wrench(sleeper.models["a"], "l", (1000.0, 0, 0), (0, 0, 0), steps)
    sleeper.step(steps[0] + 1 - sleeper.step_count)
    speed = sleeper.models["a"].link_motion("l")[2][0]
    assert speed == pytest.approx(1.0 - 0.6 * 9.81 * 0.001, rel=1e-2)


def test_what_sleeps_on_a_table_stays_when_that_is_moved_as_in_gazebo():
    """Measured in Gazebo 11.1 of what is static: nothing wakes what was on it."""
    table = sdf_box("table", (1, 1, 0.1), static=True)
    world = world_of((ground(), None), (table, Pose((0, 0, 1.0))), (box("a"), Pose((0, 0, 1.22))))
    world.step(2000)
    assert sleeps(world)
    world.models["table"].set_state(Pose((3, 0, 1.0)))
    world.step(1000)
    assert sleeps(world) and world.models["a"].pose.position[2] > 1.1
    world.close()


def test_the_car_that_runs_into_it_pushes_it():
    car = skid_base(20.0, 0.3, 0.3, 0.2, 1.0)
    world = world_of((ground(), None), (box("a"), Pose((1.5, 0, 0.15))), (car, Pose((0, 0, 0.21))))
    world.step(1500)
    assert sleeps(world)
    for _ in range(60):
        world.models["skid"].set_velocity((1.0, 0, 0))
        world.step(25)
    assert world.models["a"].pose.position[0] > 1.7
    world.step(4000)
    assert sleeps(world)  # again, where it was pushed to
    world.close()


# skid steering -----------------------------------------------------------------------------------
def test_acceleration_straight_ahead_is_what_the_efforts_allow():
    """a = 4 tau / r / (m + 4 I / r^2) below the friction limit."""
    mass, radius, effort = 20.0, 0.1, 1.0
    base = skid_base(mass, 0.2, 0.2, radius, 1.0)
    world = world_of((ground(), None), (base, Pose((0, 0, radius))))
    world.step(200)
    model = world.models["skid"]
    for number in range(4):
        model.body.motor(model.body.joints[number]).track_velocity(50.0 / radius, effort)
    world.step(1000)
    speed = model.link_motion("base")[2][0]
    world.close()
    inertia = 1.0 * radius**2 / 2
    expected = 4 * effort / radius / (mass + 4 + 4 * inertia / radius**2)
    assert speed == pytest.approx(expected, rel=0.02)


# astray ------------------------------------------------------------------------------------------
@both_solvers
@pytest.mark.parametrize(
    "state, words",
    [
        ((Pose((0, 0, 5)), (0, 0, 900.0)), "moves at"),
        ((Pose((0, 0, -5000.0)), (0, 0, 0)), "has left"),
    ],
)
def test_a_model_that_goes_astray_is_said_once(state, words, solver):
    world = world_of((sdf_box("kite", (0.1, 0.1, 0.1)), Pose((0, 0, 5))), solver=solver)
    said = []
    world.on_implausible = said.append
    world.step(300)
    assert said == []
    world.models["kite"].set_state(*state)
    world.step(2000)
    assert len(said) == 1 and "'kite'" in said[0] and words in said[0]
    world.reset()
    world.models["kite"].set_state(*state)
    world.step(600)
    world.close()
    assert len(said) == 2


@pytest.mark.parametrize("damping", [10.0, 1e3, 1e9])
def test_a_robot_whose_damping_is_unstable_ends_nothing_but_itself(damping):
    """Damping acts by the velocity before the step, as in Gazebo: here it grows 9 times and more in
    each step, until it is no number."""
    arm = parse_urdf(
        robot(
            '<link name="world"/>',
            link("tip", 0.1, 1e-5, '<sphere radius="0.05"/>', center="0.1 0 0"),
            joint("j", "continuous", "world", "tip", more=f'<dynamics damping="{damping}"/>'),
        ),
        nowhere,
        "arm",
    )
    box = sdf_box("box", (0.2, 0.2, 0.2))
    world = world_of((ground(), None), (arm, Pose((0, 0, 0.3))), (box, Pose((0, 0.5, 0.4))))
    said = []
    world.on_implausible = said.append
    world.step(2000)
    angle, *_ = world.models["arm"].body.joint_states()[0]
    box_height = world.models["box"].pose.position[2]
    ranges = world.engine.cast_rays(Rays((0, 0.5, 2.0), [[0.0, 0.0, -1.0]], 0.0, 5.0))
    world.engine.remove(world.models["arm"].body)
    world.step(100)
    world.close()
    assert box_height == pytest.approx(0.1, abs=0.002)
    assert ranges == pytest.approx([1.8], abs=0.002)
    assert math.isnan(angle) and len(said) == 1 and "no finite position" in said[0]


SHAPES = {
    "box": "<box><size>0.5 0.5 0.5</size></box>",
    "can": "<cylinder><radius>0.3</radius><length>0.5</length></cylinder>",
    "ball": "<sphere><radius>0.3</radius></sphere>",
    "mesh": "<mesh><uri>{0}/body.stl</uri></mesh>",
}
LAND = {
    "plane": "<plane><normal>0 0 1</normal></plane>",
    "heightmap": "<heightmap><uri>{0}/hills.png</uri><size>40 40 1</size></heightmap>",
    "mesh": "<mesh><uri>{0}/land.stl</uri></mesh>",
    "box": "<box><size>40 40 1</size></box>",
}


def with_body(name, place, shape, static=0):
    body = f"<collision name='c'><geometry>{shape}</geometry></collision>"
    mass = "<inertial><mass>1</mass></inertial>"
    link = f"<link name='l'>{mass}{body}</link>"
    return f"<model name='{name}'><static>{static}</static><pose>{place}</pose>{link}</model>"


@pytest.mark.parametrize("push", [(1e308, 0.0), (0.0, 1e308)], ids=["force", "torque"])
@pytest.mark.parametrize("land", LAND)
@pytest.mark.parametrize("shape", SHAPES)
def test_what_is_no_number_any_more_touches_nothing(tmp_path, shape, land, push):
    """It was in contact with every triangle of a height map or a mesh: 0.07 of real time, and less.

    What else there is moves on to the same bits, and the body is there again where it is put.
    """
    Image.fromarray(np.arange(65 * 65).reshape(65, 65).astype(np.uint8) % 7).save(
        tmp_path / "hills.png"
    )
    trimesh.creation.box((40.0, 40.0, 1.0)).export(tmp_path / "land.stl")
    trimesh.creation.icosphere(2, 0.3).export(tmp_path / "body.stl")
    text = (
        with_body("land", "0 0 0 0 0 0", LAND[land].format(tmp_path), 1)
        + with_body("lost", "0 0 1.2 0 0 0", SHAPES[shape].format(tmp_path))
        + with_body("other", "4 0 1.2 0.1 0.2 0", SHAPES["box"])
    )
    seen = {}
    for is_pushed in (False, True):
        world, said = World(), []
        world.load(parse_world(f"<sdf version='1.6'><world name='w'>{text}</world></sdf>", str))
        world.on_implausible = said.append
        world.step(300)
        lost, other = world.models["lost"], world.models["other"]
        if is_pushed:
            lost.apply_wrench("l", (push[0], 0.0, push[0]), (0.0, push[1], 0.0))
        world.step(400)
        count = sum(len(world.models[name].body.contacts("l")) for name in ("lost", "land"))
        seen[is_pushed] = other.link_state("l")[0], len(other.body.contacts("l"))
        if is_pushed:
            assert count == seen[True][1] and len(said) == 1 and "'lost'" in said[0]
            lost.set_state(Pose((8.0, 0.0, 3.0)))
            world.step(100)
            assert lost.pose.position == pytest.approx((8.0, 0.0, 3.0 - 4.905 * 0.01), abs=1e-3)
        world.close()
    assert seen[True] == seen[False]
