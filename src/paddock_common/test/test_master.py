"""Calls with a time-out, what is no answer, and a master that is silent, gone or another one."""

import socket
import subprocess
import sys
import threading

import pytest
from paddock_common.master import ERRORS, MasterMonitor, proxy
from paddock_common.testing import web_page

from paddock_common import master


def test_a_web_server_is_no_master():
    with web_page() as address, pytest.raises(ERRORS), proxy(address, 10.0) as server:
        server.getPid("/test")


def test_silence_and_nobody():
    with socket.create_server(("127.0.0.1", 0)) as silent:  # accepts and never answers
        address = f"http://127.0.0.1:{silent.getsockname()[1]}"
        with pytest.raises(TimeoutError), proxy(address, 0.1) as server:
            server.getPid("/test")
    with pytest.raises(ConnectionRefusedError), proxy(address, 10.0) as server:
        server.getPid("/test")


class Questions:
    """A monitor with a clock and answers of its own."""

    def __init__(self):
        self.answer, self.time, self.asked = "a", 0.0, 0
        self.monitor = MasterMonitor("http://m:1", self._identity, self._count, lambda: self.time)

    def _identity(self, uri):
        assert uri == "http://m:1"
        if isinstance(self.answer, Exception):
            raise self.answer
        return self.answer

    def _count(self):
        self.asked += 1

    def state(self, answer, seconds):
        """(silent_for, refused_for, replaced) after a question, so long after the last one."""
        self.answer = answer
        self.time += seconds
        self.monitor.check()
        monitor = self.monitor
        return monitor.silent_for, monitor.refused_for, monitor.replaced


SLOW, REFUSED = TimeoutError(), ConnectionRefusedError()


@pytest.mark.parametrize(
    "answers, state",
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
def test_a_master_that_is_silent_gone_or_another_one(answers, state):
    questions = Questions()
    assert [questions.state(answer, 1.0) for answer in answers][-1] == state
    assert questions.asked == len(answers)


def test_a_closed_monitor_tells_nothing():
    questions = Questions()
    questions.monitor.close()
    questions.state("a", 1.0)
    assert questions.asked == 0


def test_the_thread_asks_again_and_again(monkeypatch):
    monkeypatch.setattr(master, "PERIOD", 0.01)
    asked = threading.Semaphore(0)
    monitor = MasterMonitor("http://m:1", lambda _: "a", asked.release)
    monitor.start()
    for _ in range(3):
        assert asked.acquire(timeout=10.0)
    monitor.close()


def test_no_ros_is_needed():
    script = "import sys, paddock_common.master\nassert 'rospy' not in sys.modules"
    subprocess.run([sys.executable, "-c", script], check=True, timeout=60.0)
