"""./run ci: a package from nothing to JUnit files, what fails and what is no test at all."""

import pytest
from run_rig import run

PACKAGE = """<package format="2"><name>my_car</name><version>1.0.0</version>
<description>Mine</description><license>BSD</license>
<maintainer email="me@example.org">Me</maintainer>
<buildtool_depend>catkin</buildtool_depend><exec_depend>rospy</exec_depend></package>
"""
CMAKE = """cmake_minimum_required(VERSION 3.10)
project(my_car)
find_package(catkin REQUIRED)
catkin_package()
"""
UNIT = """import os, subprocess
def test_the_workspace_is_active():
    assert subprocess.check_output(["rospack", "find", "my_car"], text=True).strip()
    with open(os.environ["PADDOCK_RESULTS"] + "/film.mp4", "w") as film:
        film.write("a film")
"""
ROSTEST = '<launch><test test-name="n" pkg="my_car" type="node.py"/></launch>'
NODE = """#!/usr/bin/env python3
import unittest, rospy, rostest
class N(unittest.TestCase):
    def test_master(self):
        self.assertTrue(rospy.get_master().getPid())
    def test_number(self):
        self.assertEqual(1, {number})
rospy.init_node("n")
rostest.rosrun("my_car", "n", N)
"""


@pytest.fixture
def package(tmp_path):
    """A package of a unit test and a rostest."""
    folder = tmp_path / "my_car"
    (folder / "test").mkdir(parents=True)
    for name, text in {
        "package.xml": PACKAGE,
        "CMakeLists.txt": CMAKE,
        "test/test_unit.py": UNIT,
        "test/n.test": ROSTEST,
        "test/node.py": NODE.format(number=1),
    }.items():
        (folder / name).write_text(text)
    (folder / "test" / "node.py").chmod(0o755)
    return folder


def test_a_package_that_passes_that_fails_and_that_does_not_build(package, tmp_path):
    """One package changed twice: what is built already is not built again."""
    out = tmp_path / "results"
    done = run("ci", "--out", str(out), str(package))
    assert done.returncode == 0, done.stdout + done.stderr
    assert done.stdout.endswith(f"results in {out}/: 3 passed, 0 files failed\n")
    names = {path.name for path in out.iterdir()}
    assert {"film.mp4", "build.txt", "my_car-unit.xml", "my_car-unit.txt", "my_car-n.xml"} <= names
    assert [path for path in out.iterdir() if path.is_dir()] == []
    (package / "test" / "node.py").write_text(NODE.format(number=2))
    done = run("ci", "--out", str(out), str(package))
    assert done.returncode == 1 and done.stderr == "run: tests failed: my_car-n\n"
    assert "my_car-n ... FAILED" in done.stdout and "1 != 2" in done.stdout
    assert done.stdout.endswith(": 2 passed, 1 files failed\n")
    (package / "CMakeLists.txt").write_text(CMAKE + "find_package(no_such_thing REQUIRED)\n")
    done = run("ci", "--out", str(out), str(package))
    assert done.returncode == 1 and "no_such_thing" in done.stdout
    assert done.stderr.startswith("run: the packages do not build\n")


def test_what_is_refused(tmp_path):
    done = run("ci", str(tmp_path))
    assert (done.returncode, done.stderr) == (
        2,
        f"run: there is no package.xml at or below {str(tmp_path)!r}\n",
    )
    assert "path is '/nowhere'; it must be a folder" in run("ci", "/nowhere").stderr
