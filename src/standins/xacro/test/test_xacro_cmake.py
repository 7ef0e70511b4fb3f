"""CMake's functions of the stand-in: files are generated into the devel and the install space."""

import subprocess

PACKAGE_XML = """<package format="2"><name>demo</name><version>0.0.1</version>
<description>test</description><maintainer email="a@b.org">a</maintainer><license>BSD</license>
<buildtool_depend>catkin</buildtool_depend><build_depend>xacro</build_depend></package>"""
CMAKE = """cmake_minimum_required(VERSION 3.10)
project(demo)
find_package(catkin REQUIRED COMPONENTS xacro)
catkin_package()
xacro_add_xacro_file(first.urdf.xacro OUTPUT made REMAP name:=left)
xacro_install(first ${made} DESTINATION urdf)
xacro_add_files(second.urdf.xacro TARGET second INSTALL DESTINATION urdf)
"""
ROBOT = """<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro">
<xacro:arg name="name" default="right"/><link name="$(arg name)"/></robot>"""


def test_files_are_generated_and_installed(tmp_path):
    source, build = tmp_path / "demo", tmp_path / "build"
    source.mkdir()
    (source / "package.xml").write_text(PACKAGE_XML)
    (source / "CMakeLists.txt").write_text(CMAKE)
    for name in ("first", "second"):
        (source / f"{name}.urdf.xacro").write_text(ROBOT)
    spaces = {name: tmp_path / name for name in ("devel", "install")}
    configure = [
        f"-DCATKIN_DEVEL_PREFIX={spaces['devel']}",
        f"-DCMAKE_INSTALL_PREFIX={spaces['install']}",
    ]
    for command in (
        ["cmake", "-S", source, "-B", build, *configure],
        ["cmake", "--build", build],
        ["cmake", "--install", build],
    ):
        done = subprocess.run(command, capture_output=True, text=True, timeout=300, check=False)
        assert done.returncode == 0, done.stdout + done.stderr
    for space in spaces.values():
        folder = space / "share" / "demo" / "urdf"
        assert '"left"' in (folder / "first.urdf").read_text()
        assert '"right"' in (folder / "second.urdf").read_text()
