"""The truck's nodes say nothing when they end while messages come."""

import signal
import subprocess

import pytest
import testing

TOPICS = {
    "/cybertruck/joint_states": "sensor_msgs/JointState",
    "/cmd_vel": "geometry_msgs/Twist",
    "/odom": "nav_msgs/Odometry",
    "/joy": "sensor_msgs/Joy",
}
NODES = {
    "drive": ["/cybertruck/joint_states", "/cmd_vel"],
    "goal": ["/odom"],
    "joystick": ["/joy"],
    "back_up": ["/odom"],
}


@pytest.fixture(scope="module")
def environment():
    with testing.ros_master() as environment:
        with testing.flood(environment, TOPICS, "axes=[0.5] * 8", "buttons=[1] * 12"):
            yield environment


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize("node", NODES)
def test_nodes_end_silently(environment, tmp_path, node, number):
    testing.assert_clean_exit(
        testing.slow_close(tmp_path, environment),
        f"/{node}",
        [
            testing.executable("cybertruck", node),
            *(["cmd_vel:=out"] if node != "drive" else ["odom:=out"]),
        ],
        NODES[node],
        number,
        stdin=subprocess.DEVNULL,
    )
