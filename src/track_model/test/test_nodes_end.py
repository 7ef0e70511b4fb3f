"""Nodes of the track print nothing when they stop while messages arrive."""

import signal

import pytest
import testing

NODES = {"odom_tf": ["/odom"], "referee": ["/odom"]}


@pytest.fixture(scope="module")
def environment():
    with testing.ros_master() as environment:
        with testing.flood(environment, {"/odom": "nav_msgs/Odometry"}, "child_frame_id='b'"):
            yield environment


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize("node", NODES)
def test_nodes_stop_cleanly(environment, tmp_path, node, number):
    testing.assert_clean_exit(
        testing.slow_close(tmp_path, environment),
        f"/{node}",
        [testing.executable("track_model", node)],
        NODES[node],
        number,
    )
