"""The car's nodes print nothing when they stop while messages arrive."""

import signal

import pytest
import testing

TOPICS = {
    "/cmd_vel": "geometry_msgs/Twist",
    "/odom": "nav_msgs/Odometry",
    "/path": "nav_msgs/Path",
    "/camera_info": "sensor_msgs/CameraInfo",
    "/camera/image": "sensor_msgs/Image",
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
)
NODES = {
    "control": ["/cmd_vel"],
    "pure_pursuit": ["/odom", "/path"],
    "follow_line": ["/camera_info", "/camera/image"],
}


@pytest.fixture(scope="module")
def environment():
    with testing.ros_master() as environment:
        with testing.flood(environment, TOPICS, *VALUES):
            yield environment


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize("node", NODES)
def test_nodes_stop_cleanly(environment, tmp_path, node, number):
    testing.assert_clean_exit(
        testing.slow_close(tmp_path, environment),
        f"/{node}",
        [
            testing.executable("deepracer_control", node),
            *(["cmd_vel:=out"] if node != "control" else []),
        ],
        NODES[node],
        number,
    )
