"""A small checkout with the tests' own plugins, in which pytest runs."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
DEADLINE = 300.0  # wall time of a small run [s]
INI = """[pytest]
testpaths = src tests
pythonpath = tests/ros
addopts = --import-mode=importlib --dist=loadfile
timeout = 60
"""
PASSES = "def test_it():\n    pass\n"

# Started in a project: lists, for each list of filters, the tests that they select.
COLLECT = """
import contextlib, io, json, sys, pytest
for filters in json.loads(sys.argv[1]):
    with contextlib.redirect_stdout(io.StringIO()) as output:
        pytest.main(["-q", "--collect-only", *(f"--select={name}" for name in filters)])
    print(json.dumps([line for line in output.getvalue().splitlines() if "::" in line]))
"""


SKID, CIRCLE = "src/car/test/test_skid.py", "tests/ros/test_circle.py"
TWISTS, LONG = "tests/long/test_a.py", "tests/unit/test_long_drives.py"
STANDIN, PHYSICS = "src/standins/joy/test/test_pad.py", "tests/physics/test_slip.py"


LINTERS = "tests/lint/test_lint.py"


class Project:
    """A small checkout with the plugins.

    Args:
        folder: Where.
    """

    def __init__(self, folder):
        self.root = folder / "checkout"
        self.root.mkdir()
        (self.root / "pytest.ini").write_text(INI)
        shutil.copytree(ROOT / "tests" / "plugins", self.root / "tests" / "plugins")
        with open(self.root / "tests" / "plugins" / "graphs.py", "a") as stream:
            stream.write('PRELOADED[:] = ["pytest"]\n')  # ROS pays where many files need it
        (self.root / "commands").mkdir()
        for name in ("__init__.py", "procfs.py"):
            shutil.copy(ROOT / "commands" / name, self.root / "commands")
        shutil.copy(ROOT / "conftest.py", self.root)
        self.add(LINTERS, (ROOT / LINTERS).read_text())
        self.notes = folder / "notes"
        self.environment = dict(os.environ, NOTES=str(self.notes))
        for name in list(self.environment):
            if name.startswith(("PYTEST", "PADDOCK_TEST")):
                del self.environment[name]

    def add(self, path, text=PASSES):
        """Writes a file."""
        file = self.root / path
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text)

    def start(self, *options):
        """Starts pytest."""
        return subprocess.Popen(
            [sys.executable, "-m", "pytest", "-q", f"--rootdir={self.root}", *options],
            cwd=self.root,
            env=self.environment,
            text=True,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        )

    def run(self, *options):
        """Runs pytest to its end; (exit status, output)."""
        process = self.start(*options)
        output, _ = process.communicate(timeout=DEADLINE)
        return process.returncode, output

    def selected(self, *all_filters):
        """Tests that lists of filters select, in their order; a list of lists."""
        output = subprocess.check_output(
            [sys.executable, "-c", COLLECT, json.dumps(all_filters)],
            cwd=self.root,
            env=self.environment,
            timeout=DEADLINE,
        )
        return [json.loads(line) for line in output.splitlines()]


@pytest.fixture
def project(tmp_path):
    return Project(tmp_path)
