"""The start of a node: short waits, and lower priority."""

import os
import subprocess
import sys
import time
from pathlib import Path

import pytest
import rospy.impl.init

from paddock_common import nodes

SRC = Path(__file__).resolve().parents[2]
LOWER_PRIORITY = """
import os
from paddock_common import process
try:
    group = lambda: open("/proc/self/autogroup").read().split()[-1]
    before = group()
except OSError:
    group, before = (lambda: "none"), "none"
process.lower_priority({niceness})
print(os.nice(0), before, group())
"""


def test_registration_is_checked_often_and_rospy_restored(monkeypatch):
    waits = []

    def init_node(_name, **_options):
        rospy.impl.init.time.sleep(0.1)
        rospy.impl.init.time.sleep(0.00001)
        raise rospy.ROSInitException("no master")

    monkeypatch.setattr(nodes.rospy, "init_node", init_node)
    monkeypatch.setattr(time, "sleep", waits.append)
    with pytest.raises(rospy.ROSInitException):
        nodes.init_node("n", anonymous=True)
    assert waits == [nodes.POLL_PERIOD, 0.00001]
    assert rospy.impl.init.time is time


@pytest.mark.parametrize("own_session", [True, False])
def test_a_node_gets_lower_priority_and_the_rest_of_a_terminal_does_not(own_session):
    """In a launch file it has its own session, whose group of processes Linux schedules."""
    output = subprocess.check_output(
        [sys.executable, "-c", LOWER_PRIORITY.format(niceness=4)],
        start_new_session=own_session,
        text=True,
    )
    niceness, before, after = output.split()
    assert int(niceness) == min(19, os.nice(0) + 4)
    if own_session and before != "none":
        # Linux allows this once within 0.1 s, except for root.
        assert after == "4" or (after == before and os.geteuid() != 0)
    else:
        assert after == before


RAISED = """
import os, threading
from paddock_common import process
found = []
def run():
    raised, thread = process.raise_priority(-2), threading.get_native_id()
    found.append((raised, os.getpriority(os.PRIO_PROCESS, thread)))
thread = threading.Thread(target=run)
thread.start()
thread.join()
print(*found[0], os.getpriority(os.PRIO_PROCESS, 0), len(os.sched_getaffinity(0)))
"""


def test_a_thread_gets_higher_priority_where_that_is_allowed():
    output = subprocess.check_output([sys.executable, "-c", RAISED], start_new_session=True)
    raised, niceness, others, _ = output.decode().split()
    assert int(others) == os.nice(0)
    assert int(niceness) == (-2 if raised == "True" else os.nice(0))


def test_a_thread_of_a_single_processor_keeps_its_priority():
    only = str(min(os.sched_getaffinity(0)))
    output = subprocess.check_output(["taskset", "-c", only, sys.executable, "-c", RAISED])
    assert output.decode().split() == ["False", str(os.nice(0)), str(os.nice(0)), "1"]


BLOCKS = """
import ctypes
from paddock_common import nodes
Numbers = ctypes.c_size_t * 10
class Info(ctypes.Structure):
    _fields_ = [("numbers", Numbers)]  # the fourth: blocks that the kernel has mapped
libc = ctypes.CDLL(None)
libc.mallinfo2.restype = Info
def mapped():
    before = libc.mallinfo2().numbers[3]
    block = bytes(4 << 20)
    return libc.mallinfo2().numbers[3] - before
first = mapped()
nodes.retain_freed_memory()
print(first, mapped())
"""


def test_large_blocks_are_retained_by_the_process():
    output = subprocess.check_output([sys.executable, "-c", BLOCKS], text=True)
    assert output.split() == ["1", "0"]


def test_every_node_starts_here():
    """The corrections of rospy are installed in one place."""
    scripts = [
        path
        for folder in ("src", "scripts", "nodes")
        for path in SRC.glob(f"**/{folder}/**/*")
        if path.is_file() and path.suffix in ("", ".py") and "test" not in path.parts
    ]
    direct = [path for path in scripts if b"rospy.init_node(" in path.read_bytes()]
    assert direct == [Path(nodes.__file__).resolve()]
    assert len(scripts) > 200
