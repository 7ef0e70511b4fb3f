"""Who had the processors: roles by command line, sums between two moments, and this process."""

import os
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "bench"))

import usage  # noqa: E402
from usage import (  # noqa: E402
    Machine,
    Monitor,
    Reading,
    Thread,
    between,
    cpu_seconds,
    memory_bytes,
    role_of,
    summarise,
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


def test_a_monitor_adds_up_what_was_spent_between_two_moments(monkeypatch):
    """In 4 s: bridge 2 s, two shells 1 s each, of 7 s that the machine was busy."""
    moment = 0
    spent_cpu = {5: (1.0, 3.0), 6: (0.0, 1.0), 7: (0.5, 1.5)}
    machine = (Machine(5.0, 0.1), Machine(12.0, 1.1))
    thread = (Thread(1.0, 0.5, 10, 20), Thread(3.0, 0.5, 12, 24))
    monkeypatch.setattr(usage, "cpu_seconds", lambda pid: spent_cpu[pid][moment])
    monkeypatch.setattr(Machine, "read", lambda: machine[moment])
    monkeypatch.setattr(Thread, "read", lambda pid, _tid: thread[moment] if pid == 5 else None)
    monitor = Monitor(
        {"bridge": [5], "sh": [6, 7]},
        {"simulation": (5, 5), "gone": (9, 9)},
        now=lambda: (10.0, 14.0)[moment],
    )
    before = monitor.read()
    moment = 1
    spent = between(before, monitor.read())
    assert spent["seconds"] == 4.0
    assert spent["cpu"] == {"bridge": pytest.approx(0.5), "sh": pytest.approx(0.5)}
    assert spent["others"] == pytest.approx(3 / 4)
    assert spent["stolen"] == pytest.approx(1 / 4)
    assert set(spent["threads"]) == {"simulation"}
    assert spent["threads"]["simulation"] == {
        "cpu": pytest.approx(0.5),
        "waited": 0.0,
        "switched_off": pytest.approx(1.0),
        "gave_up": pytest.approx(0.5),
    }


def spent(cpu, others, waited):
    """What between() gives for one role and one thread."""
    before = Reading(0.0, Machine(0.0, 0.0), {"a": 0.0}, {"t": Thread(0.0, 0.0, 0, 0)})
    after = Reading(1.0, Machine(cpu + others, 0.0), {"a": cpu}, {"t": Thread(cpu, waited, 1, 2)})
    return between(before, after)


def test_turns_are_summed_up_by_medians_and_the_most():
    summary = summarise([spent(0.5, 0.1, 0.0), spent(0.7, 0.9, 0.2), spent(0.6, 0.2, 0.1)])
    assert summary["cpu"] == {"a": pytest.approx(0.6)}
    assert summary["others"] == pytest.approx(0.2)
    assert summary["others_most"] == pytest.approx(0.9)
    assert summary["threads"]["t"]["waited"] == pytest.approx(0.1)
    assert summary["threads"]["t"]["switched_off"] == pytest.approx(2.0)


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


def test_processes_with_a_mark_are_found_while_they_live():
    code = "print(flush=True); input()"
    with subprocess.Popen(
        [sys.executable, "-c", code],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        env={**os.environ, "PADDOCK_PROBE": "a b=c"},
    ) as child:
        child.stdout.readline()
        assert usage.procfs.marked("PADDOCK_PROBE", "a b=c") == [child.pid]
        assert usage.procfs.marked("PADDOCK_PROBE", "a") == []
        assert usage.procfs.environment(child.pid)["PADDOCK_PROBE"] == "a b=c"
        assert usage.procfs.arguments(child.pid) == [sys.executable, "-c", code]
        child.communicate(b"\n")
    assert usage.procfs.marked("PADDOCK_PROBE", "a b=c") == []
