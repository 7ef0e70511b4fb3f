"""Arguments of the launch files, and how stand-ins give way to real packages."""

import importlib.util
import os
import xml.etree.ElementTree as ElementTree

import pytest
import yaml

STANDINS = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
LAUNCH = os.path.join(STANDINS, "gazebo_ros", "launch")
NAMED_IN_FIND_PACKAGE = (
    "gazebo_ros gazebo_plugins gazebo_ros_control gazebo_dev controller_manager ros_control "
    "ros_controllers velocity_controllers position_controllers effort_controllers "
    "joint_state_controller diff_drive_controller ackermann_steering_controller "
    "four_wheel_steering_controller four_wheel_steering_msgs steer_bot_hardware_gazebo "
    "steer_drive_controller urdf_geometry_parser joint_trajectory_controller "
    "gripper_action_controller imu_sensor_controller force_torque_sensor_controller "
    "roboticsgroup_gazebo_plugins roboticsgroup_upatras_gazebo_plugins gazebo_ros_link_attacher "
    "hector_gazebo_plugins realsense_gazebo_plugin control_msgs cv_bridge ackermann_msgs "
    "gazebo_msgs xacro joy roslint geographic_msgs velodyne_description"
).split()
WITH_NODES = "state_publisher velodyne_description cv_bridge joy roslint geographic_msgs".split()


def _root(path):
    return ElementTree.parse(path).getroot()


@pytest.mark.parametrize("name", sorted(os.listdir(LAUNCH)))
def test_launch_files_are_xml(name):
    assert _root(os.path.join(LAUNCH, name)).tag == "launch"


@pytest.mark.parametrize("name", NAMED_IN_FIND_PACKAGE)
def test_package_exists_under_its_name(name):
    folder = os.path.join(STANDINS, name)
    assert _root(os.path.join(folder, "package.xml")).findtext("name") == name
    files = set(os.listdir(folder)) - {"package.xml", "CATKIN_IGNORE"}
    assert files == {"CMakeLists.txt"} or files >= {"CMakeLists.txt", "README.md"}


@pytest.mark.parametrize("name", sorted(WITH_NODES))
def test_package_says_what_it_leaves_out(name):
    words = _root(os.path.join(STANDINS, name, "package.xml")).findtext("description")
    assert "left out" in " ".join(words.lower().split())


def test_the_joint_state_controllers_default_configuration():
    path = os.path.join(STANDINS, "joint_state_controller", "joint_state_controller.yaml")
    with open(path, encoding="utf-8") as stream:
        assert yaml.safe_load(stream) == {
            "joint_state_controller": {
                "type": "joint_state_controller/JointStateController",
                "publish_rate": 50,
            }
        }


@pytest.fixture(name="give_way")
def _give_way():
    pytest.importorskip("rospkg")
    spec = importlib.util.spec_from_file_location("give_way", os.path.join(STANDINS, "give_way.py"))
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_give_way_marks_and_unmarks(give_way, tmp_path):
    for name in ("joy", "xacro"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "package.xml").write_text("<package/>")
    assert give_way.give_way(str(tmp_path), {"joy", "other"}) == ["joy"]
    assert (tmp_path / "joy" / "CATKIN_IGNORE").exists()
    assert give_way.give_way(str(tmp_path), set()) == []
    assert not (tmp_path / "joy" / "CATKIN_IGNORE").exists()


def test_links_to_the_stand_ins_are_no_real_packages(give_way, tmp_path):
    (tmp_path / "src").mkdir()
    (tmp_path / "src" / "joy").symlink_to(os.path.join(STANDINS, "joy"))
    real = tmp_path / "src" / "xacro"
    real.mkdir()
    (real / "package.xml").write_text("<package><name>xacro</name></package>")
    found = give_way.real_packages(["", str(tmp_path / "src"), STANDINS, str(tmp_path / "none")])
    assert found == {"xacro"}
