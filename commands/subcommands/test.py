"""Runs the tests: unit tests (pytest), linters, integration tests (rostest).

Linters are catkin_lint, ruff, mypy and shellcheck; each integration test has a ROS master of its
own. FILTER: unit, lint, ros, or part of a name (./run test circle). Five stages run only when they
are asked for: ./run test soak (two minutes of ./run soak, as CI does), ./run test learning
(trainings; it installs torch, Ray and Optuna), ./run test desk (the desk in Chromium, which it
installs), ./run test tutorials (what the tutorials say to type) and ./run test long (more and
longer drives of the truck). -j N runs N jobs side by side, by default as many as there are cores;
--failed runs what failed when it last ran. Logs and JUnit files go to test-results/. At the end
come the slowest tests, the flaky ones (failed and passed in their last ten runs) and what failed.
The last line is the sum; the exit status is 0 only if nothing failed.
"""

import os

from commands import environment, processes
from commands.paths import ROOT, SOURCES, VENV_PYTHON

USAGE = "[FILTER ...] [OPTIONS]"
PASSES_ON = True
RUNNER = os.path.join(ROOT, "tests", "runner.py")
OPTIONS = os.path.join(ROOT, "tests", "runner", "main.py")
STAGES = ("unit", "lint", "ros", "soak", "learning", "desk", "tutorials", "long")


def add_arguments(parser):
    """Declares the test runner's options, for help and completion."""
    from commands import forwarded

    forwarded.declare(parser, OPTIONS)


def run(arguments):
    """Becomes the test runner."""
    environ = environment.ready()
    if "--list" not in arguments:
        prepare_stages(arguments)
    environ.pop("ROS_HOSTNAME", None)
    environ.update(ROS_IP="127.0.0.1", QT_QPA_PLATFORM="offscreen", PYTHONDONTWRITEBYTECODE="1")
    processes.become([VENV_PYTHON, RUNNER, *arguments], environ)


def prepare_stages(arguments):
    """Installs what the stages that have to be asked for need beyond ./run setup."""
    from commands.bootstrap import desk, learning

    if "learning" in arguments:
        learning.prepare("learning", "ray", "sweep")
    if "desk" in arguments:
        desk.prepare(tests=True)


def complete(_words):
    """Lists the stages, the integration tests and the folders with unit tests."""
    import glob

    folders = glob.glob(f"{SOURCES}/**/test", recursive=True)
    tests = [path for folder in (*folders, f"{ROOT}/tests/ros") for path in _tests(folder)]
    packages = [os.path.dirname(path) for path in folders if glob.glob(f"{path}/test_*.py")]
    names = {os.path.basename(path) for path in (*tests, *packages)}
    return [*STAGES, *sorted(names | {"project", "physics"})]


def _tests(folder):
    import glob

    return [path.removesuffix(".test") for path in glob.glob(f"{folder}/*.test")]
