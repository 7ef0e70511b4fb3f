"""hector's servos and its message of resets, without a ROS master."""

import math

import pytest
from bullet_bridge.plugins import base
from bullet_sim.formats.urdf import parse_urdf
from bullet_sim.plugins.servos import ServoSpec, euler
from bullet_sim.pose import Pose, multiply
from fake_impl import fake_publishers, plugin_of
from geometry_msgs.msg import Quaternion, QuaternionStamped
from std_msgs.msg import Header
from urdf_texts import link

GRAVITY = (0.0, 0.0, 0.0)

LINK = link("{}", inertia=0.01)
JOINT = (
    '<joint name="{0}" type="revolute"><parent link="{1}"/><child link="{0}_link"/><axis '
    'xyz="{2}"/><limit lower="-2" upper="2" effort="1" velocity="9"/></joint>'
)
PLUGIN = '<gazebo><plugin name="p" filename="libhector_{}.so">{}</plugin></gazebo>'
TAGS = (
    "<firstServoName>yaw</firstServoName><firstServoAxis>0 0 1</firstServoAxis>"
    "<secondServoName>pitch</secondServoName><secondServoAxis>0 1 0</secondServoAxis>"
)


def robot(tags, library="servo_plugin"):
    links = "".join(map(LINK.format, ("base", "yaw_link", "pitch_link")))
    joints = JOINT.format("yaw", "base", "0 0 1") + JOINT.format("pitch", "yaw_link", "0 1 0")
    return f'<robot name="r">{links}{joints}{PLUGIN.format(library, tags)}</robot>'


@pytest.fixture(name="topics")
def _topics(monkeypatch):
    monkeypatch.setattr(base.RosPart, "transforms", lambda _: None)
    return fake_publishers(monkeypatch)


def about(axis, angle):
    """Quaternion of a turn about an axis, x, y or z."""
    place = ["xyz".index(axis) == number for number in range(3)]
    return (*(math.sin(angle / 2) * one for one in place), math.cos(angle / 2))


@pytest.mark.parametrize("convention", ["zyx", "xyz"])
def test_angles_are_those_of_turns_about_the_axes(convention):
    turns = (0.3, -0.4, 0.5)
    one, two, three = (about(axis, angle) for axis, angle in zip(convention, turns))
    found = euler(multiply(multiply(one, two), three), convention)
    assert found == pytest.approx(turns)


def test_a_servos_parameters():
    (spec,) = parse_urdf(robot(TAGS), str).sensors
    assert spec == ServoSpec("p", "base", ("yaw", "pitch"), "zyx", (0, 1))
    more = (
        "<robotNamespace>bot</robotNamespace><topicName>head</topicName><jointStateName>states"
        "</jointStateName><proportionalControllerGain>2</proportionalControllerGain>"
        "<derivativeControllerGain>0.1</derivativeControllerGain><maxVelocity>1</maxVelocity>"
        "<controlRate>50</controlRate><torque>3</torque>"
    )
    (spec,) = parse_urdf(robot(TAGS + more), str).sensors
    assert spec == ServoSpec(
        "p", "base", ("yaw", "pitch"), "zyx", (0, 1), 2.0, 0.1, 1.0, 50.0, "/bot/head",
        "/bot/states",
    )  # fmt: skip
    one = parse_urdf(robot(TAGS.replace("first", "third").replace("second", "first")), str)
    assert one.sensors == [] and "it is left out" in one.warnings[-1], "upstream: an exception"
    alone = TAGS[TAGS.index("<second") :].replace("second", "first")
    (spec,) = parse_urdf(robot(alone), str).sensors
    assert (spec.joints, spec.convention, spec.angles) == (("pitch",), "xyz", (1,))
    wrong = parse_urdf(robot(TAGS.replace("0 1 0", "0 0 1")), str)
    assert wrong.sensors == [] and "axes 'zz'" in wrong.warnings[-1]


def test_servos_turn_to_the_orientation_in_the_base(topics, world, monkeypatch):
    model = world.spawn_urdf("r", robot(TAGS + "<maxVelocity>1</maxVelocity>"), Pose(), str)
    plugin = plugin_of(world, model, model.description.sensors[0])
    wanted = multiply(about("z", 0.8), about("y", -0.3))
    asked = []

    def in_base():
        frame, orientation = plugin._command
        asked.append(frame)
        return None if frame == "base_stabilized" else orientation

    monkeypatch.setattr(plugin, "_in_base", in_base)
    plugin.update(world.time, 0.0)
    world.step(10)
    assert model.joints.state()[1] == {"yaw": 0.0, "pitch": 0.0}, "there is no such transform"
    plugin._on_command(QuaternionStamped(Header(frame_id="base_link"), Quaternion(*wanted)))
    speeds = []
    for _ in range(1500):
        plugin.update(world.time, 0.0)
        world.step()
        speeds.append(model.joints.state()[1]["yaw"])
    positions = model.joints.state()[0]
    assert positions == pytest.approx({"yaw": 0.8, "pitch": -0.3}, abs=0.01)
    assert max(speeds) == pytest.approx(1.0, abs=0.01), "its greatest velocity"
    message = topics["/joint_states"].messages[-1]
    assert message.name == ["yaw", "pitch"] and message.header.frame_id == "base"
    assert message.position == pytest.approx([0.8, -0.3], abs=0.01)
    assert asked[0] == "base_stabilized"
    plugin.reset(world.time)
    assert plugin._command[0] == "base_stabilized"


def test_a_reset_is_told(topics, world):
    model = world.spawn_urdf("r", robot("", "gazebo_reset_plugin"), Pose(), str)
    plugin = plugin_of(world, model, model.description.sensors[0])
    assert topics["/syscommand"].messages == []
    plugin.reset(1.0)
    assert [message.data for message in topics["/syscommand"].messages] == ["reset"]
