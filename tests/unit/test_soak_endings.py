"""How the soak judges an end: what others have slowed down, what is left, the table of stops."""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "bench"))

from soaking.crowd import Crowd  # noqa: E402
from soaking.marked import Ending  # noqa: E402
from soaking.promise import PROMISE, broken, table  # noqa: E402

LIVES = [("gazebo", 1.0), ("roslaunch", 2.0)]


def machine(folder, running, states):
    """A /proc with so many running threads, and process 7 with threads in these states."""
    (folder / "stat").write_text(f"cpu 1 2 3\nprocs_running {running}\nprocs_blocked 0\n")
    for number, state in enumerate(states):
        task = folder / "7" / "task" / str(number)
        task.mkdir(parents=True, exist_ok=True)
        (task / "stat").write_text(f"{number} (a) b) {state} 1 1\n")


def test_a_crowd_is_who_wants_the_processors_and_is_not_ours(tmp_path):
    crowd = Crowd(tmp_path, cores=2)
    assert crowd.slowdown() == 1.0
    machine(tmp_path, 3, "RRS")  # two of ours, and this process
    crowd.look([7, 8])
    assert crowd.slowdown() == 1.0
    machine(tmp_path, 11, "RRS")
    crowd.look([7, 8])
    assert crowd.slowdown() == 1.0 + 4.0 / 2  # none at one look, eight at the other


@pytest.mark.parametrize(
    "seconds, left, slowdown, files, word",
    [
        (PROMISE, [], 1.0, [], ""),
        (PROMISE + 0.1, [], 1.0, [], "roslaunch 2.0 s"),
        (PROMISE + 0.1, [], 2.0, [], ""),
        (2.0 * PROMISE + 0.1, [], 2.0, [], "at most 10.0 s"),
        (1.0, ["sleep 9"], 9.0, [], "left ['sleep 9']"),
        (1.0, [], 1.0, ["world"], "left files"),
    ],
)
def test_what_breaks_the_promise(seconds, left, slowdown, files, word):
    text = broken(Ending(seconds, left, LIVES, slowdown), files)
    assert word in text and bool(text) == bool(word)


def test_the_table_has_median_and_longest_by_state_and_signal():
    results = [
        {"state": "paused", "signal": "SIGINT", "seconds": s, "slowdown": 1.0, "lives": LIVES}
        for s in (1.0, 2.0, 4.5)
    ]
    results.append({**results[0], "state": "running", "signal": "SIGHUP", "lives": []})
    lines = table(results, ("SIGINT", "SIGHUP"))
    assert lines[-2] == "| paused | 2.0, 4.5 |  | x 1.0 | gazebo 1.0, roslaunch 2.0 |"
    assert lines[-1] == "| running |  |  |  |  |"  # which did not come up
