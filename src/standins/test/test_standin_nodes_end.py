"""Stand-ins' nodes say nothing when they end while messages come."""

import signal

import pytest
import testing

TOPICS = {"/in": "geometry_msgs/Twist"}
SOURCES = "[{name: a, topic: in, timeout: 0.0, priority: 9}]"
NODES = {  # package/script -> name, topics, arguments
    "twist_mux/twist_mux": ("twist_mux", ["/in"], [f"_topics:={SOURCES}"]),
    "twist_mux/twist_marker": ("twist_marker", ["/in"], ["twist:=in"]),
    "twist_mux/joystick_relay.py": ("joystick_relay", ["/in"], ["joy_vel_in:=in"]),
    "joy/joy_node": ("joy_node", [], ["joy:=pad"]),
}


@pytest.fixture(scope="module")
def environment():
    with testing.ros_master() as environment:
        with testing.flood(environment, TOPICS):
            yield environment


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize("node", NODES)
def test_nodes_end_silently(environment, tmp_path, node, number):
    name, topics, arguments = NODES[node]
    testing.assert_clean_exit(
        testing.slow_close(tmp_path, environment),
        f"/{name}",
        [testing.executable(*node.split("/")), *arguments],
        topics,
        number,
    )
