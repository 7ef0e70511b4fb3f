"""Topics of a TurtleBot 2's base in ROS, with and without kobuki_msgs, without a ROS master."""

import genpy.dynamic
import pytest
import roslib.message
from bullet_sim.formats.sdf import world as sdf
from bullet_sim.pose import Pose
from fake_impl import FakeReceivedCounts, Topic, fake_publishers, plugin_of, twist
from test_kobuki import base

HEADER = "\n" + "=" * 80 + "\nMSG: std_msgs/Header\nuint32 seq\ntime stamp\nstring frame_id\n"
FIELDS = {
    "BumperEvent": "uint8 bumper\nuint8 state",
    "CliffEvent": "uint8 sensor\nuint8 state\nuint16 bottom",
    "WheelDropEvent": "uint8 wheel\nuint8 state",
    "SensorState": "Header header\nuint8 bumper\nuint8 wheel_drop\nuint8 cliff" + HEADER,
    "MotorPower": "uint8 state",
}  # those that the plugin writes and reads


@pytest.fixture(name="known")
def _known(monkeypatch):
    """Types of kobuki_msgs that there are, by their names; none at first."""
    known, real = {}, roslib.message.get_message_class
    monkeypatch.setattr(
        roslib.message,
        "get_message_class",
        lambda name: known.get(name) if name.startswith("kobuki_msgs/") else real(name),
    )
    return known


class Received(FakeReceivedCounts):
    """Keeps every topic's callback."""

    def __init__(self):
        self.takes = {}

    def subscribe(self, topic, kind, callback, **_options):
        self.takes[topic] = callback
        return Topic(topic, kind)


def driven(world, topics, received):
    """The plugin of a base that has been driven for half a second."""
    world.spawn(sdf.ground_plane())
    model = world.spawn_urdf("bot", base(robotNamespace="/"), Pose(), str)
    plugin = plugin_of(world, model, model.description.sensors[0], received=received)
    received.takes["/mobile_base/commands/velocity"](twist(0.2))
    for _ in range(500):
        world.step()
        plugin.update(world.time, 0.001)
    assert topics["/odom"].messages[-1].twist.twist.linear.x == pytest.approx(0.2, abs=0.01)
    return plugin


def test_without_kobuki_msgs_it_drives_and_says_what_is_missing(known, monkeypatch, world):
    topics, received, texts = fake_publishers(monkeypatch), Received(), []
    monkeypatch.setattr("rospy.logwarn", lambda text, *values: texts.append(text % values))
    plugin = driven(world, topics, received)
    [text] = texts
    assert "/mobile_base/events/bumper" in text and "/mobile_base/commands/motor_power" in text
    assert "'./run add kobuki_msgs' brings it" in text and "'k' of 'bot'" in text
    assert set(topics) == {"/odom", "/tf", "/joint_states", "/mobile_base/sensors/imu_data"}
    assert set(received.takes) == {
        "/mobile_base/commands/velocity", "/mobile_base/commands/reset_odometry"
    }  # fmt: skip
    plugin.close()


def test_with_kobuki_msgs_all_topics_are_there(known, monkeypatch, world):
    for name, fields in FIELDS.items():
        made = genpy.dynamic.generate_dynamic(f"kobuki_msgs/{name}", fields)
        known[f"kobuki_msgs/{name}"] = made[f"kobuki_msgs/{name}"]
    topics, received = fake_publishers(monkeypatch), Received()
    plugin = driven(world, topics, received)
    first = topics["/mobile_base/events/wheel_drop"].messages[:2]
    assert [(message.wheel, message.state) for message in first] == [(0, 1), (1, 1)]
    state = topics["/mobile_base/sensors/core"].messages[-1]
    assert (state.bumper, state.cliff, state.wheel_drop) == (0, 0, 0)
    assert state.header.frame_id == "base_link"
    assert state.header.stamp.to_sec() == pytest.approx(world.time)
    states = topics["/joint_states"].messages[-1]
    assert states.name == ["left_joint", "right_joint"] and list(states.effort) == [0.0, 0.0]
    imu = topics["/mobile_base/sensors/imu_data"].messages[-1]
    assert imu.angular_velocity_covariance[8] == 0.05
    received.takes["/mobile_base/commands/motor_power"](known["kobuki_msgs/MotorPower"](0))
    plugin.update(world.time, 0.001)
    assert plugin._command == (0.0, 0.0)
    plugin.close()
