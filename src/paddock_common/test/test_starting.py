"""The start of a node: short waits, and nodes that give way."""

import os
import subprocess
import sys
import time
from pathlib import Path

import pytest
import rospy.impl.init

from paddock_common import nodes

SRC = Path(__file__).resolve().parents[2]
# It measures a subscriber as everybody's.
PLAIN = {SRC / "bullet_bridge" / "scripts" / "sending_figures"}
GIVE_WAY = """
import os
from paddock_common import process
try:
    group = lambda: open("/proc/self/autogroup").read().split()[-1]
    before = group()
except OSError:
    group, before = (lambda: "none"), "none"
process.give_way({niceness})
print(os.nice(0), before, group())
"""


def test_registration_is_looked_for_often_and_rospy_left_as_it_was(monkeypatch):
    waits = []

    def init_node(_name, **_options):
        rospy.impl.init.time.sleep(0.1)
        rospy.impl.init.time.sleep(0.00001)
        raise rospy.ROSInitException("no master")

    monkeypatch.setattr(nodes.rospy, "init_node", init_node)
    monkeypatch.setattr(time, "sleep", waits.append)
    with pytest.raises(rospy.ROSInitException):
        nodes.init_node("n", anonymous=True)
    assert waits == [nodes.LOOK, 0.00001]
    assert rospy.impl.init.time is time


@pytest.mark.parametrize("own_session", [True, False])
def test_a_node_gives_way_and_the_rest_of_a_terminal_does_not(own_session):
    """Of a launch file it has a session, whose group of processes counts for Linux."""
    output = subprocess.check_output(
        [sys.executable, "-c", GIVE_WAY.format(niceness=4)],
        start_new_session=own_session,
        text=True,
    )
    niceness, before, after = output.split()
    assert int(niceness) == min(19, os.nice(0) + 4)
    if own_session and before != "none":
        # Linux lets only one process do so within 0.1 s, unless it is root's.
        assert after == "4" or (after == before and os.geteuid() != 0)
    else:
        assert after == before


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
nodes.keep_freed_memory()
print(first, mapped())
"""


def test_large_blocks_are_kept_by_the_process():
    output = subprocess.check_output([sys.executable, "-c", BLOCKS], text=True)
    assert output.split() == ["1", "0"]


def test_every_node_starts_here():
    """What mends rospy for a node's life is installed in one place."""
    scripts = [
        path
        for folder in ("src", "scripts", "nodes")
        for path in SRC.glob(f"**/{folder}/**/*")
        if path.is_file() and path.suffix in ("", ".py") and "test" not in path.parts
    ]
    own = [path for path in scripts if b"rospy.init_node(" in path.read_bytes()]
    assert {path for path in own if path not in PLAIN} == {Path(nodes.__file__).resolve()}
    assert len(scripts) > 200
