"""Trainings as ./run train starts them, in folders of their own."""

import json
import subprocess
import sys

import pytest

LIMIT = 900.0  # wall time of a training [s]


class Training:
    """A training in a folder.

    Args:
        folder: for its files.
    """

    def __init__(self, folder):
        self.folder = folder

    def start(self, resume=False, **settings):
        """Start it; returns the process, its output is text."""
        table = {"name": "test", "folder": str(self.folder), "resume": resume, **settings}
        command = [sys.executable, "-m", "paddock_gym.training.cli", json.dumps(table)]
        return subprocess.Popen(
            command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
        )

    def run(self, **settings):
        """Run it to its end; returns its report."""
        process = self.start(**settings)
        output, _ = process.communicate(timeout=LIMIT)
        assert process.returncode == 0, output
        return self.report()

    @staticmethod
    def wait_for(process, words):
        """Read a training's lines up to one with some words; returns them."""
        lines = []
        for line in process.stdout:
            lines.append(line)
            if words in line:
                return lines
        raise AssertionError("".join(lines))

    def report(self):
        """What report.json says."""
        return json.loads((self.folder / "report.json").read_text())


@pytest.fixture
def training(tmp_path):
    """A Training."""
    return Training(tmp_path / "test")
