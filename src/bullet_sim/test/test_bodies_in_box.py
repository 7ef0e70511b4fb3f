"""Which bodies may be in a box: the question that spares a lidar half of its rays."""

import pytest
from bullet_sim.formats.sdf import world as sdf
from bullet_sim.pose import Pose
from bullet_sim.world import World

BOX = (
    '<sdf version="1.6"><model name="box"><static>true</static><link name="l"><collision '
    'name="c"><geometry><box><size>1 1 1</size></box></geometry></collision></link></model></sdf>'
)


@pytest.fixture
def world():
    made = World()
    made.spawn(sdf.ground_plane())
    made.spawn_sdf("box", BOX, Pose((3.0, 0.0, 0.5)), str)
    yield made
    made.close()


@pytest.mark.parametrize(
    "low, high, names",
    [
        ((-0.9, -0.9, 0.1), (0.9, 0.9, 1.9), []),  # above the ground, far from the box
        ((-1.1, -1.1, -0.1), (1.1, 1.1, 2.1), ["ground_plane"]),
        ((1.4, -0.6, 0.1), (2.6, 0.6, 1.2), ["box"]),
        ((1.4, -0.6, -0.2), (2.6, 0.6, 0.9), ["box", "ground_plane"]),
        ((2.9, -0.1, 1.1), (3.1, 0.1, 1.3), []),
        ((-3.0, -3.0, -5.0), (-2.0, -2.0, -4.0), ["ground_plane"]),  # deep below
    ],
)
def test_bodies_in_box(world, low, high, names):
    bodies = world.engine.bodies_in_box(low, high)
    assert sorted(name for name, model in world.models.items() if model.body in bodies) == names


@pytest.mark.parametrize("tilt, names", [(0.0, []), (0.1, []), (0.4, ["slope"])])
def test_a_tilted_plane_counts_where_it_reaches(tilt, names):
    world = World()
    text = BOX.replace("box", "slope").replace(
        "<slope><size>1 1 1</size></slope>", "<plane><normal>0 0 1</normal></plane>"
    )
    world.spawn_sdf("slope", text, Pose.from_xyz_rpy((0, 0, 0), (tilt, 0, 0)), str)
    bodies = world.engine.bodies_in_box((-1.0, -1.0, 0.3), (1.0, 1.0, 0.35))
    assert sorted(name for name, model in world.models.items() if model.body in bodies) == names
    world.close()


def test_after_a_reset_and_a_move(world):
    above = (2.75, -0.25, 0.95), (3.25, 0.25, 1.45)
    assert world.engine.bodies_in_box(*above) == {world.model("box").body}
    world.model("box").set_state(Pose((8.0, 0.0, 0.5)))
    world.step(2)
    assert world.engine.bodies_in_box(*above) == set()
    world.delete("box")
    world.reset()
    assert world.engine.bodies_in_box((-0.2, -0.2, -0.1), (0.2, 0.2, 0.4)) == {
        world.model("ground_plane").body
    }
