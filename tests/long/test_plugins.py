"""The tests' own plugins: in which processes tests run, and what is left of them."""

import xml.etree.ElementTree as ElementTree

import pytest
from plugin_rig import PASSES, SKID, Project
from testing import is_running


def write_pid(count):
    """Text of a file of tests that note the process that they run in."""
    head = "import os\n\ndef note():\n    with open(os.environ['NOTES'], 'a') as stream:\n"
    head += "        print(__file__, os.getpid(), os.environ.get('ROS_MASTER_URI'),\n"
    head += "              os.environ.get('PYTEST_XDIST_WORKER'), file=stream)\n"
    return head + "".join(f"\ndef test_{number}():\n    note()\n" for number in range(count))


LEAVES_CHILD = """
import os, subprocess, sys

def test_it():
    child = subprocess.Popen([sys.executable, "-c", "import time; time.sleep(600)"],
                             start_new_session=True)
    with open(os.environ["NOTES"], "a") as stream:
        print(__file__, child.pid, file=stream)
"""
GROUPS = {
    "tests/ros/test_a.py": write_pid(2),
    "tests/ros/test_b.py": write_pid(2),
    SKID: write_pid(1),
    "tests/ros/test_broken.py": f"LAUNCH = '<launch><nod</launch>'\n\n{PASSES}\n{PASSES}".replace(
        "test_it", "test_more", 1
    ),
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


def test_a_launch_that_cannot_start_is_shown(groups):
    problems = groups.problems("broken")
    assert [tag for tag, _ in problems] == ["failure"] * 2
    assert all("the launch does not come up" in text for _, text in problems)


def test_what_a_file_leaves_behind_is_ended_and_an_error(groups):
    [(tag, text)] = groups.problems("leaves")
    assert tag == "error" and "left processes behind" in text and "time.sleep(600)" in text
    [[pid]] = groups.notes("leaves")
    assert not is_running(int(pid))


def test_a_test_that_does_not_end_fails_with_its_stack_and_the_next_one_runs(groups):
    [(tag, text)] = groups.problems("waits")
    assert tag == "failure" and "time.sleep(600)" in text
