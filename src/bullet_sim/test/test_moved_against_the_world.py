"""Models that a joint moves against the world, and are moved: as Gazebo 11.1 has them."""

import pytest
from bullet_sim.pose import Pose

INERTIAL = (
    "<inertial><mass>2</mass><inertia><ixx>0.1</ixx><iyy>0.1</iyy><izz>0.1</izz></inertia>"
    "</inertial>"
)
DOOR = (
    '<model name="door"><pose>0 0 1 0 0 0</pose><link name="leaf"><pose>0.5 0 0 0 0 0</pose>'
    f"{INERTIAL}</link><joint name='hinge' type='revolute'><pose>-0.5 0 0 0 0 0</pose>"
    "<parent>world</parent><child>leaf</child><axis><xyz>0 0 1</xyz>"
    "<dynamics><damping>0.5</damping></dynamics></axis></joint></model>"
)
GATE = (
    f'<model name="gate"><pose>5 0 1 0 0 0</pose><link name="leaf">{INERTIAL}</link>'
    "<joint name='slide' type='prismatic'><parent>world</parent><child>leaf</child><axis>"
    "<xyz>1 0 0</xyz><limit><lower>-1</lower><upper>1</upper></limit>"
    "<dynamics><damping>5</damping></dynamics></axis></joint></model>"
)
WORLD = {"gravity": (0.0, 0.0, -9.8)}


def spawned(world, text):
    return world.spawn_sdf("bot", f'<sdf version="1.6">{text}</sdf>', Pose(), str)


def test_its_links_are_those_that_it_has(world):
    assert spawned(world, GATE).bodies == ("leaf",)


def test_joints_pull_it_back_to_where_they_are(world):
    gate = spawned(world, GATE)
    world.step(10)
    gate.set_state(Pose((6.0, 0.5, 1.0)))
    assert gate.pose.position == pytest.approx((6.0, 0.5, 1.0), abs=1e-9)
    for steps, y, speed in ((1, 0.4, -100.0), (9, 0.0537, -13.422), (90, 0.0, 0.0)):
        world.step(steps)
        position, _, linear, _ = gate.motion()
        assert position == pytest.approx((6.0, y, 1.0), abs=1e-4)
        assert linear[1] == pytest.approx(speed, abs=0.01)
    assert gate.joints.state()[0]["slide"] == pytest.approx(1.0, abs=1e-6)


def test_a_model_goes_with_its_first_link(world):
    door = spawned(world, DOOR)
    world.step(1000)
    door.set_state(Pose((1.0, 0.5, 1.0)))
    world.step(1)
    pose, (leaf, _, linear) = door.pose, (*door.link_state("leaf")[:2], door.motion()[2])
    assert pose.position == pytest.approx((0.8069, 0.4006, 1.0), abs=1e-4)
    assert pose.rpy[2] == pytest.approx(0.1663, abs=1e-3)
    assert leaf.position == pytest.approx((1.3, 0.4833, 1.0), abs=1e-4)
    assert linear[:2] == pytest.approx((100.0, -16.667), abs=0.01)
    assert door.joints.state()[0]["hinge"] == pytest.approx(0.1663, abs=1e-4)


def test_a_swinging_models_frame_turns(world):
    door = spawned(world, DOOR)
    door.joints.set_positions({"hinge": 0.4})
    world.step(1)
    assert door.pose.position == pytest.approx((0.0, 0.0, 1.0), abs=1e-6)
    assert door.pose.rpy[2] == pytest.approx(0.4, abs=1e-6)
