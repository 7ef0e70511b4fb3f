"""The tests' own plugins: which tests run, in which order, in which processes."""

import json
import os
import re
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
DEADLINE = 300.0  # wall time of a small run [s]
INI = """[pytest]
testpaths = src tests
pythonpath = tests/ros
addopts = --import-mode=importlib --dist=loadfile
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


# Started in a project: lists, for each list of filters, the tests that they select.
COLLECT = """
import contextlib, io, json, sys, pytest
for filters in json.loads(sys.argv[1]):
    with contextlib.redirect_stdout(io.StringIO()) as output:
        pytest.main(["-q", "--collect-only", *(f"--select={name}" for name in filters)])
    print(json.dumps([line for line in output.getvalue().splitlines() if "::" in line]))
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


# selection ------------------------------------------------------------------------------------

SKID, CIRCLE = "src/car/test/test_skid.py", "tests/ros/test_circle.py"
TWISTS, LONG = "tests/long/test_a.py", "tests/unit/test_long_drives.py"
STANDIN, PHYSICS = "src/standins/joy/test/test_pad.py", "tests/physics/test_slip.py"


LINTERS = "tests/lint/test_lint.py"
FILTERS = {
    (): {SKID, CIRCLE, LONG, STANDIN, PHYSICS, LINTERS},
    ("unit",): {SKID, LONG, STANDIN, PHYSICS},
    ("project",): {LONG},
    ("ros",): {CIRCLE},
    ("circ",): {CIRCLE},
    ("car",): {SKID},
    ("car/test_sk", "circle"): {SKID, CIRCLE},
    ("standins",): {STANDIN},  # a folder
    ("joy",): {STANDIN},
    ("physics",): {PHYSICS},
    ("long",): {TWISTS},  # a stage, and no part of a name
    ("lint",): {LINTERS},
    ("mypy",): {LINTERS},
    ("no_such",): set(),
}


def test_filters(project):
    for path in (SKID, CIRCLE, TWISTS, LONG, STANDIN, PHYSICS):
        project.add(path)
    selected = dict(zip(FILTERS, project.selected(*FILTERS)))
    files = {
        filters: {test.partition("::")[0] for test in selected[filters]} for filters in FILTERS
    }
    assert files == FILTERS
    # a linter is picked by its name
    assert [test.partition("::")[2] for test in selected["mypy",]] == ["test_no_warnings[mypy]"]


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
    project.add("src/car/test/test_b.py", "import time\n\ndef test_it():\n    time.sleep(3.0)\n")
    assert project.run("src")[0] == 0
    [tests] = project.selected(["unit"])
    assert tests == ["src/car/test/test_b.py::test_it", "src/car/test/test_a.py::test_it"]


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
    head += "        print(__file__, os.getpid(), os.environ.get('ROS_MASTER_URI'),\n"
    head += "              os.environ.get('PYTEST_XDIST_WORKER'), file=stream)\n"
    return head + "".join(f"\ndef test_{number}():\n    note()\n" for number in range(count))


