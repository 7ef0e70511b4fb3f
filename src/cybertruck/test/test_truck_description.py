"""The expanded description against the spec, its YAML files and its own meshes."""

import math
import pathlib
import re
import xml.etree.ElementTree as ET

import numpy as np
import pytest
import xacro
import yaml
from cybertruck.drive.model import TruckGeometry

PACKAGE = pathlib.Path(__file__).resolve().parents[1]
SHAPE = TruckGeometry()
WHEELS = [f"{end}_{side}_wheel" for end in ("front", "rear") for side in ("left", "right")]
TRAILER_WHEELS = ["trailer_left_wheel", "trailer_right_wheel"]


def expand(**arguments):
    path = PACKAGE / "urdf" / "cybertruck.urdf.xacro"
    return ET.fromstring(xacro.process_file(str(path), mappings=arguments).toxml())


@pytest.fixture(scope="module")
def robot():
    return expand(trailer_lidar="true")


def triangles(name):
    """Corners of a mesh's triangles (N, 3, 3) [m]."""
    text = (PACKAGE / "meshes" / f"{name}.obj").read_text()
    points = np.array([line.split()[1:] for line in text.splitlines() if line[:2] == "v "], float)
    faces = [re.findall(r"(\d+)//", line) for line in text.splitlines() if line[:2] == "f "]
    return points[np.array(faces, int) - 1]


def numbers(text):
    return np.array([float(word) for word in text.split()])


def position(robot, link):
    """Where a link is with all joints at zero (3,) [m]; no joint is turned."""
    total = np.zeros(3)
    while link != "base_footprint":
        joint = next(j for j in robot.findall("joint") if j.find("child").get("link") == link)
        assert not numbers(joint.find("origin").get("rpy")).any()
        total += numbers(joint.find("origin").get("xyz"))
        link = joint.find("parent").get("link")
    return total


@pytest.mark.parametrize(
    "link, xyz",
    [
        ("base_link", (0, 0, 0.1016)),
        ("rear_left_wheel", (0, 0.215, 0.1016)),
        ("rear_right_wheel", (0, -0.215, 0.1016)),
        ("front_left_wheel", (0.508, 0.215, 0.1016)),
        ("front_right_wheel", (0.508, -0.215, 0.1016)),
        ("hitch", (-0.30, 0, 0.14)),
        ("trailer_link", (-0.30, 0, 0.14)),
        ("trailer_axle", (-1.0, 0, 0)),
        ("trailer_left_wheel", (-1.0, 0.215, 0.1016)),
        ("trailer_right_wheel", (-1.0, -0.215, 0.1016)),
        ("lidar_link", (0.30, 0, 0.435)),
        ("trailer_lidar_link", (-0.90, 0, 0.665)),
    ],
)
def test_where_things_are(robot, link, xyz):
    assert position(robot, link) == pytest.approx(np.array(xyz), abs=1e-9)


@pytest.mark.parametrize(
    "name, kind, axis, limits",
    [
        ("front_left_steer_joint", "revolute", (0, 0, 1), (-1.2, 1.2)),
        ("front_right_steer_joint", "revolute", (0, 0, 1), (-1.2, 1.2)),
        ("hitch_yaw_joint", "revolute", (0, 0, 1), (-math.radians(80), math.radians(80))),
        ("hitch_pitch_joint", "revolute", (0, 1, 0), (-0.35, 0.35)),
        *[(name + "_joint", "continuous", (0, 1, 0), None) for name in WHEELS + TRAILER_WHEELS],
    ],
)
def test_joints(robot, name, kind, axis, limits):
    joint = robot.find(f"joint[@name='{name}']")
    assert joint.get("type") == kind
    assert tuple(numbers(joint.find("axis").get("xyz"))) == axis
    if limits:
        limit = joint.find("limit")
        assert (float(limit.get("lower")), float(limit.get("upper"))) == pytest.approx(limits)


@pytest.mark.parametrize("name", WHEELS + TRAILER_WHEELS)
def test_wheels(robot, name):
    link = robot.find(f"link[@name='{name}']")
    cylinder = link.find("collision/geometry/cylinder")
    radius, width = SHAPE.wheel_radius, SHAPE.wheel_width
    assert (float(cylinder.get("radius")), float(cylinder.get("length"))) == (radius, 0.002)
    mass = float(link.find("inertial/mass").get("value"))
    inertia = link.find("inertial/inertia")
    assert mass == pytest.approx(600 * math.pi * radius**2 * width)
    assert float(inertia.get("iyy")) == pytest.approx(mass * radius**2 / 2)
    assert float(inertia.get("izz")) == pytest.approx(mass * (3 * radius**2 + width**2) / 12)


@pytest.mark.parametrize(
    "link, parts, density, offset",
    [
        ("base_link", ("shell", "sides", "trim"), 210, (0.0, 0.0, -0.1016)),
        ("trailer_link", ("trailer_box", "trailer_trim"), 60, (-0.70, 0.0, -0.14)),
    ],
)
def test_mass_and_inertia_are_those_of_the_volume(robot, link, parts, density, offset):
    """A homogeneous body of the meshes' shape, by sums over tetrahedra, within a fifth."""
    mass, first, second = 0.0, np.zeros(3), np.zeros((3, 3))
    for part in parts:
        corners = triangles(part) + np.array(offset)
        volumes = np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6.0
        sums = corners.sum(axis=1)
        mass += density * volumes.sum()
        first += density * (volumes[:, None] * sums / 4.0).sum(axis=0)
        second += density * np.einsum(
            "n,nij->ij",
            volumes / 20.0,
            np.einsum("nki,nkj->nij", corners, corners) + np.einsum("ni,nj->nij", sums, sums),
        )
    center = first / mass
    second -= mass * np.outer(center, center)
    inertia = np.trace(second) * np.eye(3) - second
    inertial = robot.find(f"link[@name='{link}']/inertial")
    stated = inertial.find("inertia")
    assert float(inertial.find("mass").get("value")) == pytest.approx(mass, rel=0.1)
    assert numbers(inertial.find("origin").get("xyz")) == pytest.approx(center, abs=0.03)
    assert [float(stated.get(key)) for key in ("ixx", "iyy", "izz")] == pytest.approx(
        np.diag(inertia), rel=0.2
    )


