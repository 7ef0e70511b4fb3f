"""Who had the processors: roles by command line, and sums between two moments."""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "bench"))

from processes import TICK, Machine, Thread  # noqa: E402
from usage import Reading, Watch, between, role_of, roles_of, summarise  # noqa: E402

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


def write_process(proc, pid, arguments, ticks):
    """A process in a /proc of ours, with a thread of its own number."""
    folder = proc / str(pid)
    (folder / "task" / str(pid)).mkdir(parents=True, exist_ok=True)
    (folder / "cmdline").write_bytes("\0".join([*arguments, ""]).encode())
    (folder / "stat").write_text(f"{pid} (x) S 1 1 1 0 -1 4194304 9 9 9 9 {ticks} 0 0 0 20 0 1 0 5")
    (folder / "task" / str(pid) / "schedstat").write_text(f"{ticks * 10**9 // TICK} 0 1")
    (folder / "task" / str(pid) / "status").write_text(
        f"voluntary_ctxt_switches:\t{ticks}\nnonvoluntary_ctxt_switches:\t{2 * ticks}\n"
    )


def test_processes_are_sorted_by_role(tmp_path):
    write_process(tmp_path, 5, BRIDGE, 0)
    write_process(tmp_path, 6, ["sh", "a"], 0)
    write_process(tmp_path, 7, ["sh", "b"], 0)
    write_process(tmp_path, 8, [], 0)
    assert roles_of([5, 6, 7, 8, 9], tmp_path) == {"bridge": [5], "sh": [6, 7]}


def test_a_watch_adds_up_what_was_spent_between_two_moments(tmp_path):
    """In 4 s: bridge 2 s, two shells 1 s each, of 7 s that the machine was busy."""
    moments = iter((10.0, 14.0))
    watch = Watch({"bridge": [5], "sh": [6, 7]}, {"simulation": (5, 5), "gone": (9, 9)},
                  tmp_path, now=lambda: next(moments))  # fmt: skip
    ticks = {5: (100, 100 + 2 * TICK), 6: (0, TICK), 7: (50, 50 + TICK)}
    readings = []
    for moment, (busy, stolen) in enumerate(((500, 10), (500 + 7 * TICK, 10 + TICK))):
        for pid, counts in ticks.items():
            write_process(tmp_path, pid, BRIDGE, counts[moment])
        (tmp_path / "stat").write_text(f"cpu {busy} 0 0 999 0 0 0 {stolen} 0 0\n")
        readings.append(watch.read())
    spent = between(*readings)
    assert spent["seconds"] == 4.0
    assert spent["cpu"] == {"bridge": pytest.approx(0.5), "sh": pytest.approx(0.5)}
    assert spent["others"] == pytest.approx(3 / 4)
    assert spent["stolen"] == pytest.approx(1 / 4)
    assert set(spent["threads"]) == {"simulation"}
    assert spent["threads"]["simulation"] == {
        "cpu": pytest.approx(0.5),
        "waited": 0.0,
        "switched_off": pytest.approx(TICK),
        "gave_up": pytest.approx(TICK / 2),
    }


def test_others_are_never_below_nothing():
    """The two files are not read at one moment: ours may be ahead of the sum by a tick."""
    before = Reading(0.0, Machine(5.0, 0.0), {"a": 1.0}, {})
    after = Reading(1.0, Machine(5.5, 0.0), {"a": 1.6}, {})
    assert between(before, after)["others"] == 0.0


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
