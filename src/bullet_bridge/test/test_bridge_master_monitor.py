"""The ROS master falls silent, dies, or is another one."""

import socket
import threading
from xmlrpc.server import SimpleXMLRPCServer

import pytest
from bullet_bridge.transport import master_monitor
from bullet_bridge.transport.master_monitor import (
    REFUSED_TIME,
    UNRESPONSIVE_TIME,
    ShutdownMonitor,
    master_pid,
)


class Rig:
    """A monitor with a clock and a master of its own."""

    def __init__(self):
        self.response, self.time, self.logged, self.ended = 7, 0.0, [], []
        self.monitor = ShutdownMonitor(
            self.ended.append, "http://m:1", self.logged.append, self._ask, lambda: self.time
        )

    def _ask(self, _):
        if isinstance(self.response, Exception):
            raise self.response
        return self.response

    def go_on(self, seconds):
        for _ in range(int(seconds)):
            self.time += 1.0
            self.monitor.check()


@pytest.fixture(name="rig")
def _rig():
    rig = Rig()
    rig.go_on(2)
    return rig


def test_an_unresponsive_master_is_waited_for_and_logged_once(rig):
    rig.response = TimeoutError()
    rig.go_on(UNRESPONSIVE_TIME + 600.0)
    assert rig.ended == []
    assert len(rig.logged) == 1 and "does not respond" in rig.logged[0]
    rig.response = 7
    rig.go_on(3)
    assert len(rig.logged) == 2 and "responds again" in rig.logged[1]
    assert rig.ended == []


def test_a_short_pause_of_the_master_is_not_logged(rig):
    for _ in range(5):
        rig.response = OSError("no route")
        rig.go_on(UNRESPONSIVE_TIME - 1)
        rig.response = 7
        rig.go_on(1)
    assert rig.logged == [] and rig.ended == []


def test_a_dead_master_ends_the_simulation(rig):
    rig.response = ConnectionRefusedError()
    rig.go_on(REFUSED_TIME)
    assert rig.ended == []
    rig.go_on(2)
    assert rig.ended[0] == "the ROS master at http://m:1 has exited: the simulation shuts down"
    assert rig.monitor.reason


def test_another_master_ends_the_simulation(rig):
    rig.response = ConnectionRefusedError()
    rig.go_on(2)
    rig.response = 8
    rig.go_on(1)
    assert "another ROS master runs at http://m:1" in rig.ended[0]


def test_the_pid_of_a_real_server(monkeypatch):
    with SimpleXMLRPCServer(("127.0.0.1", 0), logRequests=False) as server:
        server.register_function(lambda caller: [1, "", 4711], "getPid")
        thread = threading.Thread(target=server.serve_forever)
        thread.start()
        port = server.server_address[1]
        assert master_pid(f"http://127.0.0.1:{port}") == 4711
        server.shutdown()
        thread.join()
    with pytest.raises(ConnectionRefusedError):
        master_pid(f"http://127.0.0.1:{port}")
    monkeypatch.setattr(master_monitor, "RESPONSE_TIMEOUT", 0.3)
    with socket.create_server(("127.0.0.1", 0)) as stopped:  # accepts and never responds
        with pytest.raises(socket.timeout):
            master_pid(f"http://127.0.0.1:{stopped.getsockname()[1]}")
