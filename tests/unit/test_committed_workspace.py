"""Workspaces of repositories that have committed what a build makes: src/CMakeLists.txt, build."""

import os
import subprocess

import pytest
from run_rig import ROOT, run

from commands.bootstrap import ros
from commands.subcommands import check

# ROS's own toplevel.cmake looks for catkin in the workspaces of CMAKE_PREFIX_PATH alone.
TOPLEVEL = """cmake_minimum_required(VERSION 3.0.2)
project(Project)
set(CATKIN_TOPLEVEL TRUE)
string(REPLACE ":" ";" CMAKE_PREFIX_PATH "$ENV{CMAKE_PREFIX_PATH}")
set(catkin_search_path "")
foreach(path ${CMAKE_PREFIX_PATH})
  if(EXISTS "${path}/.catkin")
    list(APPEND catkin_search_path ${path})
  endif()
endforeach()
set(CATKIN_TOPLEVEL_FIND_PACKAGE TRUE)
find_package(catkin REQUIRED NO_POLICY_SCOPE PATHS ${catkin_search_path}
  NO_DEFAULT_PATH NO_CMAKE_FIND_ROOT_PATH)
unset(CATKIN_TOPLEVEL_FIND_PACKAGE)
catkin_workspace()
"""
PACKAGE = """cmake_minimum_required(VERSION 3.0.2)
project(hill)
find_package(catkin REQUIRED COMPONENTS rospy)
catkin_package()
"""
MANIFEST = """<package format="2"><name>hill</name><version>1.0.0</version>
<description>a hill</description><maintainer email="a@b.cd">a</maintainer><license>BSD</license>
<buildtool_depend>catkin</buildtool_depend><build_depend>rospy</build_depend></package>
"""


@pytest.mark.skipif(bool(ros.prefix()), reason="a ROS that is sourced is a workspace itself")
def test_a_toplevel_file_that_is_committed_finds_catkin(tmp_path):
    source = tmp_path / "src"
    (source / "hill").mkdir(parents=True)
    (source / "CMakeLists.txt").write_text(TOPLEVEL)
    (source / "hill" / "CMakeLists.txt").write_text(PACKAGE)
    (source / "hill" / "package.xml").write_text(MANIFEST)
    devel = f"-DCATKIN_DEVEL_PREFIX={tmp_path}/devel"
    done = run("exec", "cmake", "-S", str(source), "-B", str(tmp_path / "build"), devel)
    assert done.returncode == 0, done.stdout + done.stderr
    script = '. "$0/devel/setup.bash" && rospack find hill'
    found = subprocess.run(["bash", "-c", script, str(tmp_path)], capture_output=True, text=True,
                           env={"PATH": "/usr/bin:/bin", "HOME": "/tmp"}, check=False)  # fmt: skip
    assert found.stdout.strip() == str(source / "hill"), found.stderr
    assert os.path.isfile(f"{ROOT}/devel/share/catkin/cmake/catkinConfig.cmake")


@pytest.mark.parametrize("home, is_stale", [("/home/ada/ws/src", True), (None, False)])
@pytest.mark.parametrize("folder", ["build", "devel"])
def test_a_build_of_another_machine_is_told_with_its_remedy(tmp_path, folder, home, is_stale):
    package = tmp_path / "src" / "course" / "hill"
    package.mkdir(parents=True)
    (tmp_path / folder).mkdir()
    home = home or f"{tmp_path}/src"
    cache = f"# For build in directory: x\nCMAKE_HOME_DIRECTORY:INTERNAL={home}\n"
    file, text = ("CMakeCache.txt", cache) if folder == "build" else (".catkin", home)
    (tmp_path / folder / file).write_text(text)
    said = check.built_elsewhere(str(package))
    assert said == (
        f"the workspace {tmp_path} was built as /home/ada/ws; catkin_make builds it after "
        f"rm -rf {tmp_path}/build {tmp_path}/devel"
        if is_stale
        else None
    )
    assert check.built_elsewhere(str(tmp_path / "src")) == said
