"""Who had the processors: roles by command line, sums between two moments, and this process."""

import os
import sys
import threading
import time
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "bench"))

import usage  # noqa: E402
from usage import (  # noqa: E402
    Machine,
    Thread,
    cpu_seconds,
    memory_bytes,
    role_of,
)

BRIDGE = ["python3", "/ws/bullet_bridge/nodes/bridge", "__name:=gazebo", "__log:=/x.log"]


@pytest.mark.parametrize(
    "arguments, role",
    [
        (BRIDGE, "bridge"),
        (["python3", "/ws/src/bullet_bridge/relay_process.py", "7"], "relay"),
        (["/venv/bin/python", "-m", "bullet_bridge.transport.relay_process"], "relay"),
        (["/venv/bin/python", "-m", "bullet_sim.render.worker", "5"], "render_worker"),
        (["/usr/lib/robot_state_publisher/robot_state_publisher", "joint_states:=/racecar/j",
          "__name:=robot_state_publisher"], "robot_state_publisher"),
        (["python3", "/usr/bin/rosmaster", "--core", "-p", "11311"], "rosmaster"),
        (["/venv/bin/python3", "/usr/bin/roslaunch", "-p", "1", "a", "b"], "roslaunch"),
        (["python3", "-m"], "python3"),
        (["python3"], "python3"),
    ],
)  # fmt: skip
def test_role_of_a_command_line(arguments, role):
    assert role_of(arguments) == role


GONE = 2**22 + 1  # above the largest pid


def test_a_process_that_has_ended_reads_as_nothing():
    assert cpu_seconds(GONE) == 0.0
    assert memory_bytes(GONE) == 0
    assert usage.procfs.arguments(GONE) == []
    assert usage.procfs.environment(GONE) == {}
    assert Thread.read(GONE, GONE) is None


def test_this_process_is_read_as_it_counts_itself():
    pid, thread = os.getpid(), threading.get_native_id()
    tick = 1.0 / os.sysconf("SC_CLK_TCK")
    before, counted = Thread.read(pid, thread), cpu_seconds(pid)
    machine = Machine.read()
    begin = time.thread_time()
    while time.thread_time() - begin < 0.2:
        pass
    after = Thread.read(pid, thread)
    own = time.thread_time() - begin
    assert 0.2 <= after.cpu - before.cpu <= own + 0.02
    assert cpu_seconds(pid) - counted >= 0.2 - 2 * tick
    assert Machine.read().busy - machine.busy >= 0.2 - 4 * tick
    time.sleep(0.01)
    assert Thread.read(pid, thread).voluntary > after.voluntary
    assert memory_bytes(pid) > 1e6
