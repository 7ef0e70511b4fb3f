"""bench/environment_beside_launch.py: launch files of many kinds of robots as environments."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
pytestmark = pytest.mark.timeout(1800)


def compared(*words):
    """Exit code and output of the program for a launch file of the packages in tests/drop_in."""
    folders = f"{ROOT / 'tests' / 'drop_in'}{os.pathsep}{os.environ['ROS_PACKAGE_PATH']}"
    command = [sys.executable, str(ROOT / "bench" / "environment_beside_launch.py"), *words]
    result = subprocess.run(
        command, env=dict(os.environ, ROS_PACKAGE_PATH=folders), stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False,
    )  # fmt: skip
    return result.returncode, result.stdout


@pytest.mark.parametrize(
    "name, topics",
    [
        ("crab", {"/joint_states", "/crab_controller/odom"}),  # four steered wheels
        ("skid", {"/odom"}),  # skid_steer_drive
        ("tug", {"/joint_states", "/mobile_base_controller/odom"}),  # diff_drive_controller
        ("depot", {"/north/bumper", "/north/odom"}),  # planar_move, RealSense
    ],
)
def test_a_launch_file_is_the_same_as_an_environment(name, topics):
    code, text = compared("yard_fleet", f"{name}.launch", "--actions", "8", "--alone", "20")
    assert code == 0 and "not the same" not in text, text
    seen = {line.split(":")[0].strip() for line in text.splitlines() if "all the same" in line}
    assert topics <= seen, text
    assert "alone: 20 random actions" in text


def test_what_a_node_of_the_launch_file_does_is_a_difference():
    code, text = compared("yard_fleet", "sledge.launch", "--actions", "8")
    assert code == 1 and "WRONG: /odom: at " in text, text  # a node of it places the robot


def test_a_launch_file_that_is_not_there_is_named():
    code, text = compared("yard_fleet", "none.launch")
    assert code != 0 and "none.launch" in text