MARKED = f"import pytest\npytestmark = pytest.mark.isolated\n{write_pid(2)}"
ASKS_MASTER = """
import os, xmlrpc.client

LAUNCH = '<launch><param name="answer" value="42"/></launch>'

def test_it():
    master = xmlrpc.client.ServerProxy(os.environ["ROS_MASTER_URI"])
    assert master.getParam("/test", "/answer")[2] == 42
"""
FAILS_BESIDE_LAUNCH = """
import os, pathlib, time
import rospy

LAUNCH = "<launch><node name='n' pkg='rospy_tutorials_of_nobody' type='talker'/></launch>"
LOGS = pathlib.Path(os.environ["ROS_LOG_DIR"])

def test_it():
    rospy.init_node("motor")
    is_hot = is_refused = False
    while not (is_hot and is_refused):  # rosout and roslaunch have written it
        rospy.logwarn("the motor is hot")
        time.sleep(0.1)
        is_hot = any("motor is hot" in path.read_text() for path in LOGS.glob("*/rosout.log"))
        is_refused = "of_nobody" in (LOGS.parent / "launch.log").read_text()
    assert 6 * 7 == 41
"""
LEAVES_CHILD = """
import os, subprocess, sys

def test_it():
    child = subprocess.Popen([sys.executable, "-c", "import time; time.sleep(600)"],
                             start_new_session=True)
    with open(os.environ["NOTES"], "a") as stream:
        print(__file__, child.pid, file=stream)
"""
SHARES_MASTER = """
import os, xmlrpc.client
from shared_worlds import BOX as LAUNCH

def test_it():
    master = xmlrpc.client.ServerProxy(os.environ["ROS_MASTER_URI"])
    count = master.getParam("/test", "/count")[2]
    master.setParam("/test", "/count", count + 1)
    with open(os.environ["NOTES"], "a") as stream:
        print(__file__, os.getpid(), os.environ["ROS_MASTER_URI"], count, file=stream)
"""
GROUPS = {
    "tests/ros/shared_worlds.py": 'BOX = \'<launch><param name="count" value="1"/></launch>\'\n',
    "tests/ros/test_shares_1.py": SHARES_MASTER,
    "tests/ros/test_shares_2.py": SHARES_MASTER,
    "tests/ros/test_a.py": write_pid(2),
    "tests/ros/test_b.py": write_pid(2),
    "tests/unit/test_marked.py": MARKED,
    SKID: write_pid(1),
    "tests/ros/test_asks.py": ASKS_MASTER,
    "tests/ros/test_broken.py": f"LAUNCH = '<launch><nod</launch>'\n\n{PASSES}\n{PASSES}".replace(
        "test_it", "test_more", 1
    ),
    "tests/ros/test_beside.py": FAILS_BESIDE_LAUNCH,
    "tests/ros/test_dies.py": f"import os\n\ndef test_a():\n    os._exit(3)\n\n{PASSES}",
    "tests/ros/test_leaves.py": LEAVES_CHILD,
    "tests/ros/test_waits.py": f"import time\nimport pytest\n\n@pytest.mark.timeout(8)\n"
    f"def test_a():\n    time.sleep(600)\n\n{PASSES}",
}


class Groups:
    """One run of many files.

    Attributes:
        root: The checkout.
        status, output: Of pytest.
        cases: dict of test -> what went wrong, a list of (tag, text), as in JUnit's file.
    """

    def __init__(self, project):
        for path, text in GROUPS.items():
            project.add(path, text)
        report = project.root / "junit.xml"
        # roslaunch itself gives a node 15 s after its SIGINT
        project.environment["PADDOCK_TEST_GRACE"] = "30"
        options = ("--numprocesses=2", "-o", "timeout=300", f"--junitxml={report}")
        self.root, self._notes = project.root, project.notes
        files = [path for path in GROUPS if "/test_" in path]
        self.status, self.output = project.run(*options, *files)
        self.cases = {}
        for case in ElementTree.parse(report).iter("testcase"):
            name = f"{case.get('classname')}.{case.get('name')}"
            self.cases.setdefault(name, []).extend(
                (problem.tag, f"{problem.get('message')}\n{problem.text}") for problem in case
            )

    def problems(self, name):
        """What went wrong with the tests of a file: list of (tag, text)."""
        found = [case for test, case in self.cases.items() if f".test_{name}." in test]
        assert found, self.output
        return [problem for case in found for problem in case]

    def notes(self, name):
        """Words that the tests of a file have noted, a list for each line."""
        lines = [line.split() for line in self._notes.read_text().splitlines()]
        return [words[1:] for words in lines if words[0].endswith(f"test_{name}.py")]


@pytest.fixture(scope="module")
def groups(tmp_path_factory):
    return Groups(Project(tmp_path_factory.mktemp("groups")))


def test_each_file_has_a_process_and_a_master_port_of_its_own(groups):
    first, second = groups.notes("a"), groups.notes("b")
    assert first[0] == first[1] and second[0] == second[1]
    assert first[0][0] != second[0][0] and first[0][1] != second[0][1]


def test_files_of_a_world_have_processes_of_their_own_on_one_master(groups):
    assert groups.problems("shares_1") == groups.problems("shares_2") == []
    (first,), (second,) = groups.notes("shares_1"), groups.notes("shares_2")
    assert first[0] != second[0] and first[1] == second[1]
    assert {first[2], second[2]} == {"1", "2"}
    assert (groups.root / "test-results" / "ros" / "box" / "launch.log").exists()


def test_a_marked_file_has_a_process_of_its_own(groups):
    [usual], marked = groups.notes("skid"), groups.notes("marked")
    assert usual[2].startswith("gw")  # it runs in a process of pytest-xdist
    assert marked[0] == marked[1] and marked[0][0] != usual[0] and marked[0][2] == "None"


def test_the_launch_runs_meanwhile_and_its_parameters_are_set_before(groups):
    assert groups.problems("asks") == []


