"""Loose objects at rest sleep, and wake when something moves them; with the same bits."""

import functools
import math

import pytest
from bullet_sim.formats.sdf.world import parse_model
from bullet_sim.formats.urdf import parse_urdf
from bullet_sim.models.changes import step_range
from bullet_sim.pose import Pose
from contact_scenes import friction, ground, nowhere, sdf_box, skid_base, world_of

world_of = functools.partial(world_of, solver="bullet")

SIZE = 0.3
ASLEEP = 2000  # steps after which a box that was dropped from some centimeters sleeps


def box(name, mu=0.6, more=""):
    """A box, resting at a height of SIZE / 2."""
    return sdf_box(name, (SIZE, SIZE, SIZE), surface=friction(mu), more=more)


def boxes(*places, step=0.001):
    """World of a floor and boxes a, b, c ... dropped at places (x, y, z) [m]."""
    pairs = [(box(name), Pose(place)) for name, place in zip("abcdefgh", places)]
    return world_of((ground(), None), *pairs, step=step)


def asleep(world):
    """Names of the models that sleep."""
    return "".join(
        name for name, model in world.models.items() if world.engine.is_asleep(model.body)
    )


def poses(world):
    return [world.engine.body_pose(model.body) for model in world.models.values()]


def moved(world, name, steps):
    """How far [m] a model moves in some steps."""
    before = world.models[name].pose.position
    world.step(steps)
    return math.dist(before, world.models[name].pose.position)


@pytest.fixture
def pile():
    """Boxes a and b apart from each other, c on a; they sleep."""
    world = boxes((0, 0, 0.17), (2, 0, 0.17), (0, 0, 0.5))
    world.step(ASLEEP)
    yield world
    world.close()


def test_what_rests_falls_asleep_and_does_not_move(pile):
    assert asleep(pile) == "abc"
    pile.step(10)
    before = poses(pile)
    pile.step(3000)
    assert poses(pile) == before
    assert pile.models["c"].pose.position[2] == pytest.approx(1.5 * SIZE, abs=1e-3)


@pytest.mark.parametrize("step", [0.0005, 0.001, 0.004, 0.01])
def test_it_takes_a_second_of_simulated_time(step):
    world = boxes((0, 0, 0.151), step=step)
    world.step(round(0.9 / step))
    assert asleep(world) == ""
    world.step(round(1.2 / step))
    assert asleep(world) == "a"
    world.close()


def test_what_moves_slowly_stays_awake():
    world = world_of((ground(), None), (box("a", mu=0.0), Pose((0, 0, 0.15))))
    world.step(100)
    world.models["a"].set_velocity((0.004, 0, 0))
    assert moved(world, "a", 5000) == pytest.approx(0.02, rel=0.05)
    assert asleep(world) == ""
    world.close()


def test_the_car_that_runs_into_it_pushes_it():
    car = skid_base(20.0, 0.3, 0.3, 0.2, 1.0)
    world = world_of((ground(), None), (box("a"), Pose((1.5, 0, 0.16))), (car, Pose((0, 0, 0.21))))
    world.step(ASLEEP)
    assert asleep(world) == "a"
    for _ in range(60):
        world.models["skid"].set_velocity((1.0, 0, 0))
        world.step(25)
    assert world.models["a"].pose.position[0] > 1.7
    world.step(4000)
    assert asleep(world) == "a"  # again, where it was pushed to
    world.close()


def test_one_that_falls_on_it_wakes_it_and_all_sleep_again(pile):
    pile.spawn(box("d"), Pose((2.2, 0.05, 1.5)))
    pile.step(800)
    assert "b" not in asleep(pile)
    pile.step(4000)
    assert asleep(pile) == "abcd"


def test_velocities_poses_and_gravity_wake_at_once(pile):
    pile.models["b"].set_velocity((1.0, 0, 0))
    pile.step(1)
    speed = pile.engine.link_motion(pile.models["b"].body, -1)[2][0]
    assert speed == pytest.approx(1.0 - 0.6 * 9.81 * 0.001, rel=1e-3)
    assert asleep(pile) == "ac"
    pile.models["a"].set_state(Pose((5, 5, 1.0)))
    pile.step(200)
    assert pile.models["a"].pose.position[2] == pytest.approx(1.0 - 0.5 * 9.81 * 0.2**2, abs=2e-3)
    assert pile.models["c"].pose.position[2] < 0.3  # what it stood on is gone
    pile.step(4000)
    assert asleep(pile) == "abc"
    pile.engine.set_gravity((0, 0, 1.0))
    pile.step(100)
    assert all(pile.engine.link_motion(pile.models[n].body, -1)[2][2] > 0.09 for n in "abc")


