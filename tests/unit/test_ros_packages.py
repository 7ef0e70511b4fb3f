"""Nodes and modules that other people's launch files and nodes take from the ROS are there.

A ROS that is sourced may be without packages that Paddock works without, which ./run says; of these
nothing may be found, or it would come from another ROS.
"""

import importlib
import os
import shutil
import subprocess

import pytest
import run_rig  # noqa: F401 - puts the package commands on the path
from roslib import packages
from rospkg import ResourceNotFound

from commands.bootstrap import ros

# Names of packages: what the sourced ROS lacks and may lack.
LACKING = ros.lacking(ros.prefix())[1] if ros.prefix() else []
NODES = [
    ("image_transport", "republish"),
    ("joint_state_publisher", "joint_state_publisher"),
    ("joint_state_publisher_gui", "joint_state_publisher_gui"),
    ("nodelet", "nodelet"),
    ("robot_state_publisher", "robot_state_publisher"),
    ("robot_state_publisher", "state_publisher"),  # its name in older launch files
    ("tf", "static_transform_publisher"),
    ("tf", "tf_echo"),
    ("tf", "tf_monitor"),
    ("tf2_ros", "static_transform_publisher"),
    ("tf2_tools", "echo.py"),
    ("tf2_tools", "view_frames.py"),
    ("topic_tools", "drop"),
    ("topic_tools", "mux"),
    ("topic_tools", "relay"),
    ("topic_tools", "throttle"),
    ("topic_tools", "transform"),
]
MODULES = (
    "angles diagnostic_updater interactive_markers.interactive_marker_server laser_geometry "
    "map_msgs.msg message_filters move_base_msgs.msg tf tf.transformations tf2_geometry_msgs "
    "tf2_ros tf_conversions topic_tools.srv"
).split()
NAMED_IN_FIND_PACKAGE = (
    "angles camera_info_manager diagnostic_updater dynamic_reconfigure image_transport "
    "interactive_markers laser_geometry map_msgs message_filters move_base_msgs nodelet pluginlib "
    "robot_state_publisher tf tf2_ros tf_conversions topic_tools urdf"
).split()


@pytest.mark.parametrize("package, node", NODES)
def test_rosrun_finds_a_node(package, node):
    if package in LACKING:
        with pytest.raises(ResourceNotFound):
            packages.find_node(package, node)
    else:
        assert packages.find_node(package, node), f"{package} has no node {node}"


@pytest.mark.parametrize("node", ["robot_state_publisher", "state_publisher"])
def test_both_names_of_the_state_publisher_run_it(node):
    (program,) = packages.find_node("robot_state_publisher", node)
    environ = {**os.environ, "ROS_MASTER_URI": "http://127.0.0.1:1"}  # where nobody answers
    with subprocess.Popen([program], env=environ, text=True, stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT) as running:  # fmt: skip
        try:
            assert "Failed to contact master" in running.stdout.readline()
        finally:
            running.kill()


@pytest.mark.parametrize("name", MODULES)
def test_a_node_imports_a_module(name):
    if name.partition(".")[0] in LACKING:
        with pytest.raises(ModuleNotFoundError):
            importlib.import_module(name)
    else:
        assert importlib.import_module(name)


def test_tf_turns_quaternions():
    transformations = importlib.import_module("tf.transformations")
    quaternion = transformations.quaternion_from_euler(0.1, -0.2, 0.3)
    assert transformations.euler_from_quaternion(quaternion) == pytest.approx((0.1, -0.2, 0.3))


def test_find_package_finds_them(tmp_path):
    cmake = shutil.which("cmake")
    there = [name for name in NAMED_IN_FIND_PACKAGE if name not in LACKING]
    (tmp_path / "CMakeLists.txt").write_text(
        "cmake_minimum_required(VERSION 3.0.2)\nproject(some_car)\n"
        + "".join(f"find_package({name} REQUIRED)\n" for name in there)
    )
    done = subprocess.run(
        [cmake, "-S", str(tmp_path), "-B", str(tmp_path / "build")],
        capture_output=True,
        text=True,
        timeout=120,
    )
    assert done.returncode == 0, done.stderr
