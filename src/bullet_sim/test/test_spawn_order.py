"""Results do not depend, to the bit, on the order of spawning or on a reset before them."""

import itertools

import numpy as np
import pytest
from bullet_sim.description.model import Geometry, Link, ModelDescription, Shape
from bullet_sim.formats.sdf import world as sdf
from bullet_sim.pose import Pose
from bullet_sim.world import World
from urdf_texts import CONTROL, joint, link, robot

NAMES = ("a", "b", "c")
ARM = robot(
    link("base", 1, 0.01, '<box size="0.1 0.1 0.1"/>'), link("tip", 0.2, 1e-3),
    joint("j", "revolute", "base", "tip", "0.2 0 0",
          more='<limit lower="-1" upper="1" effort="5" velocity="10"/>'),
    CONTROL,
)  # fmt: skip


@pytest.fixture(name="make")
def _make():
    worlds = []

    def make():
        worlds.append(World())
        worlds[-1].load(sdf.WorldDescription(models=[(sdf.ground_plane(), Pose())]))
        return worlds[-1]

    yield make
    for world in worlds:
        world.close()


def brick(name):
    """A brick that tumbles."""
    link = Link("link", 1.0, inertia=np.diag([2e-3, 3e-3, 4e-3]))
    link.collisions.append(Shape(Geometry("box", (0.2, 0.15, 0.1))))
    return ModelDescription(name, {"link": link}, root="link")


def spawn(world, names):
    """A heap of bricks."""
    for name in names:
        number = NAMES.index(name)
        world.spawn(
            brick(name),
            Pose.from_xyz_rpy(
                (0.05 * number, 0.03 * number, 0.15 + 0.16 * number), (0.3, 0.2, number)
            ),
        )


def run(world, steps=600):
    """Bytes of all poses on the way, by model."""
    trails = {name: [] for name in world.models}
    for step in range(steps):
        world.step()
        if step % 10 == 0:
            for name, model in world.models.items():
                trails[name].append(
                    np.array(model.pose.position + model.pose.orientation).tobytes()
                )
    return trails


def test_order_of_spawning_makes_no_difference(make):
    trails = []
    for order in itertools.permutations(NAMES):
        world = make()
        spawn(world, order)
        world.sort_before_start()
        assert list(world.models) == ["ground_plane", *NAMES]
        trails.append(run(world))
    assert all(trail == trails[0] for trail in trails)
    assert len(set(trails[0]["c"])) > 30, "the bricks move"


def test_models_that_came_and_went_leave_no_trace(make):
    clean = make()
    spawn(clean, NAMES)
    clean.sort_before_start()
    world = make()
    world.spawn(brick("b"), Pose((0.0, 0.0, 0.1)))
    spawn(world, "a")
    world.delete("b")
    spawn(world, "bc")
    assert world.sort_before_start()
    assert run(world) == run(clean)


def test_reset_is_a_fresh_start_whatever_the_order_was(make):
    fresh = make()
    spawn(fresh, NAMES)
    fresh.sort_before_start()
    world = make()
    spawn(world, "ca")
    world.sort_before_start()
    run(world, 100)
    spawn(world, "b")
    run(world, 100)
    world.sort_models()
    world.reset()
    assert (world.time, run(world)) == (0.0, run(fresh))


def test_settling_happens_only_before_the_first_step_and_once(make):
    world = make()
    spawn(world, "abc")
    assert not world.sort_before_start(), "they are in order"
    world.step()
    world.delete("a")
    spawn(world, "a")
    assert not world.sort_before_start(), "time has passed"
    world.sort_models()
    world.reset()
    assert not world.sort_before_start(), "the reset has loaded them in order"
    world.delete("a")
    spawn(world, "a")
    assert world.sort_before_start() and not world.sort_before_start()


def test_what_was_set_before_the_first_step_stays(make):
    world = make()
    arm = world.spawn_urdf("z_arm", ARM, Pose((0.0, 0.0, 3.0)), str)
    arm.manager.load("c", {"type": "position_controllers/JointPositionController", "joint": "j"})
    arm.manager.switch(["c"], [])
    arm.set_state(Pose((1.0, 2.0, 4.0)), (0.5, 0.0, 0.0), (0.0, 0.0, 1.0))
    arm.joints.set_positions({"j": 0.75})
    spawn(world, "a")
    assert world.sort_before_start()
    assert arm.pose.position == pytest.approx((1.0, 2.0, 4.0))
    np.testing.assert_allclose(arm.link_state("base")[1:], [(0.5, 0, 0), (0, 0, 1)], atol=1e-9)
    assert arm.joints.arrays()[0] == pytest.approx([0.75])
    for _ in range(100):
        world.step()
    assert arm.joints.arrays()[0] == pytest.approx([0.75], abs=0.05), "held where it was put"
    world.reset()
    assert arm.pose.position == pytest.approx((0.0, 0.0, 3.0))
    assert arm.joints.arrays()[0] == pytest.approx([0.0])
