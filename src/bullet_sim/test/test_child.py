"""Child processes: their socket, what is told of their end, and that they do end."""

import os
import signal
import sys

import pytest
from bullet_sim.child import Child

TIMEOUT = 60.0  # [s]
ECHO = """
import socket, sys
link = socket.socket(fileno=int(sys.argv[1]))
while data := link.recv(100):
    link.send(data + " ".join(sys.argv[2:]).encode())
{end}
"""


def started(end="", arguments=(), **options):
    command = (sys.executable, "-c", ECHO.format(end=end))
    return Child("the echo", command, arguments, **options)


@pytest.fixture
def descriptors():
    """The test leaves as many file descriptors open as there were."""
    before = len(os.listdir("/proc/self/fd"))
    yield
    assert len(os.listdir("/proc/self/fd")) == before


def test_it_has_its_own_session_and_a_lower_priority_than_the_process_had(descriptors):
    child = started(niceness=3)
    pid = child.process.pid
    assert os.getsid(pid) == pid
    assert os.getpriority(os.PRIO_PROCESS, pid) == min(19, os.nice(0) + 3)
    try:
        with open(f"/proc/{pid}/autogroup", encoding="ascii") as stream:
            group = stream.read().split()[-1]
    except OSError:
        group = "none"
    # Linux allows a change once within 0.1 s, except for root.
    assert group in (str(min(19, os.nice(0) + 3)), "none") or os.geteuid() != 0
    child.shut_down()
    child.wait(TIMEOUT)
    child.close()


@pytest.mark.parametrize("logged", [True, False])
def test_it_answers_and_ends_when_the_stream_does(descriptors, logged):
    child = started(arguments=("a", "b"), logged=logged)
    child.socket.send(b"-> ")
    assert child.socket.recv(100) == b"-> a b"
    assert child.name == f"the echo (pid {child.process.pid})"
    child.shut_down()
    child.wait(TIMEOUT)
    assert child.process.returncode == 0
    child.close()
    child.shut_down()  # closed already


@pytest.mark.parametrize(
    "end, words",
    [
        ("sys.exit(3)", " ended with exit code 3"),
        ("print('first'); sys.exit('  last  ')", " ended with exit code 1: last"),
        ("print('first\\n\\nwhy'); sys.exit(2)", " ended with exit code 2: why"),
        ("import os; os.kill(os.getpid(), 9)", " ended with signal 9"),
    ],
)
def test_how_it_ended_is_one_line(descriptors, end, words):
    child = started(end)
    child.shut_down()
    child.wait(TIMEOUT)
    assert child.ending() == child.name + words
    child.close()


def test_one_that_does_not_end_is_killed(descriptors):
    child = started("import time; time.sleep(600)")
    child.shut_down()
    child.wait(0.2)
    assert child.process.returncode == -signal.SIGKILL
    child.close()


def test_one_that_does_not_start_leaves_nothing(descriptors):
    with pytest.raises(OSError, match="no such program"):
        Child("the echo", ("/no such program",))
