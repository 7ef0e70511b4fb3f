"""Which bodies may be near a point: the question that spares a lidar half of its rays."""
import pytest

from bullet_sim import sdf
from bullet_sim.pose import Pose
from bullet_sim.world import World

BOX = ('<sdf version="1.6"><model name="box"><static>true</static><link name="l"><collision '
       'name="c"><geometry><box><size>1 1 1</size></box></geometry></collision></link></model></sdf>')


@pytest.fixture
def world():
    made = World()
    made.spawn(sdf.ground_plane())
    made.spawn_sdf('box', BOX, Pose((3.0, 0.0, 0.5)), str)
    yield made
    made.close()


@pytest.mark.parametrize('point, radius, names', [
    ((0.0, 0.0, 1.0), 0.9, []),                 # above the ground, far from the box
    ((0.0, 0.0, 1.0), 1.1, ['ground_plane']),
    ((2.0, 0.0, 0.6), 0.55, ['box']),           # half a metre from its side
    ((2.0, 0.0, 0.3), 0.55, ['box', 'ground_plane']),
    ((3.0, 0.0, 1.2), 0.1, []),
])
def test_bodies_near(world, point, radius, names):
    bodies = world.engine.bodies_near(point, radius)
    assert sorted(name for name, model in world.models.items() if model.body in bodies) == names


def test_after_a_reset_and_a_move(world):
    assert world.engine.bodies_near((3.0, 0.0, 1.2), 0.25) == {world.model('box').body}
    world.model('box').set_state(Pose((8.0, 0.0, 0.5)))
    world.step(2)
    assert world.engine.bodies_near((3.0, 0.0, 1.2), 0.25) == set()
    world.delete('box')
    world.reset()
    assert world.engine.bodies_near((0.0, 0.0, 0.2), 0.25) == {world.model('ground_plane').body}
