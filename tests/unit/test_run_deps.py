"""./run deps: package.xml files read, names looked up, the four lists, and a real answer."""

import hashlib
import json
import os
import pickle
import re

import pytest
from run_rig import ROOT, ran, run

from commands import paths
from commands.bootstrap import ros
from commands.bootstrap import workspace as workspace_module
from commands.errors import UsageError
from commands.subcommands import deps

CAR = """<package format="3">
  <name>my_car</name>
  <buildtool_depend>catkin</buildtool_depend>
  <depend>my_msgs</depend>
  <depend>gazebo_ros</depend>
  <depend>rospy</depend>
  <exec_depend>move_base_msgs</exec_depend>
  <depend>laser_driver</depend>
  <depend condition="$ROS_VERSION == 2">rclpy</depend>
  <depend condition="$ROS_VERSION == 1">python-numpy</depend>
</package>"""
DEBIAN = {"catkin", "python3-rospy", "librospy-dev", "python3-numpy"}
INSTALLABLE = DEBIAN | {"libmove-base-msgs-dev", "python3-move-base-msgs", "ros-move-base-msgs"}


@pytest.fixture
def workspace(tmp_path):
    """A workspace with my_car, my_msgs, a build and a folder that catkin ignores."""
    texts = {"src/my_car": CAR}
    for place in ("src/my_msgs", "src/old", "build/copy", "src/my_car/inner"):
        texts[place] = f"<package><name>{place.split('/')[-1]}</name></package>"
    for place, text in texts.items():
        (tmp_path / place).mkdir(parents=True, exist_ok=True)
        (tmp_path / place / "package.xml").write_text(text)
    (tmp_path / "src" / "old" / "CATKIN_IGNORE").write_text("")
    return tmp_path


@pytest.fixture
def debians_ros(monkeypatch):
    """None is sourced and none remembered, wherever the tests run."""
    monkeypatch.setattr(ros, "prefix", lambda: "")


def find(workspace, *known):
    """What deps finds where Debian has some more packages to install."""
    existing = {*INSTALLABLE, *known}.intersection
    paddock = {"gazebo_ros", "cv_bridge"}
    return deps.find(str(workspace), existing, DEBIAN.intersection, paddock)


def test_the_four_lists(workspace, debians_ros):
    found = find(workspace)
    assert found.packages == ["my_car", "my_msgs"]
    assert (found.here, found.paddock) == (["my_msgs"], ["gazebo_ros"])
    assert list(found.installed) == ["catkin", "python-numpy", "rospy"]
    names = ["libmove-base-msgs-dev", "python3-move-base-msgs", "ros-move-base-msgs"]
    assert found.missing == {"move_base_msgs": names}
    assert found.nowhere == {"laser_driver": ["my_car"]}
    lines = deps.page(found)
    assert f"  apt-get install --no-install-recommends {' '.join(names)}" in lines
    assert lines[-2:] == ["neither in Debian nor in Paddock:", "  laser_driver, for my_car"]
    found.nowhere = {"move_base": ["my_car"], "slam_toolbox": ["my_car"]}
    assert deps.page(found)[-3:] == [
        "  move_base, for my_car: ./run add move_base",
        "  slam_toolbox, for my_car: ./run add slam_toolbox",
        "  ./run add --for PATH brings all of these at once",
    ]


NAMES = {
    "tf": ["libtf-dev", "python3-tf", "tf-tools"],  # and never tf, which is a game
    "tf2_py": ["python3-tf2"],
    "pluginlib": ["pluginlib-dev"],
    "gtest": ["libgtest-dev"],
    "sdl-image": ["libsdl-image1.2-dev"],
    "eigen": ["libeigen3-dev"],
    "gtk3": ["libgtk-3-dev"],
    "libturbojpeg": ["libturbojpeg0-dev"],  # by a rule for any Debian that has no own one
    "python-yaml": ["python3-yaml"],
    "python3-scipy": ["python3-scipy"],
    "libjpeg-dev": ["libjpeg-dev"],
    "move_base": [],
}


def test_what_only_build_and_launch_files_ask_for(workspace, debians_ros):
    car = workspace / "src" / "my_car"
    (car / "CMakeLists.txt").write_text(
        "find_package(catkin REQUIRED COMPONENTS rospy cv_bridge image_transport)\n"
    )
    (car / "launch" / "more").mkdir(parents=True)
    (car / "launch" / "more" / "go.launch").write_text(
        "<launch><!-- <node pkg='amcl' type='amcl' name='a'/> -->\n"
        "<node name='nav' pkg = \"move_base\" type='move_base'/>\n"
        "<node pkg='rviz' type='rviz' name='r' args='-d $(find my_msgs)/a.rviz'/>\n"
        "<include file='$(find their_arm)/launch/arm.launch'/></launch>\n"
    )
    image, rviz = ["image-transport-tools", "libimage-transport-dev"], ["rviz", "librviz-dev"]
    found = find(workspace, *image, *rviz)
    assert found.missing["image_transport"] == image
    assert found.launched == {"move_base": [], "rviz": rviz, "their_arm": []}
    assert deps.page(found)[-4:] == [
        "launch files also ask for:",
        "  move_base: ./run add move_base",
        "  rviz: apt-get install rviz librviz-dev",
        "  their_arm",
    ]