def test_links_without_mass_are_on_fixed_joints(robot):
    fixed = {
        j.find("child").get("link") for j in robot.findall("joint") if j.get("type") == "fixed"
    }
    bare = {link.get("name") for link in robot.findall("link") if link.find("inertial") is None}
    assert bare - fixed == {"base_footprint"}


def test_the_box_passes_the_truck_at_any_angle(robot):
    """Its front is farther behind the hitch than the truck's corners are away from it."""
    box = robot.find("link[@name='trailer_link']/collision[@name='box']")
    front = (
        numbers(box.find("origin").get("xyz"))[0]
        + numbers(box.find("geometry/box").get("size"))[0] / 2
    )
    x, y, _ = triangles("shell").reshape(-1, 3).T
    corner = math.hypot(-SHAPE.hitch_offset - x.min(), y.max())
    assert -front > corner + 0.02


def test_the_lidar_is_above_the_truck_and_below_the_trailers_roof(robot):
    beams = position(robot, "lidar_link")[2]
    truck, trailer = (triangles(name)[..., 2].max() for name in ("shell", "trailer_box"))
    assert truck + 0.05 < beams < trailer - 0.05
    assert position(robot, "trailer_lidar_link")[2] > trailer + 0.05


@pytest.mark.parametrize(
    "link, topic", [("lidar_link", "/scan"), ("trailer_lidar_link", "/trailer_scan")]
)
def test_lidar(robot, link, topic):
    sensor = robot.find(f"gazebo[@reference='{link}']/sensor")
    values = {
        tag: float(sensor.find(".//" + tag).text)
        for tag in ("samples", "min", "max", "update_rate", "stddev")
    }
    assert values == {"samples": 360, "min": 0.12, "max": 3.5, "update_rate": 5, "stddev": 0.01}
    angles = [float(sensor.find(".//" + tag).text) for tag in ("min_angle", "max_angle")]
    assert (angles[1] - angles[0]) / 359 == pytest.approx(math.radians(1.0))
    assert (sensor.find("plugin/topicName").text, sensor.find("plugin/frameName").text) == (
        topic,
        link,
    )


@pytest.mark.parametrize(
    "arguments, missing",
    [
        ({"trailer": "false"}, ("trailer_link", "hitch", "trailer_lidar_link", "trailer_axle")),
        ({"lidar": "false"}, ("lidar_link",)),
        ({}, ("trailer_lidar_link",)),
        ({"trailer": "false", "trailer_lidar": "true"}, ("trailer_lidar_link",)),
    ],
)
def test_arguments_leave_parts_out(arguments, missing):
    names = {link.get("name") for link in expand(**arguments).findall("link")}
    assert names.isdisjoint(missing)
    assert {"base_footprint", "base_link", "rear_left_wheel"} <= names
    assert ("trailer_link" in names) == (arguments.get("trailer") != "false")


def test_plugins(robot):
    plugins = {item.get("filename"): item for item in robot.findall("gazebo/plugin")}
    assert plugins["libgazebo_ros_control.so"].find("robotNamespace").text == "/cybertruck"
    truth = {child.tag: child.text for child in plugins["libgazebo_ros_p3d.so"]}
    assert (truth["topicName"], truth["bodyName"], truth["twistFrame"], truth["updateRate"]) == (
        "/ground_truth/odom",
        "base_footprint",
        "child",
        "125",
    )


def test_controllers_match_joints_and_transmissions(robot):
    text = (PACKAGE / "config" / "controllers.yaml").read_text()
    controllers = yaml.safe_load(text)["cybertruck"]
    interfaces = {
        item.find("joint").get("name"): item.find("joint/hardwareInterface").text
        for item in robot.findall("transmission")
    }
    free = [name for name, interface in interfaces.items() if "Effort" in interface]
    driven = {name: item for name, item in interfaces.items() if name not in free}
    assert driven == {
        **{
            f"front_{side}_steer_joint": "hardware_interface/PositionJointInterface"
            for side in ("left", "right")
        },
        **{
            f"rear_{side}_wheel_joint": "hardware_interface/VelocityJointInterface"
            for side in ("left", "right")
        },
    }
    named = [joint for item in controllers.values() for joint in item.get("joints", ())]
    assert sorted(named) == sorted(driven)
    moving = {j.get("name") for j in robot.findall("joint") if j.get("type") != "fixed"}
    assert moving == set(interfaces)  # so that joint_states has what robot_state_publisher needs
    assert controllers["joint_state_controller"]["publish_rate"] == 125


def test_meshes_exist(robot):
    uris = {mesh.get("filename") for mesh in robot.iter("mesh")}
    assert {uri.rsplit("/", 1)[1][:-4] for uri in uris} == {
        path.stem for path in (PACKAGE / "meshes").glob("*.obj")
    }
    for uri in uris:
        assert (PACKAGE / uri.replace("package://cybertruck/", "")).is_file()
