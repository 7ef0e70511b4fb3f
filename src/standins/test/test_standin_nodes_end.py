"""Stand-ins' nodes say nothing when they end while messages come."""

import os
import pty
import signal

import pytest
import testing

TOPICS = {
    "/in": "geometry_msgs/Twist",
    "/joy": "sensor_msgs/Joy",
    "/odom": "nav_msgs/Odometry",
    "/fix": "sensor_msgs/NavSatFix",
    "/imu": "sensor_msgs/Imu",
    "/marker_server/feedback": "visualization_msgs/InteractiveMarkerFeedback",
}
VALUES = (
    "axes=[0.5] * 8",
    "buttons=[1] * 12",
    "child_frame_id='base_link'",
    "client_id='rviz'",
    "marker_name='robot_twist_marker'",
    "event_type=1",
    "latitude=49.0",
    "longitude=8.0",
)
SOURCES = "[{name: a, topic: in, timeout: 0.0, priority: 9}]"
YES = str([number in (0, 1, 5, 6, 7, 11) for number in range(15)]).lower()
NODES = {  # package/script -> name, topics, arguments
    "twist_mux/twist_mux": ("twist_mux", ["/in"], [f"_topics:={SOURCES}"]),
    "twist_mux/twist_marker": ("twist_marker", ["/in"], ["twist:=in"]),
    "twist_mux/joystick_relay.py": ("joystick_relay", ["/in"], ["joy_vel_in:=in"]),
    "teleop_twist_joy/teleop_node": ("teleop_twist_joy_node", ["/joy"], ["_enable_button:=0"]),
    "interactive_marker_twist_server/marker_server": (
        "marker_server",
        ["/marker_server/feedback"],
        ["twist_marker_server/feedback:=/marker_server/feedback"],
    ),
    "robot_localization/ekf_localization_node": (
        "ekf_localization_node",
        ["/odom"],
        ["_odom0:=/odom", f"_odom0_config:={YES}", "_print_diagnostics:=true"],
    ),
    "robot_localization/navsat_transform_node": (
        "navsat_transform_node",
        ["/odom", "/fix"],
        ["odometry/filtered:=/odom", "gps/fix:=/fix", "imu/data:=/imu"],
    ),
    "joy/joy_node": ("joy_node", [], ["joy:=pad"]),
    "teleop_twist_keyboard/teleop_twist_keyboard.py": (
        "teleop_twist_keyboard",
        [],
        ["_repeat_rate:=500.0"],
    ),
}


@pytest.fixture(scope="module")
def environment():
    with testing.ros_master() as environment:
        with testing.flood(environment, TOPICS, *VALUES):
            yield environment


@pytest.fixture
def terminal():
    """A descriptor of a terminal that nobody types in."""
    ours, theirs = pty.openpty()
    yield theirs
    os.close(ours)
    os.close(theirs)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize("node", NODES)
def test_nodes_end_silently(environment, tmp_path, terminal, node, number):
    name, topics, arguments = NODES[node]
    testing.assert_clean_exit(
        testing.slow_close(tmp_path, environment),
        f"/{name}",
        [testing.executable(*node.split("/")), *arguments],
        topics,
        number,
        stdin=terminal,
    )
