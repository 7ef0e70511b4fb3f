"""The tests' own plugins: which tests run, in which order, in which processes."""

import json
import os
import shutil
import signal
import subprocess
import sys
import time
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import pytest
from paddock_common.testing import is_running

from commands import procfs

ROOT = Path(__file__).resolve().parents[2]
DEADLINE = 120.0  # wall time of a small run [s]
INI = """[pytest]
testpaths = src tests
addopts = --import-mode=importlib --dist=loadfile --no-loadscope-reorder
timeout = 60
"""
PASSES = "def test_it():\n    pass\n"
WAITS_FOREVER = """
import os, pathlib, subprocess, sys, time

def test_it():
    child = subprocess.Popen([sys.executable, "-c", "import time; time.sleep(600)"],
                             start_new_session=True)
    pathlib.Path(os.environ["NOTES"]).write_text(f"{os.getpid()} {child.pid}")
    time.sleep(600)
"""


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
        (self.root / "commands").mkdir()
        for name in ("__init__.py", "procfs.py"):
            shutil.copy(ROOT / "commands" / name, self.root / "commands")
        shutil.copy(ROOT / "conftest.py", self.root)
        shutil.copytree(ROOT / "tests" / "lint", self.root / "tests" / "lint")
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

    def names(self, *filters):
        """Files of the tests that filters select, in their order."""
        words = [word for name in filters for word in ("--select", name)]
        _, output = self.run("--collect-only", *words)
        tests = [line.partition("::")[0] for line in output.splitlines() if "::" in line]
        return list(dict.fromkeys(tests))


@pytest.fixture
def project(tmp_path):
    return Project(tmp_path)


# selection ------------------------------------------------------------------------------------

SKID, CIRCLE = "src/car/test/test_skid.py", "tests/ros/test_circle.py"
TWISTS, LONG = "tests/long/test_a.py", "tests/unit/test_long_drives.py"
STANDIN, PHYSICS = "src/standins/joy/test/test_pad.py", "tests/physics/test_slip.py"


@pytest.mark.parametrize(
    ("filters", "expected"),
    [
        ((), {SKID, CIRCLE, LONG, STANDIN, PHYSICS, "tests/lint/test_lint.py"}),
        (("unit",), {SKID, LONG, STANDIN, PHYSICS}),
        (("project",), {LONG}),
        (("ros",), {CIRCLE}),
        (("circ",), {CIRCLE}),
        (("car",), {SKID}),
        (("car/test_sk", "circle"), {SKID, CIRCLE}),
        (("standins",), {STANDIN}),  # a folder
        (("joy",), {STANDIN}),
        (("physics",), {PHYSICS}),
        (("long",), {TWISTS}),  # a stage, and no part of a name
        (("lint",), {"tests/lint/test_lint.py"}),
        (("mypy",), {"tests/lint/test_lint.py"}),
        (("no_such",), set()),
    ],
)
def test_filters(project, filters, expected):
    for path in (SKID, CIRCLE, TWISTS, LONG, STANDIN, PHYSICS):
        project.add(path)
    assert set(project.names(*filters)) == expected


def test_a_linter_is_picked_by_its_name(project):
    _, output = project.run("--collect-only", "--select", "mypy")
    assert "test_no_warnings[mypy]" in output and "ruff" not in output


@pytest.mark.parametrize("options", [(), ("--numprocesses=2",)])
def test_a_filter_that_matches_nothing_is_named(project, options):
    project.add(SKID)
    status, output = project.run(*options, "--select", "no_such")
    assert status != 0 and "nothing matches 'no_such'; there are the stages unit, lint" in output


def test_a_file_that_is_named_runs_whatever_its_stage(project):
    project.add(TWISTS)
    status, output = project.run(TWISTS)
    assert status == 0 and "1 passed" in output


def test_the_longest_file_of_the_last_run_is_the_first(project):
    project.add("src/car/test/test_a.py")
    project.add("src/car/test/test_b.py", "import time\n\ndef test_it():\n    time.sleep(0.5)\n")
    assert project.run("src")[0] == 0
    assert project.names("unit") == ["src/car/test/test_b.py", "src/car/test/test_a.py"]


