"""Joints that close loops; that they move as in Gazebo is in test_gazebo_states.py."""

import gazebo_states
import numpy as np
import pytest
from bullet_sim.sensors.inertial import joint_wrench
from bullet_sim.sensors.scenes import body_fields
from urdf_texts import link

from bullet_sim import Pose, World

RING = f'<sdf version="1.6"><model name="m">{gazebo_states.MODELS["four bars"][0]}</model></sdf>'
JOINTS = ("low", "high", "other", "ring")
LINK = link("{}", inertia=0.01)
HINGE = (
    '<joint name="{0}_joint" type="continuous"><parent link="a"/><child link="{0}"/>'
    '<axis xyz="0 1 0"/></joint>'
)


def spawned(text, solver="ode"):
    """A world with a model of an SDF."""
    world = World(solver=solver)
    return world, world.spawn_sdf("m", text, Pose(), str)


def of_urdf(inside):
    """A model of three links, with this within <gazebo>."""
    links = "".join(map(LINK.format, "abc")) + HINGE.format("b") + HINGE.format("c")
    world = World()
    text = f'<robot name="m">{links}<gazebo>{inside}</gazebo></robot>'
    return world, world.spawn_urdf("m", text, Pose((0.0, 0.0, 1.0)), str)


def gap(model):
    """Distance [m] of the ring's place in the two links that it joins."""
    pose, other = model.link_state("coupler")[0], model.link_state("rocker")[0]
    start = [Pose.from_xyz_rpy((0.0, 0.1, 1.2), (0, 0.1, 0)) * Pose((0.5, 0.0, 0.05))]
    start.append(Pose.from_xyz_rpy((0.5, 0.1, 0.9), (0, 0.2, 0)).inverse() * start[0])
    places = (pose * Pose((0.5, 0.0, 0.05))).position, (other * start[1]).position
    return float(np.linalg.norm(np.subtract(*places)))


def test_all_joints_are_there_and_hold():
    world, model = spawned(RING)
    assert model.joints.names == JOINTS and not model.description.warnings
    world.step(300)
    positions = dict(zip(JOINTS, model.joints.arrays()[0]))
    assert positions["low"] > 0.1
    assert positions["low"] + positions["high"] == pytest.approx(
        positions["other"] + positions["ring"], abs=1e-5
    )
    assert gap(model) < 1e-5
    world.close()


def test_a_motor_moves_the_ring_by_the_joint_that_closes_it():
    world, model = spawned(RING)
    for _ in range(300):
        model.joints.set_motor("ring", 0.3, 20.0)
        world.step()
    assert model.joints.arrays()[1][3] == pytest.approx(0.3, abs=1e-3)
    assert gap(model) < 1e-4
    world.close()


def test_a_state_is_kept_and_restored():
    world, model = spawned(RING)
    world.step(100)
    saved, before = world.save_state(), model.joints.arrays()[0].copy()
    world.step(100)
    after = model.joints.arrays()[0].copy()
    world.restore_state(saved)
    assert (model.joints.arrays()[0] == before).all()
    world.step(100)
    assert (model.joints.arrays()[0] == after).all()
    world.close()


def test_what_is_in_a_loop_is_not_put_to_a_position():
    """As Gazebo's Joint::SetPosition, which finds no links to move."""
    world, model = spawned(RING)
    places = [model.link_state(link)[0] for link in ("crank", "coupler", "rocker")]
    number = model.joints.names.index("low")
    model.body.motor(model.body.joints[number]).impose_position(0.5, 1e9, 1e9)
    world.step()
    for name, place in zip(("crank", "coupler", "rocker"), places):
        now = model.link_state(name)[0]
        assert now.position == pytest.approx(place.position, abs=1e-3)
    world.close()


def test_its_load_is_measured():
    """Two arms hold each other; each joint has its own load."""
    world = World()
    description = gazebo_states.MODELS["two arms and a fixed joint"][0]
    text = f'<sdf version="1.6"><model name="m">{description}</model></sdf>'
    text = text.replace("</model>", sensor("weld") + sensor("left") + "</model>")
    model = world.spawn_sdf("m", text, Pose(), str)
    world.step(200)
    (force, _), (other, _) = (joint_wrench(model, name) for name in ("weld", "left"))
    assert np.linalg.norm(force - other) > 1.0
    world.close()


def sensor(joint):
    """A plugin that measures a joint."""
    return (
        f'<plugin name="{joint}" filename="libgazebo_ros_ft_sensor.so"><jointName>{joint}'
        f"</jointName><topicName>{joint}</topicName></plugin>"
    )


@pytest.mark.parametrize("name", ["four bars", "a screw", "links without joints"])
def test_pages_and_recorders_have_its_links(name):
    world, model = spawned(
        f'<sdf version="1.6"><model name="m">{gazebo_states.MODELS[name][0]}</model></sdf>'
    )
    fields = body_fields(model)
    moving = [link for link in fields["links"] if link["kind"] != "fixed"]
    assert len(fields["state"]) == 8 + len(moving)
    assert [part["joint"] for part in moving if part["joint"]] == list(model.joints.names)
    for frame, (row, *_) in fields["frames"].items():
        assert fields["links"][row]["name"] == frame
    world.close()


def test_with_bullet_it_is_left_out_with_a_warning():
    world, model = spawned(RING, solver="bullet")
    assert model.joints.names == JOINTS[:3]
    (warning,) = model.description.warnings
    assert "joint 'ring' of 'm' closes a loop at link 'coupler'" in warning
    world.close()


def test_a_static_one_stands():
    text = RING.replace('<model name="m">', '<model name="m"><static>1</static>')
    world, model = spawned(text)
    world.step(10)
    assert model.link_state("rocker")[0].position == pytest.approx((0.5, 0.1, 0.9), abs=1e-9)
    world.close()


def test_a_joint_within_gazebo_closes_a_loop_of_a_urdf():
    world, model = of_urdf(
        '<joint name="k" type="fixed"><parent>b</parent><child>c</child></joint>'
    )
    assert not model.description.warnings
    assert set(model.description.joints) == {"b_joint", "c_joint", "k"}
    for _ in range(200):
        model.joints.add_effort("b_joint", 0.2)
        world.step()
    one, two = model.joints.arrays()[0]
    assert one > 0.1 and one == pytest.approx(two, abs=1e-6)
    world.close()


def test_a_urdf_is_fixed_to_the_world_by_a_joint_within_gazebo():
    world, model = of_urdf(
        '<joint name="k" type="fixed"><parent>world</parent><child>a</child></joint>'
    )
    world.step(200)
    assert model.link_state("a")[0].position == pytest.approx((0.0, 0.0, 1.0), abs=1e-6)
    world.close()


@pytest.mark.parametrize(
    "parent, child, kind, words",
    [
        ("world", "b", "fixed", ("joins 'b' to the world", "of 'a'")),
        ("world", "a", "revolute", ("joins 'a' to the world",)),
        ("nothing", "b", "revolute", ("joins 'nothing' and 'b'", "links are a, b, c")),
        ("b", "b", "revolute", ("joins 'b' to itself",)),
    ],
)
def test_what_a_joint_within_gazebo_cannot_be(parent, child, kind, words):
    world, model = of_urdf(
        f'<joint name="k" type="{kind}"><parent>{parent}</parent><child>{child}</child></joint>'
    )
    (warning,) = model.description.warnings
    assert "joint 'k'" in warning and "left out" in warning
    for word in words:
        assert word in warning
    assert "k" not in model.description.joints
    world.close()
