"""A node's XML-RPC thread stops with the node, whose socket it polls."""

import time

import pytest
from paddock_common.testing import wait_for
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