def test_flaky_tests_are_named(project):
    flaky = "import os\n\ndef test_it():\n    assert 'WRONG' not in os.environ\n"
    project.add(SKID, flaky)
    project.environment["WRONG"] = "1"
    status, output = project.run("src")
    assert status == 1 and "flaky" not in output
    del project.environment["WRONG"]
    status, output = project.run("src")
    assert status == 0 and f"flaky: {SKID}::test_it failed in 1 of its last 2 runs" in output


# groups ---------------------------------------------------------------------------------------


def write_pid(count):
    """Text of a file of tests that note the process that they run in."""
    head = "import os\n\ndef note():\n    with open(os.environ['NOTES'], 'a') as stream:\n"
    head += "        print(os.getpid(), os.environ['ROS_MASTER_URI'], file=stream)\n"
    return head + "".join(f"\ndef test_{number}():\n    note()\n" for number in range(count))


def test_each_file_has_a_process_and_a_master_port_of_its_own(project):
    project.add("tests/ros/test_a.py", write_pid(2))
    project.add("tests/ros/test_b.py", write_pid(2))
    status, output = project.run("--numprocesses=2", "tests/ros")
    assert status == 0 and "4 passed" in output
    lines = project.notes.read_text().splitlines()
    assert len(lines) == 4 and len(set(lines)) == 2


def test_files_of_one_process_and_of_their_own_take_turns(project):
    """Folders have to be left and entered: pytest keeps a stack of them."""
    for path in (
        "src/a/test/test_a.py",
        "tests/ros/test_b.py",
        "src/c/test/test_c.py",
        "tests/unit/test_d.py",
    ):
        project.add(path)
    files = [
        "tests/unit/test_d.py",
        "tests/ros/test_b.py",
        "src/a/test/test_a.py",
        "tests/ros/test_b.py",
    ]
    (project.root / "tests" / "plugins" / "selection.py").write_text("")
    project.add("tests/ros/test_e.py")
    files[3] = "tests/ros/test_e.py"
    status, output = project.run(*files, "src/c")
    assert status == 0 and "5 passed" in output, output


def test_a_marked_file_has_a_process_of_its_own(project):
    marked = f"import pytest\npytestmark = pytest.mark.isolated\n{write_pid(2)}"
    project.add("tests/unit/test_a.py", marked.replace("['ROS_MASTER_URI']", ".get('A')"))
    project.add(SKID, write_pid(1).replace("['ROS_MASTER_URI']", ".get('A')"))
    process = project.start("tests/unit", "src")
    output, _ = process.communicate(timeout=DEADLINE)
    assert process.returncode == 0, output
    pids = [line.split()[0] for line in project.notes.read_text().splitlines()]
    assert len(pids) == 3 and len(set(pids)) == 2 and str(process.pid) in pids


def test_one_file_alone_runs_in_the_process_of_pytest(project):
    project.add("tests/ros/test_a.py", write_pid(1))
    process = project.start("tests/ros")
    output, _ = process.communicate(timeout=DEADLINE)
    assert process.returncode == 0, output
    assert project.notes.read_text().split()[0] == str(process.pid)


def test_the_launch_runs_meanwhile_and_its_parameters_are_set_before(project):
    project.add(
        "tests/ros/test_a.py",
        """
import os, xmlrpc.client

LAUNCH = '<launch><param name="answer" value="42"/></launch>'

def test_it():
    master = xmlrpc.client.ServerProxy(os.environ["ROS_MASTER_URI"])
    assert master.getParam("/test", "/answer")[2] == 42
""",
    )
    project.add("tests/ros/test_b.py")
    status, output = project.run("tests/ros")
    assert status == 0, output


def test_a_launch_that_cannot_start_is_shown(project):
    text = f"LAUNCH = '<launch><nod</launch>'\n\n{PASSES}\n\n{PASSES.replace('it', 'more')}"
    project.add("tests/ros/test_a.py", text)
    project.add("tests/ros/test_b.py")
    status, output = project.run("tests/ros")
    assert status == 1 and "the launch does not come up" in output
    assert "2 failed, 1 passed" in output


