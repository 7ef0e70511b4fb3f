"""A node's threads that serve others: they stop with it, nothing stays of it at the master, and
what is not ROS does not stop them."""

import contextlib
import socket
import subprocess
import sys
import time
from urllib.parse import urlsplit

import pytest
from rosgraph.xmlrpc import XmlRpcHandler, XmlRpcNode
from testing import call, ros_master, running, wait_for

from paddock_common import inbound, nodes

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
from paddock_common import inbound, nodes
nodes.init_interruptible("server")
rospy.logwarn("for /rosout")
rospy.Service("serve", Empty, lambda _: EmptyResponse())
rospy.spin()
"""
CALLS = """
import time, rospy
from std_srvs.srv import Empty
rospy.wait_for_service("/serve", 20.0)
begin = time.monotonic()
rospy.ServiceProxy("/serve", Empty)()
print(time.monotonic() - begin)
"""


@contextlib.contextmanager
def serving(files=None):
    """(environment, process, address) of a node with a service and at most `files` open files."""
    limit = "" if files is None else f"import resource as r; r.setrlimit(7, ({files}, {files}))\n"
    with ros_master() as environment:
        with running(environment, [sys.executable, "-c", limit + SERVES]) as server:
            uri = environment["ROS_MASTER_URI"]
            service = wait_for(lambda: call(uri, "lookupService", "/serve"), "the service")
            address = urlsplit(service)
            yield environment, server, (address.hostname, address.port)


def call_serve(environment):
    """Calls the service from a process of its own; the time that the call itself took [s]."""
    client = [sys.executable, "-c", CALLS]
    done = subprocess.run(client, env=environment, timeout=60.0, check=True, capture_output=True)
    return float(done.stdout)


BEGINNINGS = (b"", b"d\0\0\0", b"d\0\0\0half", b"\0\0\1\0" + b"x" * 4000, b"POST /RPC2 HTTP/1.1")


def test_connections_without_a_header_keep_nobody_out():
    """Each kept all others out for 5 s, one after the other, or for as long as it was open."""
    with serving() as (environment, _, address), contextlib.ExitStack() as held:
        for begin in 40 * BEGINNINGS:  # more than may wait for their header
            last = held.enter_context(socket.create_connection(address))
            last.sendall(begin)
        assert call_serve(environment) < 2.0
        last.settimeout(inbound.HEADER_TIMEOUT + LIMIT)
        with contextlib.suppress(ConnectionResetError):
            assert last.recv(1) == b"", "it is closed in the end"
        assert call_serve(environment) < 2.0


def test_a_header_may_come_in_parts():
    with serving() as (_, _, address), socket.create_connection(address) as client:
        fields = [b"callerid=/x", b"service=/serve", b"md5sum=*"]
        text = b"".join(len(field).to_bytes(4, "little") + field for field in fields)
        for byte in len(text).to_bytes(4, "little") + text:
            client.sendall(bytes([byte]))
            time.sleep(0.001)
        client.settimeout(LIMIT)
        assert b"std_srvs/Empty" in client.recv(4096)


def test_at_the_limit_of_open_files_a_node_serves_again_when_others_have_left():
    """accept() failed, its thread ended, and the node was deaf for ever."""
    with serving(files=160) as (environment, server, address):
        held = [socket.create_connection(address) for _ in range(300)]
        time.sleep(1.0)
        assert call(environment["ROS_MASTER_URI"], "getPid")
        for connection in held:
            connection.close()
        assert call_serve(environment) < 10.0
        server.terminate()
        text = server.communicate(timeout=60.0)[0]
        assert "may have 160 open files (ulimit -n)" in text
        assert text.count("ulimit -n") < 5


def test_the_soft_limit_of_open_files_is_raised():
    script = (
        "import resource as r; r.setrlimit(7, (256, 5000))\n"
        "from paddock_common import open_files\n"
        "open_files.raise_limit(); print(r.getrlimit(7))"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    assert done.stdout == "(5000, 5000)\n", done.stderr


def test_a_node_that_has_ended_is_forgotten_and_post_does_not_stop_one():
    """The master asks the old address of a node that it still knows to shut down, by HTTP.

    Whoever has that port by then waits for the rest of a header of 1.4 GB.
    """
    with serving() as (environment, server, address):
        master = environment["ROS_MASTER_URI"]
        with socket.create_connection(address) as other:
            other.sendall(b"POST /RPC2 HTTP/1.1\r\nHost: here\r\n\r\n")
            call_serve(environment)
        assert call(master, "lookupNode", "/server")
        server.terminate()
        server.communicate(timeout=60.0)
        assert call(master, "getPid") and call(master, "lookupNode", "/server") is None