def test_a_marked_test_may_take_longer_than_the_others(tmp_path):
    project = Project(tmp_path)
    project.add(
        "tests/ros/test_slow.py",
        "import time\nimport pytest\n\n@pytest.mark.timeout(200)\n"
        "def test_a():\n    time.sleep(6)\n",
    )
    project.environment["PADDOCK_TEST_GRACE"] = "3"  # 1 s + 3 s are less than 6 s
    status, output = project.run("--numprocesses=1", "-o", "timeout=1", "tests/ros")
    assert status == 0, output


def test_a_launch_that_cannot_start_is_shown(groups):
    problems = groups.problems("broken")
    assert [tag for tag, _ in problems] == ["failure"] * 2
    assert all("the launch does not come up" in text for _, text in problems)


def test_a_failure_shows_what_the_launch_printed_during_the_test(groups):
    [(tag, text)] = groups.problems("beside")
    assert tag == "failure" and "assert (6 * 7) == 41" in text
    assert "rospy_tutorials_of_nobody" in groups.output
    log = groups.root / "test-results" / "ros" / "beside" / "launch.log"
    assert "rospy_tutorials_of_nobody" in log.read_text()
    [first, *_] = re.findall(r".*the motor is hot", groups.output.split("errors of nodes")[1])
    assert " WARN /motor " in first and "[topics:" not in first


def test_a_process_that_dies_fails_its_tests_and_no_others(groups):
    problems = groups.problems("dies")
    assert [tag for tag, _ in problems] == ["failure"] * 2
    assert "the test process has ended, exit status 3" in problems[0][1]


def test_what_a_file_leaves_behind_is_ended_and_an_error(groups):
    [(tag, text)] = groups.problems("leaves")
    assert tag == "error" and "left processes behind" in text and "time.sleep(600)" in text
    [[pid]] = groups.notes("leaves")
    assert not is_running(int(pid))


def test_a_test_that_does_not_end_fails_with_its_stack_and_the_next_one_runs(groups):
    [(tag, text)] = groups.problems("waits")
    assert tag == "failure" and "time.sleep(600)" in text


def test_the_sum_and_junit_have_the_cases_of_all_processes(groups):
    assert groups.status == 1 and "6 failed, 12 passed, 1 error" in groups.output
    assert len(groups.cases) == 18


def test_files_of_one_process_and_of_their_own_take_turns(project):
    """Folders have to be left and entered: pytest keeps a stack of them."""
    files = (
        "tests/unit/test_d.py",
        "tests/ros/test_b.py",
        "src/a/test/test_a.py",
        "tests/ros/test_e.py",
        "src/c/test/test_c.py",
    )
    for path in files:
        project.add(path)
    conftest = project.root / "conftest.py"  # without the plugin that puts the longest first
    conftest.write_text(conftest.read_text().replace('"selection", ', ""))
    status, output = project.run(*files)
    assert status == 0 and "5 passed" in output, output


def test_one_file_alone_runs_in_the_process_of_pytest(project):
    project.add("tests/ros/test_a.py", write_pid(1))
    process = project.start("tests/ros")
    output, _ = process.communicate(timeout=DEADLINE)
    assert process.returncode == 0, output
    assert project.notes.read_text().split()[1] == str(process.pid)


@pytest.mark.parametrize(
    ("number", "options"),
    [
        (signal.SIGINT, ("--numprocesses=1",)),
        (signal.SIGTERM, ("--numprocesses=1",)),
        (signal.SIGTERM, (SKID,)),
        (signal.SIGINT, (SKID,)),  # a second file: one alone runs in the process of pytest
    ],
)
def test_an_interrupted_run_leaves_no_process(project, number, options):
    project.add("tests/ros/test_a.py", f'LAUNCH = "<launch></launch>"\n{WAITS_FOREVER}')
    project.add(SKID)
    process = project.start("tests/ros", *options)
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


def test_wall_times_are_kept(project):
    project.add(SKID)
    project.run("src")
    [file] = (project.root / ".pytest_cache").rglob("paddock/seconds")
    assert list(json.loads(file.read_text())) == [SKID]


def test_a_process_is_found_as_soon_as_it_is_started():
    for number in range(200):
        value = f"{os.getpid()}_{number}"
        with subprocess.Popen(
            ["sleep", "600"], start_new_session=True, env={**os.environ, "FOUND": value}
        ) as child:
            found = procfs.marked("FOUND", value)
            child.kill()
        assert found == [child.pid]
