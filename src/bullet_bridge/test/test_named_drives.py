"""Bases by their plugins' parameters: the wheels that are named turn as diameter, separation and
command say; odometry and transforms come where and as they are named."""

import pytest
from bullet_sim.pose import Pose
from fake_impl import FakeReceivedCounts, plugin_of, twist
from test_plugin_outputs import CART

GRAVITY = (0.0, 0.0, 0.0)  # wheels in the air: as fast as they are commanded
SIX = [f"{place}_{side}" for place in ("front", "mid", "rear") for side in ("left", "right")]
DIAMETER, SEPARATION, SPEED, YAW_RATE = 0.25, 0.5, 0.5, 0.4
NAMES = {  # library -> the parameters that name its joints, left and right by turns
    "gazebo_ros_diff_drive": ("leftJoint", "rightJoint"),
    "gazebo_ros_skid_steer_drive": (
        *("leftFrontJoint", "rightFrontJoint"),
        *("leftRearJoint", "rightRearJoint"),
    ),
    "diffdrive_plugin_6w": (
        *("frontLeftJoint", "frontRightJoint", "midLeftJoint", "midRightJoint"),
        *("rearLeftJoint", "rearRightJoint"),
    ),
    "diffdrive_plugin_multi_wheel": ("leftJoints", "rightJoints"),
}
COMMAND = {"diffdrive_plugin_6w": "topicName"}  # else commandTopic
TRANSFORMS = {  # library -> the parameter that lets it publish transforms
    "gazebo_ros_diff_drive": "publishOdomTF",
    "gazebo_ros_skid_steer_drive": "broadcastTF",
    "diffdrive_plugin_multi_wheel": "publishOdometryTf",
    "gazebo_ros_force_based_move": "publishOdometryTf",
}


def six_wheels():
    """A cart with six wheels."""
    start, end = CART.index('<link name="left_wheel">'), CART.index('<link name="right_wheel">')
    wheel = CART[start:end]
    wheels = (wheel.replace('"left', f'"{name}') for name in SIX)
    return f"{CART[:start]}{''.join(wheels)}</robot>"


def driven(world, topics, library, tags, seconds=0.5):
    """Drives a cart by a plugin; returns the wheels' speeds by joint, and where commands come."""
    content = "".join(f"<{tag}>{text}</{tag}>" for tag, text in tags.items())
    element = f'<gazebo><plugin name="p" filename="lib{library}.so">{content}</plugin></gazebo>'
    text = six_wheels().replace("</robot>", f"{element}</robot>")
    cart = world.spawn_urdf("cart", text, Pose((0.0, 0.0, 0.1)), str)
    (spec,) = cart.description.sensors
    received = FakeReceivedCounts()
    plugin = plugin_of(world, cart, spec, 1, received)
    plugin.prepare()
    received.take(twist(SPEED, YAW_RATE))
    while world.time < seconds:
        plugin.update(world.time, 0.0)
        world.step(10)
    return dict(cart.joints.state()[1]), received.topic


def tags_of(library, **more):
    """The parameters of a drive with all that can be named."""
    joints = dict(zip(NAMES.get(library, ()), SIX))
    command = COMMAND.get(library, "commandTopic")
    common = {"robotNamespace": "ns", command: "go", "wheelDiameter": DIAMETER}
    common.update(wheelSeparation=SEPARATION, torque=20, wheelTorque=20)
    common.update(odometryTopic="way", odometryFrame="start", robotBaseFrame="base")
    return {**common, **joints, **more}


@pytest.mark.parametrize("library", NAMES)
def test_named_wheels_turn_as_diameter_and_separation_say(world, topics, library):
    speeds, topic = driven(world, topics, library, tags_of(library))
    assert topic == "/ns/go"
    outer = SPEED + YAW_RATE * SEPARATION / 2, SPEED - YAW_RATE * SEPARATION / 2
    named = dict(zip(NAMES[library], SIX))
    for parameter, joint in named.items():
        wanted = outer["left" in joint] / (DIAMETER / 2)
        assert abs(speeds[joint]) == pytest.approx(wanted, rel=0.02), parameter
    others = [abs(speed) for joint, speed in speeds.items() if joint not in named.values()]
    assert max(others, default=0.0) < 0.5 * min(outer) / (DIAMETER / 2)


@pytest.mark.parametrize("library", ["gazebo_ros_diff_drive", "gazebo_ros_skid_steer_drive",
                                     "diffdrive_plugin_multi_wheel", "gazebo_ros_planar_move",
                                     "gazebo_ros_force_based_move"])  # fmt: skip
def test_odometry_comes_where_and_in_the_frames_that_are_named(world, topics, library):
    parameter = TRANSFORMS.get(library)
    for value in ("true", "false") if parameter else ("",):
        topics.clear()
        for name in list(world.models):
            world.delete(name)
        world.start_over()
        more = {parameter: value} if parameter else {}
        _, topic = driven(world, topics, library, tags_of(library, **more))
        assert topic == "/ns/go"
        message = topics["/ns/way"].messages[-1]
        assert message.header.frame_id.endswith("start") and message.child_frame_id.endswith("base")
        sent = "/tf" in topics and bool(topics["/tf"].messages)
        assert sent == (value != "false")
