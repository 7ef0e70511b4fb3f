"""Calls with a time-out, invalid responses, and an unresponsive, stopped or replaced master."""

import socket
import subprocess
import sys
import threading

import pytest
from paddock_common.master import ERRORS, MasterMonitor, find_service, proxy
from paddock_common.waiting import WaitTimeout, wait_for_service
from testing import ros_master, web_page

from paddock_common import master


def test_a_web_server_is_no_master():
    with web_page() as address, pytest.raises(ERRORS), proxy(address, 10.0) as server:
        server.getPid("/test")


def test_an_unresponsive_and_a_missing_server():
    with socket.create_server(("127.0.0.1", 0)) as server_socket:  # accepts and never responds
        address = f"http://127.0.0.1:{server_socket.getsockname()[1]}"
        with pytest.raises(socket.timeout), proxy(address, 0.1) as server:
            server.getPid("/test")
    with pytest.raises(ConnectionRefusedError), proxy(address, 10.0) as server:
        server.getPid("/test")


def test_the_address_of_a_service():
    with ros_master() as environment:
        uri = environment["ROS_MASTER_URI"]
        with proxy(uri, 10.0) as server:
            server.registerService("/node", "/there", "rosrpc://host:1", "http://host:2")
        assert find_service(uri, "/test", "/there", 10.0) == "rosrpc://host:1"
        assert find_service(uri, "/test", "/other", 10.0) is None


def test_a_wait_for_a_service_ends_although_the_master_does_not_respond(monkeypatch):
    with socket.create_server(("127.0.0.1", 0)) as server_socket:  # accepts and never responds
        uri = f"http://127.0.0.1:{server_socket.getsockname()[1]}"
        monkeypatch.setenv("ROS_MASTER_URI", uri)
        with pytest.raises(WaitTimeout, match="service /there did not come within 0.1 s"):
            wait_for_service("/there", 0.1, lambda: False)


class Requests:
    """A monitor with a fake clock and fake responses."""

    def __init__(self):
        self.response, self.time, self.count = "a", 0.0, 0
        self.monitor = MasterMonitor("http://m:1", self._identity, self._count, lambda: self.time)

    def _identity(self, uri):
        assert uri == "http://m:1"
        if isinstance(self.response, Exception):
            raise self.response
        return self.response

    def _count(self):
        self.count += 1

    def state(self, response, seconds):
        """(unresponsive_for, refused_for, replaced) after a request, a time after the last one."""
        self.response = response
        self.time += seconds
        self.monitor.check()
        monitor = self.monitor
        return monitor.unresponsive_for, monitor.refused_for, monitor.replaced


SLOW, REFUSED = TimeoutError(), ConnectionRefusedError()


@pytest.mark.parametrize(
    "responses, state",
    [
        (["a"], (0.0, 0.0, False)),
        (["a", SLOW, SLOW], (2.0, 0.0, False)),
        ([SLOW, ValueError()], (2.0, 0.0, False)),
        (["a", REFUSED], (1.0, 0.0, False)),
        (["a", SLOW, REFUSED, REFUSED, REFUSED], (4.0, 2.0, False)),
        (["a", REFUSED, REFUSED, SLOW], (3.0, 0.0, False)),
        (["a", REFUSED, REFUSED, "a"], (0.0, 0.0, False)),
        (["a", REFUSED, "b"], (0.0, 0.0, True)),
        (["a", "b", SLOW], (1.0, 0.0, True)),
        (["a", "b", "a"], (0.0, 0.0, False)),
        (["", "a"], (0.0, 0.0, True)),
        ([SLOW, "b", "b"], (0.0, 0.0, False)),
    ],
)
def test_a_master_that_is_unresponsive_stopped_or_replaced(responses, state):
    requests = Requests()
    assert [requests.state(response, 1.0) for response in responses][-1] == state
    assert requests.count == len(responses)


def test_a_closed_monitor_calls_nothing():
    requests = Requests()
    requests.monitor.close()
    requests.state("a", 1.0)
    assert requests.count == 0


def test_the_thread_sends_requests_periodically(monkeypatch):
    monkeypatch.setattr(master, "PERIOD", 0.01)
    requested = threading.Semaphore(0)
    monitor = MasterMonitor("http://m:1", lambda _: "a", requested.release)
    monitor.start()
    for _ in range(3):
        assert requested.acquire(timeout=10.0)
    monitor.close()


def test_no_ros_is_needed():
    script = "import sys, paddock_common.master\nassert 'rospy' not in sys.modules"
    subprocess.run([sys.executable, "-c", script], check=True, timeout=60.0)
