"""Islands of bodies solved by several threads: the same bits, the world file's island_threads."""

import threading
from dataclasses import replace
from pathlib import Path

import pytest
import xacro
from bullet_sim.formats.sdf import world as sdf
from bullet_sim.pose import Pose
from bullet_sim.world import World
from driving import drive_velocities

SOURCES = Path(__file__).resolve().parents[2]
CAR = SOURCES / "track_model" / "urdf" / "racecar.urdf.xacro"
CAN = (
    "<sdf version='1.6'><model name='can'><link name='l'><inertial><mass>0.2</mass><inertia>"
    "<ixx>2e-4</ixx><iyy>2e-4</iyy><izz>2e-4</izz><ixy>0</ixy><ixz>0</ixz><iyz>0</iyz></inertia>"
    "</inertial><collision name='c'><geometry><cylinder><radius>0.05</radius><length>0.1</length>"
    "</cylinder></geometry></collision></link></model></sdf>"
)
THREADS = (0, 1, 2, 4)
GROUP_ROWS = 64  # at most, of a group of several islands


@pytest.fixture(autouse=True)
def _many_processors(monkeypatch):
    """As many threads as asked for, whatever this machine has."""
    monkeypatch.setattr("bullet_sim.engine.ode.engine.processors", lambda: 8)


def helpers():
    """Names of the threads that help."""
    return [each.name for each in threading.enumerate() if each.name == "islands"]


def made(threads, cars=(), cans=()):
    """A world of cars and cans at poses; the cars turn, each otherwise."""
    world = World(solver="ode")
    described = sdf.parse_world(
        (SOURCES / "track_model" / "worlds" / "track.world").read_text(encoding="utf-8"), str
    )
    world.engine.configure(replace(described.ode, island_threads=threads))
    world.spawn(sdf.ground_plane())
    urdf = xacro.process_file(str(CAR)).toxml()
    for number, (x, y) in enumerate(cars):
        car = world.spawn_urdf(
            f"car{number}", urdf, Pose((x, y, 0.05)),
            lambda uri: uri.replace("package://", f"{SOURCES}/"),
        )  # fmt: skip
        wheels = [name for name in car.joints.names if "wheel" in name]
        drive_velocities(car.joints, wheels, [20.0 + 3.0 * number + k for k in range(len(wheels))])
    for number, (x, y, z) in enumerate(cans):
        world.spawn_sdf(f"can{number}", CAN, Pose((x, y, z)), str)
    return world


def states(threads, steps, **things):
    """Bytes of all bodies and joints during some steps, in calls of several sizes."""
    world = made(threads, **things)
    found = []
    try:
        for count in steps:
            world.step(count)
            found.append(world.engine.rows.tobytes() + world.engine.joint_rows.tobytes())
            assert len(helpers()) == max(0, threads - 1) * (len(world.models) > 2)
    finally:
        world.close()
    assert not helpers()
    return found


APART = [(2.0 * (k % 4), 2.0 * (k // 4)) for k in range(16)]
SCENES = {
    "16 cars": dict(cars=APART),
    "one car": dict(cars=APART[:1]),
    "one island": dict(cars=[(0.45 * k, 0.0) for k in range(4)]),
    "cars among cans that fall and sleep": dict(
        cars=APART[:3],
        cans=[(0.5 + 0.3 * (k % 8), 0.1 * (k % 3), 0.06 + 0.12 * k) for k in range(24)],
    ),
}


@pytest.mark.parametrize("scene", SCENES)
def test_any_number_of_threads_gives_the_same_bits(scene):
    steps = (1, 1, 20, 3, 200, 1, 50) if "cans" not in scene else (1, 20, 400, 1, 900)
    expected = states(0, steps, **SCENES[scene])
    for threads in THREADS[1:]:
        for _ in range(3 if threads > 1 else 1):
            assert states(threads, steps, **SCENES[scene]) == expected, threads


def test_a_group_of_several_islands_has_no_more_rows_than_a_cache_can_keep():
    assert rows_of_groups(dict(cars=APART[:3]), 1) == [[60, 60, 60]]
    cans = dict(cans=[(0.5 * k, 3.0, 0.06) for k in range(24)])
    found = rows_of_groups(cans, 40)
    most = max(max(each) for each in found)
    assert GROUP_ROWS - 12 < most <= GROUP_ROWS, "cans have 12 rows at most, or none"
    assert max(map(len, found)) == 5


def rows_of_groups(things, steps):
    """Rows of each group in each of some steps, of what stands."""
    world = made(0, **things)
    world.step(200 if "cars" in things else 45)
    found = []
    for _ in range(steps):
        world.step()
        islands = world.engine.arrays.state.islands
        begins = islands.starts[: islands.counts[0] + 1, 0]
        found.append(list(begins[1:] - begins[:-1]))
    world.close()
    return found


def test_helpers_end_with_what_they_work_with():
    world = made(3, cars=APART[:2])
    world.step(5)
    assert len(helpers()) == 2
    world.delete("car1")
    world.step(5)
    assert not helpers(), "a single model has a single island"
    world.spawn_sdf("can", CAN, Pose((3.0, 0.0, 0.06)), str)
    world.step(5)
    assert len(helpers()) == 2
    world.engine.configure(replace(world.engine.settings, island_threads=0))
    world.step(5)
    assert not helpers()
    world.engine.configure(replace(world.engine.settings, island_threads=2))
    world.step(5)
    assert len(helpers()) == 1
    del world
    import gc

    gc.collect()
    assert not helpers(), "a world that nobody has any more"


def test_no_more_threads_than_processors(monkeypatch):
    monkeypatch.setattr("bullet_sim.engine.ode.engine.processors", lambda: 1)
    world = made(4, cars=APART[:2])
    world.step(5)
    assert not helpers()
    world.close()


@pytest.mark.parametrize("text, expected", [("3", 3), ("0", 0), ("-2", 0), ("1e9", 1024)])
def test_a_world_file_says_how_many(text, expected):
    found = sdf.parse_world(
        "<sdf version='1.7'><world name='w'><physics type='ode'><ode><solver><island_threads>"
        f"{text}</island_threads></solver></ode></physics></world></sdf>",
        str,
    )
    assert found.ode.island_threads == expected and not found.warnings