@pytest.mark.parametrize("start", [0.0, 9.0])
def test_a_wrench_of_one_step_is_not_lost(pile, start):
    model = pile.models["b"]
    steps = step_range(pile.step_count, pile.time_step, start, 0.001)
    pile.forces.apply_wrench(model, "l", (1000.0, 0, 0), (0, 0, 0), steps)
    pile.step(steps[0] + 1 - pile.step_count)
    speed = pile.engine.link_motion(model.body, -1)[2][0]
    assert speed == pytest.approx(1.0 - 0.6 * 9.81 * 0.001, rel=1e-2)


def test_what_stood_on_a_deleted_model_falls(pile):
    pile.delete("a")
    pile.step(1000)
    assert pile.models["c"].pose.position[2] == pytest.approx(SIZE / 2, abs=1e-3)


def test_a_moved_table_lets_its_load_fall():
    table = sdf_box("table", (1, 1, 0.1), static=True)
    world = world_of((ground(), None), (table, Pose((0, 0, 1.0))), (box("a"), Pose((0, 0, 1.22))))
    world.step(ASLEEP)
    assert asleep(world) == "a"
    world.models["table"].set_state(Pose((3, 0, 1.0)))
    world.step(1000)
    assert world.models["a"].pose.position[2] == pytest.approx(SIZE / 2, abs=1e-3)
    world.close()


def events(world):
    """What a world does while boxes sleep, are woken and sleep again."""
    found = []
    for name, velocity in ("b", (1.0, 0.3, 0)), ("c", (0.8, 0, 0)), ("a", (0, 0, 2.0)):
        world.step(730)
        found.append(poses(world))
        world.models[name].set_velocity(velocity)
        world.step(2600)
        found.append((poses(world), asleep(world)))
    return found


@pytest.mark.parametrize("steps", [700, 1650, ASLEEP])
def test_a_saved_state_goes_on_to_the_bit(steps):
    world = boxes((0, 0, 0.17), (2, 0, 0.17), (0, 0, 0.5))
    world.step(steps)
    state = world.save_state()
    first = events(world)
    assert any(sleepers for _, sleepers in first[1::2])
    assert world.restore_state(state) == ""
    assert events(world) == first
    world.step(50)
    assert world.restore_state(state) == ""
    assert events(world) == first
    world.close()


def test_a_reset_world_does_the_same_again(pile):
    first = events(pile)
    pile.reset()
    pile.step(ASLEEP)
    assert events(pile) == first


def test_results_do_not_depend_on_the_size_of_batches():
    found = []
    for batch in (1, 7, 2600):
        world = boxes((0, 0, 0.17), (2, 0, 0.17), (0, 0, 0.5))
        for _ in range(2600 // batch):
            world.step(batch)
        world.step(2600 % batch)
        found.append((poses(world), asleep(world)))
        world.close()
    assert found[0] == found[1] == found[2] and found[0][1] == "abc"


HINGED = """<sdf version="1.6"><model name="door"><link name="a"><inertial><mass>5</mass></inertial>
<collision name="c"><geometry><box><size>1 1 1</size></box></geometry></collision></link>
<link name="b"><pose>1.2 0 0 0 0 0</pose><inertial><mass>1</mass></inertial></link>
<joint name="j" type="revolute"><parent>a</parent><child>b</child><axis><xyz>0 0 1</xyz></axis>
</joint></model></sdf>"""
PLANAR = """<robot name="car"><link name="base"><inertial><mass value="1"/><inertia ixx="0.1"
iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial><collision><geometry>
<box size="0.3 0.3 0.3"/></geometry></collision></link><gazebo><plugin name="p"
filename="libgazebo_ros_planar_move.so"/></gazebo></robot>"""
STUBBORN = '<allow_auto_disable>false</allow_auto_disable><link name="l">'


def test_models_with_joints_or_plugins_and_those_that_may_not_stay_awake():
    text = '<sdf version="1.6"><model name="stubborn">' + STUBBORN
    text += '<inertial><mass>1</mass></inertial><collision name="c"><geometry><box><size>1 1 1'
    text += "</size></box></geometry></collision></link></model></sdf>"
    world = world_of(
        (ground(), None),
        (parse_model(HINGED, nowhere, "door")[0], Pose((0, 0, 0.51))),
        (parse_urdf(PLANAR, nowhere, "car"), Pose((3, 0, 0.16))),
        (parse_model(text, nowhere, "stubborn")[0], Pose((5, 0, 0.51))),
        (box("weightless", more="<gravity>false</gravity>"), Pose((7, 0, 1.0))),
        (box("a"), Pose((9, 0, 0.16))),
    )
    world.step(3000)
    assert asleep(world) == "a"
    world.close()
