"""Nodes of the car, the track, the truck and the pad print nothing when they end."""

import signal
import subprocess

import pytest
import testing

IMAGE, TRUCK = "/camera/image", "/cybertruck/joint_states"
TOPICS = {
    "/cmd_vel": "geometry_msgs/Twist",
    "/odom": "nav_msgs/Odometry",
    "/path": "nav_msgs/Path",
    "/camera_info": "sensor_msgs/CameraInfo",
    IMAGE: "sensor_msgs/Image",
    TRUCK: "sensor_msgs/JointState",
    "/joy": "sensor_msgs/Joy",
}
VALUES = (
    "poses=[__import__('geometry_msgs.msg').msg.PoseStamped(pose="
    "__import__('geometry_msgs.msg').msg.Pose(position=__import__('geometry_msgs.msg').msg.Point("
    "0.1 * n, 0.0, 0.0))) for n in range(9)]",
    "K=[50.0, 0.0, 32.0, 0.0, 50.0, 24.0, 0.0, 0.0, 1.0]",
    "encoding='bgr8'",
    "height=48",
    "width=64",
    "step=192",
    "data=bytes(48 * 192)",
    "child_frame_id='b'",
    "axes=[0.5] * 8",
    "buttons=[1] * 12",
)
NODES = {  # package, node -> topics that it hears, what else it publishes under another name
    ("deepracer_control", "control"): (["/cmd_vel"], None),
    ("deepracer_control", "pure_pursuit"): (["/odom", "/path"], "cmd_vel"),
    ("deepracer_control", "follow_line"): (["/camera_info", IMAGE], "cmd_vel"),
    ("track_model", "odom_tf"): (["/odom"], None),
    ("track_model", "referee"): (["/odom"], None),
    ("cybertruck", "drive"): ([TRUCK, "/cmd_vel"], "odom"),
    ("cybertruck", "goal"): (["/odom"], "cmd_vel"),
    ("cybertruck", "joystick"): (["/joy"], "cmd_vel"),
    ("cybertruck", "back_up"): (["/odom"], "cmd_vel"),
    ("joy", "joy_node"): ([], "joy"),
}


@pytest.fixture(scope="module")
def environment():
    with testing.ros_master() as environment:
        with testing.flood(environment, TOPICS, *VALUES):
            yield environment


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize("package, node", NODES)
def test_nodes_end_silently(environment, tmp_path, package, node, number):
    topics, published = NODES[package, node]
    testing.assert_clean_exit(
        testing.slow_close(tmp_path, environment),
        f"/{node}",
        [testing.executable(package, node), *([f"{published}:=out"] if published else [])],
        topics,
        number,
        stdin=subprocess.DEVNULL,
    )
