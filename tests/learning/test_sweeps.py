"""Sweeps as ./run sweep starts them: they go on where they were cut off."""

import csv
import json
import signal
import subprocess
import sys

import pytest

GRID = """of: pursuit
at_once: 1
fixed: {track: easy, starts: 1}
over:
  max_speed: [1.5, 2.0, 2.5]
"""
RANDOM = """of: pursuit
search: random
trials: {trials}
fixed: {{track: easy, starts: 1}}
over:
  max_speed: {{low: 1.5, high: 2.5}}
"""
TRAIN = """of: train
search: random
trials: 1
fixed: {steps: 512, workers: 1}
over:
  lr: {low: 0.0001, high: 0.01, log: true}
"""


class Sweep:
    """A sweep in a folder.

    Args:
        folder: for its file and its results.
    """

    def __init__(self, folder):
        self.folder, self.file = folder / "out", folder / "sweep.yaml"

    def start(self, text):
        """Start it; returns the process, its output is text."""
        self.file.write_text(text)
        table = json.dumps({"file": str(self.file), "folder": str(self.folder)})
        return subprocess.Popen(
            [sys.executable, "-m", "paddock_gym.sweep.cli", table],
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )

    def run(self, text):
        """Run it to its end; returns (status, output)."""
        process = self.start(text)
        output, _ = process.communicate(timeout=900.0)
        return process.returncode, output

    def table(self):
        """Rows of table.csv."""
        with open(self.folder / "table.csv", newline="") as stream:
            return list(csv.DictReader(stream))


@pytest.fixture
def sweep(tmp_path):
    """A Sweep."""
    return Sweep(tmp_path)


@pytest.mark.parametrize("number, status", [(signal.SIGINT, 130), (signal.SIGKILL, -9)])
def test_a_sweep_that_was_cut_off_goes_on(sweep, number, status):
    process = sweep.start(GRID)
    assert process.stdout.readline().startswith("sweep: 1 of 3: ")
    process.send_signal(number)
    process.communicate(timeout=300.0)
    assert process.returncode == status
    ended, output = sweep.run(GRID)
    assert ended == 0, output
    assert "sweep: 1 of 3" not in output and "sweep: 3 of 3: " in output
    rows = sweep.table()
    assert sorted(float(row["max_speed"]) for row in rows) == [1.5, 2.0, 2.5]
    seconds = [float(row["seconds"]) for row in rows]
    assert seconds == sorted(seconds) and float(rows[0]["max_speed"]) == 2.5
    again, output = sweep.run(GRID)
    assert again == 0 and " of 3: " not in output
    status, output = sweep.run(GRID.replace("easy", "medium"))
    assert status == 1 and "has a sweep whose fixed is" in output


def test_more_trials_are_other_trials(sweep):
    assert sweep.run(RANDOM.format(trials=1))[0] == 0
    status, output = sweep.run(RANDOM.format(trials=3))
    assert status == 0, output
    assert len({row["max_speed"] for row in sweep.table()}) == 3


def test_trainings_are_swept(sweep):
    status, output = sweep.run(TRAIN)
    assert status == 0, output
    (row,) = sweep.table()
    files = sweep.folder / "trials" / f"{int(row['trial']):04d}"
    given = json.loads((files / "hyperparameters.json").read_text())
    assert given["lr"] == pytest.approx(float(row["lr"]))
    report = json.loads((files / "files" / "report.json").read_text())
    assert report["steps"] == 512
    assert (sweep.folder / "options.png").is_file() and (sweep.folder / "history.png").is_file()


def test_a_trial_that_fails_ends_the_sweep_with_its_words(sweep, tmp_path):
    reward = tmp_path / "reward.py"
    reward.write_text("def reward_function(params):\n    return params['nothing']\n")
    status, output = sweep.run(TRAIN.replace("workers: 1", f"workers: 1, reward: {reward}"))
    assert status == 1
    assert "sweep: trial 0 with {'lr'" in output and "KeyError: 'nothing'" in output
