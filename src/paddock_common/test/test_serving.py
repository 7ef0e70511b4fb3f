"""A node's XML-RPC thread ends with the node, whose socket it polls."""

import time

import pytest
from rosgraph.xmlrpc import XmlRpcHandler, XmlRpcNode

from paddock_common import nodes

LIMIT, QUIET = 10.0, 0.8  # [s]; it polls for 0.5 s at a time


@pytest.fixture
def node():
    """A node with a server that runs."""
    node = XmlRpcNode(0, XmlRpcHandler())
    node.start()
    deadline = time.monotonic() + LIMIT
    while not node.uri:
        assert time.monotonic() < deadline
        time.sleep(0.01)
    return node


def test_thread_does_not_poll_closed_socket(node, monkeypatch):
    """After a shutdown it looks at nothing any more."""
    monkeypatch.setattr(XmlRpcNode, "shutdown", XmlRpcNode.shutdown)  # put back at the end
    nodes.end_with_node()
    looks = []
    node.server.service_actions = lambda: looks.append(1)
    node.shutdown("test")
    deadline = time.monotonic() + LIMIT
    while True:
        before = len(looks)
        time.sleep(QUIET)
        if len(looks) == before:
            return
        assert time.monotonic() < deadline, f"{len(looks)} looks at a closed socket"


def test_shutdown_before_start():
    """A node that has not served yet can be shut down."""
    nodes._shutdown(XmlRpcNode(0, XmlRpcHandler()), "test")
