"""The expanded description has the published numbers."""

import math
import pathlib
import xml.etree.ElementTree as ET

import pytest
import yaml

xacro = pytest.importorskip("xacro")

PACKAGE = pathlib.Path(__file__).resolve().parents[1]
WHEELS = ["left_rear_wheel", "right_rear_wheel", "left_front_wheel", "right_front_wheel"]
HINGES = ["left_steering_hinge", "right_steering_hinge"]


def expand(package, **arguments):
    path = str(package / "urdf" / "racecar.urdf.xacro")
    return ET.fromstring(xacro.process_file(path, mappings=arguments).toxml())


@pytest.fixture(scope="module")
def robot():
    return expand(PACKAGE)


def numbers(text):
    return [float(word) for word in text.split()]


def joint(robot, name):
    return robot.find(f"joint[@name='{name}']")


def link(robot, name):
    return robot.find(f"link[@name='{name}']")


@pytest.mark.parametrize(
    "name, parent, child, xyz, rpy",
    [
        ("chassis_joint", "base_link", "chassis", (0, 0, 0.023249), (0, 0, 0)),
        (
            "left_rear_wheel_joint",
            "chassis",
            "left_rear_wheel",
            (-0.081663, 0.08105, 0.01575),
            None,
        ),
        (
            "right_rear_wheel_joint",
            "chassis",
            "right_rear_wheel",
            (-0.081663, -0.08105, 0.01575),
            None,
        ),
        (
            "left_steering_hinge_joint",
            "chassis",
            "left_steering_hinge",
            (0.082311, 0.079601, 0.011759),
            None,
        ),
        (
            "right_steering_hinge_joint",
            "chassis",
            "right_steering_hinge",
            (0.082311, -0.079601, 0.011759),
            None,
        ),
        ("left_front_wheel_joint", "left_steering_hinge", "left_front_wheel", (0, 0, 0), None),
        ("right_front_wheel_joint", "right_steering_hinge", "right_front_wheel", (0, 0, 0), None),
        (
            "zed_camera_link_joint",
            "chassis",
            "zed_camera_link",
            (0.091711, 0, 0.080023),
            (0, 0.2618, 0),
        ),
        ("camera_link_joint", "zed_camera_link", "camera_link", (0.044755, 0, 0.04), (0, 0, 0)),
        (
            "camera_optical_link_joint",
            "camera_link",
            "camera_optical_link",
            (0, 0, 0),
            (-math.pi / 2, 0, -math.pi / 2),
        ),
    ],
)
def test_joint_origins(robot, name, parent, child, xyz, rpy):
    element = joint(robot, name)
    assert element.find("parent").get("link") == parent
    assert element.find("child").get("link") == child
    assert numbers(element.find("origin").get("xyz")) == pytest.approx(xyz)
    assert numbers(element.find("origin").get("rpy")) == pytest.approx(rpy or (0, 0, 0))


@pytest.mark.parametrize(
    "name, mass, ixx, iyy, izz",
    [
        ("chassis", 1.9068, 0.004151895, 0.010379737, 0.010379737),
        *[(name, 0.042222, 6.11771e-5, 9.44606e-5, 6.11771e-5) for name in WHEELS],
        *[(name, 0.05, 1e-5, 1e-5, 1e-5) for name in HINGES],
    ],
)
def test_masses(robot, name, mass, ixx, iyy, izz):
    inertial = link(robot, name).find("inertial")
    inertia = inertial.find("inertia")
    assert float(inertial.find("mass").get("value")) == mass
    assert [float(inertia.get(key)) for key in ("ixx", "iyy", "izz")] == [ixx, iyy, izz]
    assert [float(inertia.get(key)) for key in ("ixy", "ixz", "iyz")] == [0, 0, 0]


def test_every_link_but_the_root_has_mass(robot):
    bare = [item.get("name") for item in robot.findall("link") if item.find("inertial") is None]
    assert bare == ["base_link"]


@pytest.mark.parametrize("name", WHEELS)
def test_wheel(robot, name):
    collision = link(robot, name).find("collision")
    cylinder = collision.find("geometry/cylinder")
    assert (cylinder.get("radius"), cylinder.get("length")) == ("0.03", "0.004")
    assert numbers(collision.find("origin").get("rpy")) == pytest.approx((math.pi / 2, 0, 0))
    element = joint(robot, name + "_joint")
    assert element.get("type") == "continuous"
    assert numbers(element.find("axis").get("xyz")) == [0, 1, 0]
    assert [element.find("limit").get(key) for key in ("effort", "velocity")] == ["10", "100"]
    contact = robot.find(f"gazebo[@reference='{name}']")
    assert [float(contact.find(key).text) for key in ("mu1", "mu2")] == [0.5, 0.5]
    assert [float(contact.find(key).text) for key in ("kp", "kd")] == [1e6, 100.0]


