"""How the soak evaluates a shutdown: competing load, what is left, the table of stops."""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "bench"))

from soaking.limits import SHUTDOWN_LIMIT, CompetingLoad, violation  # noqa: E402
from soaking.process_under_test import Shutdown  # noqa: E402
from soaking.shutdown import table  # noqa: E402

LIVES = [("gazebo", 1.0), ("roslaunch", 2.0)]


def machine(folder, running, states):
    """A /proc with so many running threads, and process 7 with threads in these states."""
    (folder / "stat").write_text(f"cpu 1 2 3\nprocs_running {running}\nprocs_blocked 0\n")
    for number, state in enumerate(states):
        task = folder / "7" / "task" / str(number)
        task.mkdir(parents=True, exist_ok=True)
        (task / "stat").write_text(f"{number} (a) b) {state} 1 1\n")


def test_competing_load_is_what_wants_the_processors_and_is_not_ours(tmp_path):
    load = CompetingLoad(tmp_path, cores=2)
    assert load.slowdown() == 1.0
    machine(tmp_path, 3, "RRS")  # two of ours, and this process
    load.sample([7, 8])
    assert load.slowdown() == 1.0
    machine(tmp_path, 11, "RRS")
    load.sample([7, 8])
    assert load.slowdown() == 1.0 + 4.0 / 2  # none at one sample, eight at the other


@pytest.mark.parametrize(
    "seconds, left, slowdown, files, word",
    [
        (SHUTDOWN_LIMIT, [], 1.0, [], ""),
        (SHUTDOWN_LIMIT + 0.1, [], 1.0, [], "roslaunch 2.0 s"),
        (SHUTDOWN_LIMIT + 0.1, [], 2.0, [], ""),
        (2.0 * SHUTDOWN_LIMIT + 0.1, [], 2.0, [], "at most 10.0 s"),
        (1.0, ["sleep 9"], 9.0, [], "left ['sleep 9']"),
        (1.0, [], 1.0, ["world"], "left files"),
    ],
)
def test_what_breaks_the_limit(seconds, left, slowdown, files, word):
    text = violation(Shutdown(seconds, left, LIVES, slowdown), files)
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
