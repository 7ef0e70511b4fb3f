"""A node's threads that serve others: they stop with it, nothing stays of it at the master, and
what is not ROS does not stop them."""

import contextlib
import http.client
import io
import socket
import subprocess
import sys
import time
from urllib.parse import urlsplit

import pytest
from rosgraph.xmlrpc import XmlRpcHandler, XmlRpcNode
from rospy.exceptions import TransportException, TransportTerminated
from rospy.impl.tcpros_base import TCPROSTransport, TCPROSTransportProtocol
from sensor_msgs.msg import Image
from std_msgs.msg import Bool
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
import time
import rospy
from std_srvs.srv import Empty, EmptyResponse, SetBool
from paddock_common import inbound, nodes
nodes.init_interruptible("server")
rospy.logwarn("for /rosout")
rospy.Service("set", SetBool, lambda _: time.sleep(0.5) or (True, ""))
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


def header_of(caller, service):
    """The header of a service's client, as bytes."""
    fields = [f"callerid={caller}".encode(), f"service={service}".encode(), b"md5sum=*"]
    text = b"".join(len(field).to_bytes(4, "little") + field for field in fields)
    return len(text).to_bytes(4, "little") + text


def test_a_header_may_come_in_parts():
    with serving() as (_, _, address), socket.create_connection(address) as client:
        for byte in header_of("/x", "/serve"):
            client.sendall(bytes([byte]))
            time.sleep(0.001)
        client.settimeout(LIMIT)
        assert b"std_srvs/Empty" in client.recv(4096)


REQUESTS = {  # what a client sends and does then -> what the log tells of it
    "short": (b"\0\0\0\0", "wait", "its message cannot be read: cannot deserialize"),
    "huge": (b"\xff\xff\xff\xff" + bytes(1000), "wait", "a message of 4294967295 bytes is refused"),
    "cut": (b"\1\0", "leave", "it left within a call"),
    "unheard": (b"\1\0\0\0\1", "leave", "it left within a call"),
}


def test_of_requests_that_cannot_be_answered_one_line_names_the_client():
    """They were read to 4 GB, and their errors were tracebacks that named nobody."""
    with serving() as (environment, server, address):
        for name, (data, then, _) in REQUESTS.items():
            for _ in range(3):
                with socket.create_connection(address, LIMIT) as client:
                    client.sendall(header_of(f"/{name}", "/set"))
                    assert client.recv(4096)
                    client.sendall(data)
                    if then == "wait":
                        with contextlib.suppress(ConnectionResetError):
                            assert client.recv(1) == b"", "the connection is closed"
                    else:  # it is reset
                        client.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, b"\1" + bytes(7))
        call_serve(environment)
        time.sleep(1.0)
        server.terminate()
        text = server.communicate(timeout=60.0)[0]
        assert "Traceback" not in text
        for name, (_, _, line) in REQUESTS.items():
            assert text.count(f"/{name}, at /set: {line}") == 1, text


def test_a_connection_that_the_node_itself_has_closed_is_nobodys_misdeed(monkeypatch):
    reported = []
    monkeypatch.setattr(inbound, "_report", lambda *line: reported.append(line))
    transport = TCPROSTransport(TCPROSTransportProtocol("/t", Bool), "/t")
    transport.socket = socket.socket()
    transport.socket.close()  # in another thread, while this one reads
    with pytest.raises(TransportException):
        inbound._receive_and_report(transport)
    assert not reported


def test_a_call_by_xml_rpc_has_a_limit():
    """2 GB were stored; numbers in 100 MB stopped all threads for 8 s."""
    with serving() as (environment, _, _):
        uri = urlsplit(call(environment["ROS_MASTER_URI"], "lookupNode", "/server"))
        for size in (str(inbound.MAX_CALL + 1), "-1", "many"):
            client = http.client.HTTPConnection(uri.hostname, uri.port, timeout=LIMIT)
            client.putrequest("POST", "/RPC2")
            client.putheader("Content-Length", size)
            client.endheaders()
            assert client.getresponse().status == 413
            client.close()
        assert call(uri.geturl(), "getPid")


@pytest.mark.parametrize(
    "kind, size, fits", [(Bool, 20, True), (Bool, 27, False), (Image, 29, True), (Image, 30, False)]
)
def test_a_message_has_a_limit(kind, size, fits):
    protocol = TCPROSTransportProtocol("/t", kind)
    with contextlib.nullcontext() if fits else pytest.raises(TransportTerminated):
        buffer = io.BytesIO((1 << size).to_bytes(4, "little") + b"1234")
        buffer.seek(0, io.SEEK_END)
        inbound._read_short_messages(protocol, buffer, [], None)


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