@pytest.mark.parametrize("name", HINGES)
def test_hinge(robot, name):
    element = joint(robot, name + "_joint")
    limit = {key: float(value) for key, value in element.find("limit").attrib.items()}
    assert element.get("type") == "revolute"
    assert numbers(element.find("axis").get("xyz")) == [0, 0, 1]
    assert limit == {"lower": -1.0472, "upper": 1.0472, "effort": 10, "velocity": 100}
    assert limit["upper"] >= math.radians(60)


def test_one_transmission_a_movable_joint(robot):
    driven = {
        item.find("joint").get("name"): item.find("joint/hardwareInterface").text
        for item in robot.findall("transmission")
    }
    assert driven == {
        **{name + "_joint": "hardware_interface/VelocityJointInterface" for name in WHEELS},
        **{name + "_joint": "hardware_interface/PositionJointInterface" for name in HINGES},
    }


def test_chassis_clears_ground_and_wheels(robot):
    """At rest the lowest wheel touches at z 0.005 of base_link; 1.4 degrees cost 4 mm at most."""
    for collision in link(robot, "chassis").findall("collision"):
        z = numbers(collision.find("origin").get("xyz"))[2] + 0.023249
        _, width, height = numbers(collision.find("geometry/box").get("size"))
        bottom = z - height / 2.0
        assert bottom > 0.009 + 0.004 + 0.005
        # Either inside the wheels steered by 60 degrees, or above their tops.
        extent = 0.03 * math.sin(math.radians(60)) + 0.0125 * math.cos(math.radians(60))
        assert width / 2.0 < 0.079601 - extent or bottom > 0.01575 + 0.023249 + 0.03


def test_camera(robot):
    sensor = robot.find("gazebo[@reference='camera_link']/sensor")
    plugin = {item.tag: item.text for item in sensor.find("plugin")}
    assert sensor.find("camera/horizontal_fov").text == "1.13"
    assert sensor.find("plugin").get("filename") == "libgazebo_ros_camera.so"
    assert [sensor.find("camera/clip/" + key).text for key in ("near", "far")] == ["0.02", "300"]
    assert (
        plugin["robotNamespace"],
        plugin["cameraName"],
        plugin["imageTopicName"],
        plugin["cameraInfoTopicName"],
        plugin["frameName"],
    ) == ("/", "camera", "image", "camera_info", "camera_optical_link")


def test_lidar(robot):
    sensor = robot.find("gazebo[@reference='laser']/sensor")
    values = {
        tag: float(sensor.find(".//" + tag).text)
        for tag in ("samples", "min_angle", "max_angle", "min", "max", "update_rate", "stddev")
    }
    assert values == {
        "samples": 600,
        "min_angle": -2.61799,
        "max_angle": 2.61799,
        "min": 0.15,
        "max": 10,
        "update_rate": 10,
        "stddev": 0.01,
    }
    assert sensor.find("plugin/topicName").text == "/scan"


def test_arguments(package):
    robot = expand(
        package,
        lidar="false",
        camera_width="320",
        camera_height="240",
        camera_rate="15",
        robot_namespace="/other",
    )
    image = robot.find(".//sensor/camera/image")
    assert (image.find("width").text, image.find("height").text) == ("320", "240")
    assert robot.find(".//sensor/update_rate").text == "15"
    assert link(robot, "laser") is None and robot.find(".//sensor[@type='ray']") is None
    plugins = {item.get("filename"): item for item in robot.findall("gazebo/plugin")}
    assert plugins["libgazebo_ros_control.so"].find("robotNamespace").text == "/other"
    assert plugins["libgazebo_ros_p3d.so"].find("topicName").text == "/other/odom"


def test_meshes_exist(robot, package):
    uris = {mesh.get("filename") for mesh in robot.iter("mesh")}
    assert len(uris) == 8
    for uri in uris:
        assert (package / uri.replace("package://track_model/", "")).is_file()


def test_controllers_match_joints(robot, package):
    controllers = yaml.safe_load((package / "config" / "agent_control.yaml").read_text())["racecar"]
    joints = {item.get("name") for item in robot.findall("joint") if item.get("type") != "fixed"}
    assert {item["joint"] for item in controllers.values() if "joint" in item} == joints
    assert controllers["joint_state_controller"]["publish_rate"] == 50
    assert len(controllers) == 7