def test_a_failure_shows_what_the_launch_printed_during_the_test(project):
    node = "<node name='n' pkg='rospy_tutorials_of_nobody' type='talker'/>"
    project.add(
        "tests/ros/test_a.py",
        f'import time\n\nLAUNCH = "<launch>{node}</launch>"\n\ndef test_it():\n'
        "    time.sleep(3)\n    assert 6 * 7 == 41\n",
    )
    project.add("tests/ros/test_b.py")
    status, output = project.run("tests/ros")
    assert status == 1 and "assert (6 * 7) == 41" in output
    assert "rospy_tutorials_of_nobody" in output
    assert (
        "rospy_tutorials_of_nobody"
        in (project.root / "test-results" / "ros" / "a" / "launch.log").read_text()
    )


def test_a_process_that_dies_fails_its_tests_and_no_others(project):
    project.add(
        "tests/ros/test_a.py",
        "import os\n\ndef test_a():\n    os._exit(3)\n\ndef test_b():\n    pass\n",
    )
    project.add("tests/ros/test_b.py")
    status, output = project.run("tests/ros")
    assert status == 1 and "2 failed, 1 passed" in output
    assert "the test process has ended, exit status 3" in output


def test_what_a_file_leaves_behind_is_ended_and_an_error(project):
    project.add(
        "tests/ros/test_a.py",
        """
import os, pathlib, subprocess, sys

def test_it():
    child = subprocess.Popen([sys.executable, "-c", "import time; time.sleep(600)"],
                             start_new_session=True)
    pathlib.Path(os.environ["NOTES"]).write_text(str(child.pid))
""",
    )
    project.add("tests/ros/test_b.py")
    project.environment["PADDOCK_TEST_GRACE"] = "0.5"
    status, output = project.run("tests/ros")
    assert status == 1 and "left processes behind" in output and "time.sleep(600)" in output
    assert not is_running(int(project.notes.read_text()))


def test_a_test_that_does_not_end_fails_with_its_stack_and_the_next_one_runs(project):
    project.add(
        "tests/ros/test_a.py",
        "import time\n\ndef test_a():\n    time.sleep(600)\n\ndef test_b():\n    pass\n",
    )
    project.add("tests/ros/test_b.py")
    status, output = project.run("-o", "timeout=2", "tests/ros")
    assert status == 1 and "1 failed, 2 passed" in output and "time.sleep(600)" in output


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize("options", [(), ("--numprocesses=2",)])
def test_an_interrupted_run_leaves_no_process(project, number, options):
    project.add("tests/ros/test_a.py", f'LAUNCH = "<launch></launch>"\n{WAITS_FOREVER}')
    project.add("tests/ros/test_b.py")
    process = project.start(*options, "tests/ros")
    deadline = time.monotonic() + DEADLINE
    while not project.notes.exists() or not project.notes.read_text():
        assert time.monotonic() < deadline and process.poll() is None
        time.sleep(0.05)
    started = procfs.marked("NOTES", str(project.notes))
    process.send_signal(number)
    process.communicate(timeout=DEADLINE)
    assert process.returncode not in (0, None)
    assert len(started) > 3  # roslaunch, master, test process, its child
    while left := procfs.marked("NOTES", str(project.notes)):
        assert time.monotonic() < deadline, left
        time.sleep(0.05)


def test_cases_of_all_processes_are_in_one_junit_file(project):
    project.add("tests/ros/test_a.py", write_pid(3))
    project.add(SKID)
    report = project.root / "junit.xml"
    assert project.run("--numprocesses=2", f"--junitxml={report}", "src", "tests/ros")[0] == 0
    assert len(list(ElementTree.parse(report).iter("testcase"))) == 4


def test_wall_times_are_kept(project):
    project.add(SKID)
    project.run("src")
    [file] = (project.root / ".pytest_cache").rglob("paddock/seconds")
    assert list(json.loads(file.read_text())) == [SKID]
