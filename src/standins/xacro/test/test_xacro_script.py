"""The xacro command: $(find), arguments, encodings, errors."""

import os
import subprocess
import sys
import xml.etree.ElementTree as ElementTree

import pytest

pytest.importorskip("xacro")
SCRIPT = os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(__file__))), "xacro")
PACKAGE_XML = """<package format="2"><name>some_car</name><version>0.0.1</version>
<description>test</description><maintainer email="a@b.org">a</maintainer>
<license>BSD</license></package>"""
PART = """<robot xmlns:xacro="http://www.ros.org/wiki/xacro">
<xacro:macro name="part" params="name"><link name="${name}"/></xacro:macro></robot>"""
CAR = """<?xml version="1.0" encoding="utf-8"?>
<robot name="car" xmlns:xacro="http://www.ros.org/wiki/xacro">
<xacro:arg name="root" default="base"/>
<xacro:include filename="$(find some_car)/part.xacro"/>
<xacro:part name="$(arg root)"/><!-- M\u00fcller -->
</robot>"""


@pytest.fixture(name="package")
def _package(tmp_path):
    folder = tmp_path / "some_car"
    folder.mkdir()
    for name, text in (("package.xml", PACKAGE_XML), ("part.xacro", PART), ("car.xacro", CAR)):
        (folder / name).write_text(text, encoding="utf-8")
    return folder


def _run(package, *args, script=SCRIPT, **variables):
    env = dict(os.environ, ROS_PACKAGE_PATH=str(package.parent))
    env.update((name, str(value)) for name, value in variables.items())
    return subprocess.run(
        [sys.executable, script, *map(str, args)],
        env=env,
        timeout=90,
        capture_output=True,
        check=False,
    )


@pytest.mark.parametrize("script", [SCRIPT, SCRIPT + ".py"])
def test_find_is_answered_by_ros_package_path(package, script):
    result = _run(package, "--inorder", package / "car.xacro", script=script)
    assert result.returncode == 0, result.stderr
    assert ElementTree.fromstring(result.stdout).find("link").get("name") == "base"
    assert result.stderr == b""


def test_mapping_and_output_file(package, tmp_path):
    out = tmp_path / "car.urdf"
    result = _run(package, package / "car.xacro", "root:=chassis", "-o", out)
    assert result.returncode == 0, result.stderr
    assert ElementTree.parse(str(out)).find("link").get("name") == "chassis"


def test_unknown_package_is_named(package):
    (package / "bad.xacro").write_text(CAR.replace("find some_car", "find no_such_car"), "utf-8")
    result = _run(package, package / "bad.xacro")
    assert result.returncode != 0
    assert b"no_such_car" in result.stderr and b"Traceback" not in result.stderr
    assert result.stdout == b""


def test_a_missing_file_is_named(package):
    result = _run(package, package / "gone.xacro")
    assert result.returncode != 0
    assert b"gone.xacro" in result.stderr and b"Traceback" not in result.stderr


def test_arguments_of_a_macro_of_an_include_with_ns_are_those_of_its_namespace(package):
    head = '<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro">'
    (package / "wheel.xacro").write_text(
        f'{head}<xacro:property name="side" value="left"/><xacro:macro name="wheel" '
        'params="name"><link name="${name}"/></xacro:macro></robot>'
    )
    (package / "ns.xacro").write_text(
        f'{head}<xacro:include filename="wheel.xacro" ns="w"/><xacro:property name="own" '
        'value="hub"/><xacro:w.wheel name="${side}_${own}"/></robot>'
    )
    result = _run(package, package / "ns.xacro")
    assert result.returncode == 0, result.stderr
    assert ElementTree.fromstring(result.stdout).find("link").get("name") == "left_hub"


def test_the_library_of_a_ros_that_has_xacro_itself_is_left_as_it_is(package, tmp_path):
    library = tmp_path / "library" / "xacro"
    library.mkdir(parents=True)
    library.joinpath("__init__.py").write_text(
        "import sys\n\n\ndef main():\n    print(*sys.argv[1:])\n", "utf-8"
    )
    for script in (SCRIPT, SCRIPT + ".py"):
        result = _run(package, "--inorder", "car.xacro", script=script, PYTHONPATH=library.parent)
        assert (result.stdout, result.stderr) == (b"car.xacro\n", b"")