def test_cpp_needs_the_headers_that_a_stand_in_lacks(workspace, debians_ros):
    car = workspace / "src" / "my_car"
    (car / "CMakeLists.txt").write_text("find_package(catkin REQUIRED COMPONENTS cv_bridge)\n")
    names = deps.resolve(["cv_bridge"])["cv_bridge"]
    assert "libcv-bridge-dev" in names
    (car / "eye.py").write_text("import cv_bridge\n")
    found = find(workspace, *names)
    assert "cv_bridge" in found.paddock and "cv_bridge" not in found.missing
    (car / "eye.cpp").write_text("#include <cv_bridge/cv_bridge.h>\n")
    found = find(workspace, *names)
    assert found.missing["cv_bridge"] == names and "cv_bridge" not in found.paddock


CONDITIONS = {
    "": True,
    "$ROS_VERSION == 1": True,
    "$ROS_VERSION != '1'": False,
    "$ROS_PYTHON_VERSION == 2": False,  # wxpython, python-qt5-bindings ... of smach_viewer
    "$ROS_PYTHON_VERSION == &quot;3&quot;": True,
    "($ROS_DISTRO == noetic or $ROS_DISTRO == melodic) and $ROS_PYTHON_VERSION >= 3": True,
    "$ROS_DISTRO &lt; kinetic": False,
    "$NO_SUCH_NAME == 1": False,
    "$ROS_VERSION ==": True,  # catkin names it
}


def test_conditions_of_dependencies(tmp_path):
    asked = [f'<depend condition="{text}">b{n}</depend>' for n, text in enumerate(CONDITIONS)]
    manifest = tmp_path / "package.xml"
    manifest.write_text(f'<package format="3"><name>a</name>{"".join(asked)}</package>')
    name, wanted = deps.read_manifest(str(manifest))
    assert name == "a"
    assert wanted == {f"b{n}": ["depend"] for n, stands in enumerate(CONDITIONS.values()) if stands}


def test_names_of_debian():
    assert deps.resolve(NAMES) == NAMES
    text = paths.read(deps.OUR_LIST)
    ours = deps.resolve(re.findall(r"(?m)^([\w.-]+):", text))
    known = deps.existing({choice for choices in ours.values() for choice in choices})
    assert len(ours) > 30 and all(known & set(choices) for choices in ours.values())
    of_a_sourced_ros = deps.resolve(NAMES, debians_ros=False)
    assert of_a_sourced_ros["tf"] == [] and of_a_sourced_ros["eigen"] == ["libeigen3-dev"]


def test_a_name_that_is_listed_twice_is_ours_and_updated_sources_count(tmp_path):
    home = tmp_path / "ros"
    lookup = {"HOME": str(tmp_path), "ROS_HOME": str(home), "PATH": "/usr/bin:/bin"}
    (home / "rosdep" / "sources.cache").mkdir(parents=True)
    (home / "rosdep" / "sources.cache" / "index").write_text("yaml file:///mine.yaml \n")
    cached = f"{hashlib.sha1(b'file:///mine.yaml').hexdigest()}.pickle"
    rules = {"my_lib": {"debian": ["my-lib"]}, "eigen": {"debian": ["no-eigen"]}}
    (home / "rosdep" / "sources.cache" / cached).write_bytes(pickle.dumps(rules, 2))
    words = "/usr/bin/python3", "-I", deps.LOOKUP, "bookworm", deps.OUR_LIST, deps.ROSDEPS_LIST
    done = ran(*words, input=json.dumps(["my_lib", "eigen", "nowhere"]), env=lookup)
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout) == {"my_lib": ["my-lib"], "eigen": ["libeigen3-dev"]}


def test_a_pipe_and_folders_that_lead_into_themselves(tmp_path):
    """The pipe was waited for without end."""
    os.mkfifo(tmp_path / "package.xml")
    with pytest.raises(UsageError, match="package.xml is not XML"):
        deps.read_manifest(str(tmp_path / "package.xml"))
    assert workspace_module.manifests_of(str(tmp_path)) == {}
    assert paths.read(tmp_path / "package.xml") == ""
    (tmp_path / "package.xml").unlink()
    for name, target in (("a", "."), ("b", "a"), ("c", "c")):
        (tmp_path / name).symlink_to(target)
    with pytest.raises(UsageError, match="there is no package.xml"):
        deps.find_manifests(str(tmp_path))


@pytest.mark.parametrize("text, sentence", [
    ("<a", "is not XML"), ("<package/>", "has no <package> with a <name>"),
])  # fmt: skip
def test_what_is_no_package_xml(tmp_path, text, sentence):
    (tmp_path / "package.xml").write_text(text)
    with pytest.raises(UsageError, match=sentence):
        deps.read_manifest(str(tmp_path / "package.xml"))


def test_apt_and_dpkg_are_asked():
    names = ["cmake", "shellcheck", "python3-nosuchthing"]  # of config/apt.txt
    assert deps.existing(names) == {"cmake", "shellcheck"}
    assert deps.installed(names) == {"cmake", "shellcheck"}
    assert deps.existing([]) == set()


def test_a_real_package():
    done = run("deps", str(ROOT / "tests" / "drop_in"))
    if done.stderr:  # a container image without apt's lists
        assert "apt has no lists of packages" in done.stderr and done.returncode == 1
        return
    below = f"in {ros.prefix()}" if ros.prefix() else "installed from Debian"
    ours, found, theirs = done.stdout.partition(f"\n{below}: catkin, ")
    packages = "campus_rover, harbour_fleet, yard_fleet"
    assert ours.startswith(f"packages: {packages}\nin Paddock: ackermann_"), ours
    assert found and " gazebo_ros," in ours  # which is Paddock's also where the ROS has it
    assert "hector_gazebo_plugins" in done.stdout and "geometry_msgs" in theirs
    assert done.returncode == 0
