"""The tests' own plugins: in which processes tests run, and what is left of them."""

import xml.etree.ElementTree as ElementTree

import pytest
from plugin_rig import PASSES, Project
from testing import is_running

LEAVES_CHILD = """
import os, subprocess, sys

def test_it():
    child = subprocess.Popen([sys.executable, "-c", "import time; time.sleep(600)"],
                             start_new_session=True)
    with open(os.environ["NOTES"], "w") as stream:
        print(child.pid, file=stream)
"""
GROUPS = {
    "tests/ros/test_leaves.py": LEAVES_CHILD,
    "tests/ros/test_waits.py": f"import time\nimport pytest\n\n@pytest.mark.timeout(8)\n"
    f"def test_a():\n    time.sleep(600)\n\n{PASSES}",
}


@pytest.fixture(scope="module")
def problems(tmp_path_factory):
    """What went wrong in a run of these files: name -> list of (tag, text); and a noted pid."""
    project = Project(tmp_path_factory.mktemp("groups"))
    for path, text in GROUPS.items():
        project.add(path, text)
    report = project.root / "junit.xml"
    # roslaunch itself gives a node 15 s after its SIGINT
    project.environment["PADDOCK_TEST_GRACE"] = "30"
    options = ("--numprocesses=2", "-o", "timeout=300", f"--junitxml={report}")
    _, output = project.run(*options, *GROUPS)
    found = {}
    for case in ElementTree.parse(report).iter("testcase"):
        name = case.get("classname").rpartition(".test_")[2]
        found.setdefault(name, []).extend(
            (problem.tag, f"{problem.get('message')}\n{problem.text}") for problem in case
        )
    assert set(found) == {"leaves", "waits"}, output
    return {**found, "pid": int(project.notes.read_text())}


def test_what_a_file_leaves_behind_is_ended_and_an_error(problems):
    [(tag, text)] = problems["leaves"]
    assert tag == "error" and "left processes behind" in text and "time.sleep(600)" in text
    assert not is_running(problems["pid"])


def test_a_test_that_does_not_end_fails_with_its_stack_and_the_next_one_runs(problems):
    [(tag, text)] = problems["waits"]
    assert tag == "failure" and "time.sleep(600)" in text
