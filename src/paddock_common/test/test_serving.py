"""A node's threads that serve others: they stop with it, nothing stays of it at the master, and
what is not ROS does not stop them."""

import socket
import subprocess
import sys
import time
from urllib.parse import urlsplit

import pytest
from paddock_common.testing import call, ros_master, running, wait_for
from rosgraph.xmlrpc import XmlRpcHandler, XmlRpcNode

from paddock_common import nodes

LIMIT, IDLE = 10.0, 0.8  # [s]; it polls for 0.5 s at a time


@pytest.fixture
def node():
    node = XmlRpcNode(0, XmlRpcHandler())
    node.start()
    wait_for(lambda: node.uri, "the node's address")
    return node


def test_thread_does_not_poll_closed_socket(node, monkeypatch):
    """After a shutdown it polls nothing."""
    monkeypatch.setattr(XmlRpcNode, "shutdown", XmlRpcNode.shutdown)  # restored at the end
    nodes.close_server_with_node()
    polls = []
    node.server.service_actions = lambda: polls.append(1)
    node.shutdown("test")
    deadline = time.monotonic() + LIMIT
    while True:
        before = len(polls)
        time.sleep(IDLE)
        if len(polls) == before:
            return
        assert time.monotonic() < deadline, f"{len(polls)} polls of a closed socket"


def test_shutdown_before_start():
    """A node that has not served yet can be shut down."""
    nodes._shutdown(XmlRpcNode(0, XmlRpcHandler()), "test")


SERVES = """
import rospy
from std_srvs.srv import Empty, EmptyResponse
from paddock_common import nodes
nodes.init_interruptible("server")
rospy.logwarn("for /rosout")
rospy.Service("serve", Empty, lambda _: EmptyResponse())
rospy.spin()
"""
CALLS = """
import rospy
from std_srvs.srv import Empty
rospy.wait_for_service("/serve", 20.0)
rospy.ServiceProxy("/serve", Empty)()
"""


def test_a_node_that_has_ended_is_forgotten_and_post_does_not_stop_one():
    """The master asks the old address of a node that it still knows to shut down, by HTTP.

    Whoever has that port by then waits for the rest of a header of 1.4 GB.
    """
    with ros_master() as environment:
        with running(environment, [sys.executable, "-c", SERVES]) as server:
            master = environment["ROS_MASTER_URI"]
            found = wait_for(lambda: call(master, "lookupService", "/serve"), "the service")
            address = urlsplit(found)
            with socket.create_connection((address.hostname, address.port)) as other:
                other.sendall(b"POST /RPC2 HTTP/1.1\r\nHost: here\r\n\r\n")
                client = [sys.executable, "-c", CALLS]
                subprocess.run(client, env=environment, timeout=60.0, check=True)
            assert call(master, "lookupNode", "/server")
            server.terminate()
            server.communicate(timeout=60.0)
            assert call(master, "getPid") and call(master, "lookupNode", "/server") is None
