"""Plugins of hector, velodyne and gazebo_ros: what is read of them, and what they compute."""

import math

import numpy as np
import pytest
from bullet_sim.description.world import Place
from bullet_sim.formats.urdf import parse_urdf
from bullet_sim.plugins.drives import WheelDriveSpec
from bullet_sim.plugins.lidars import BlockCloudSpec, CloudSpec, RangeSpec, RaySpec
from bullet_sim.sensors import inertial
from bullet_sim.sensors.lidar import LayeredLidar

pytestmark = pytest.mark.usefixtures("sketches")

LINKS = (
    '<link name="base"/><link name="left"/><link name="right"/>'
    '<joint name="l" type="continuous"><parent link="base"/><child link="left"/></joint>'
    '<joint name="r" type="continuous"><parent link="base"/><child link="right"/></joint>'
)


def one(gazebo):
    """The one sensor of a robot, which must not warn."""
    model = parse_urdf(f'<robot name="r">{LINKS}<gazebo>{gazebo}</gazebo></robot>', str, "bot")
    assert model.warnings == []
    (spec,) = model.sensors
    return spec


def plugin(name, tags=""):
    return f'<plugin name="p" filename="lib{name}.so">{tags}</plugin>'


def ray(name, tags="", vertical="", width=(-1.0, 1.0)):
    return (
        '</gazebo><gazebo reference="base"><sensor type="ray" name="eye"><update_rate>10'
        "</update_rate><ray><scan><horizontal><samples>5</samples>"
        f"<min_angle>{width[0]}</min_angle><max_angle>{width[1]}</max_angle></horizontal>{vertical}"
        "</scan><range><min>0.1</min><max>20</max></range></ray>" + plugin(name, tags) + "</sensor>"
    )


VERTICAL = (
    "<vertical><samples>3</samples><min_angle>-0.2</min_angle><max_angle>0.1</max_angle></vertical>"
)


@pytest.mark.parametrize(
    "gazebo, kind, values",
    [
        (
            ray("gazebo_ros_velodyne_laser", "<min_range>0.5</min_range>", VERTICAL),
            CloudSpec,
            {"layers": 3, "min_elevation": -0.2, "max_elevation": 0.1, "range_min": 0.5,
             "range_max": 20.0},
        ),
        (ray("gazebo_ros_block_laser", vertical=VERTICAL), BlockCloudSpec, {"layers": 3}),
        (
            ray("gazebo_ros_range", "<radiation>ultrasound</radiation>"),
            RangeSpec,
            {"infrared": False, "topic": "/range"},
        ),
        (
            ray("hector_gazebo_ros_sonar", vertical=VERTICAL),
            RangeSpec,
            {"infrared": False, "field_of_view": pytest.approx(0.3)},
        ),
        (  # rays are samples times resolution, as Gazebo counts them
            ray("gazebo_ros_laser", "<topicName>scan</topicName><frameName/>").replace(
                "<samples>5</samples>", "<samples>820</samples><resolution>0.5</resolution>"),
            RaySpec,
            {"samples": 410, "topic": "/scan", "frame_id": ""},
        ),
        (
            plugin("gazebo_ros_diff_drive", "<leftJoint>l</leftJoint><rightJoint>r</rightJoint>"
                   "<legacyMode>false</legacyMode><publishWheelTF>true</publishWheelTF>"),
            WheelDriveSpec,
            {"wheel_frames": {"r": ("base", "right"), "l": ("base", "left")}},
        ),
    ],
)  # fmt: skip
def test_what_is_read(gazebo, kind, values):
    """Beside the single parameters of plugin_parameters.yaml."""
    spec = one(gazebo)
    assert type(spec) is kind and spec.name in ("p", "eye")
    assert {name: getattr(spec, name) for name in values} == values


def test_a_bodyname_that_is_no_link_costs_its_plugin_only():
    text = plugin("hector_gazebo_ros_gps", "<bodyName>nose</bodyName>")
    model = parse_urdf(f'<robot name="r">{LINKS}<gazebo>{text}</gazebo></robot>', str, "bot")
    assert model.sensors == [] and len(model.warnings) == 1 and "'nose'" in model.warnings[0]


def test_a_degree_of_latitude_is_that_of_the_ellipsoid():
    """Table values of WGS 84: 110.574 and 111.320 km at the equator, 111.132 and 78.847 at 45."""
    for latitude, north, east in ((0.0, 110574.0, 111320.0), (45.0, 111132.0, 78847.0)):
        found = [math.radians(1.0) * radius for radius in inertial.radii(latitude)]
        assert found == pytest.approx((north, east), abs=1.0)


@pytest.mark.parametrize(
    "heading, position, north, east",
    [
        (0.0, (100.0, 0.0, 5.0), 100.0, 0.0),
        (0.0, (0.0, 100.0, 5.0), 0.0, -100.0),  # y to the left of north is west
        (math.pi / 2, (100.0, 0.0, 5.0), 0.0, 100.0),
        (math.pi / 2, (0.0, 100.0, 5.0), 100.0, 0.0),
    ],
)
def test_a_fix(heading, position, north, east):
    per_north, per_east = inertial.radii(45.0)
    place = Place(45.0, 10.0, 300.0, heading)
    latitude, longitude, altitude = inertial.fix(position, place, (per_north, per_east))
    assert math.radians(latitude - 45.0) * per_north == pytest.approx(north, abs=1e-6)
    assert math.radians(longitude - 10.0) * per_east == pytest.approx(east, abs=1e-6)
    assert altitude == 305.0


def test_the_magnetic_field_points_north_and_down():
    level, dip = inertial.field(0.5, 0.0, 0.0, 0.0), inertial.field(0.5, 0.0, 0.0, math.radians(60))
    assert level == pytest.approx((0.5, 0.0, 0.0))
    assert dip == pytest.approx((0.25, 0.0, -0.5 * math.sin(math.radians(60))))
    # x to the east: north is to the left
    assert inertial.field(0.5, math.pi / 2, 0.0, 0.0) == pytest.approx((0.0, 0.5, 0.0))


class Walls:
    """An engine with walls at x = 4 m and x = -2 m only."""

    def cast_rays(self, rays):
        center, directions, *_ = rays
        with np.errstate(divide="ignore"):
            there = np.stack([(x - center[0]) / directions[:, 0] for x in (4.0, -2.0)])
        return np.where(there >= 0.0, there, np.inf).min(axis=0)


def test_points_of_all_layers_lie_on_the_wall():
    spec = one(ray("gazebo_ros_velodyne_laser", vertical=VERTICAL))
    lidar = LayeredLidar(spec)
    ranges = lidar.scan(Walls(), np.zeros(3), np.array((0, 0, 0, 1.0)))
    points = lidar.points(ranges)
    assert points.shape == (15, 3) and points[:, 0] == pytest.approx(4.0, abs=1e-5)
    assert lidar.rings.tolist() == [0, 1, 2] * 5
    elevation = np.arctan2(points[:, 2], np.hypot(points[:, 0], points[:, 1]))
    assert elevation == pytest.approx(np.tile((-0.2, -0.05, 0.1), 5), abs=1e-6)
    azimuth = np.arctan2(points[:, 1], points[:, 0])
    assert azimuth == pytest.approx(np.repeat(np.linspace(-1, 1, 5), 3), abs=1e-6)


def test_layers_from_the_highest_to_the_lowest():
    vertical = VERTICAL.replace("0.1", "-0.5")
    lidar = LayeredLidar(one(ray("gazebo_ros_block_laser", vertical=vertical)))
    layers = lidar.directions[lidar.rings == 0], lidar.directions[lidar.rings == 2]
    assert [math.asin(layer[0, 2]) for layer in layers] == pytest.approx([-0.2, -0.5])
    spec = one(ray("hector_gazebo_ros_sonar", vertical=vertical))
    assert spec.field_of_view == pytest.approx(0.3)


@pytest.mark.parametrize("library", ["hector_gazebo_ros_imu", "gazebo_ros_imu"])
@pytest.mark.parametrize(
    "more, frame",
    [
        ("", "base"),
        ('<gazebo reference="m"><preserveFixedJoint>true</preserveFixedJoint></gazebo>', "mast"),
    ],
)
def test_frames_are_of_the_link_that_fixed_joints_merge_into_as_in_gazebo(library, more, frame):
    mast = (
        '<link name="mast"/><joint name="m" type="fixed"><parent link="base"/><child link="mast"/>'
        "</joint>"
    )
    text = plugin(library, "<bodyName>mast</bodyName>")
    robot = f'<robot name="r">{LINKS}{mast}<gazebo>{text}</gazebo>{more}</robot>'
    (spec,) = parse_urdf(robot, str, "bot").sensors
    link = frame if library == "gazebo_ros_imu" else "mast"
    assert (spec.link, spec.frame_id) == (link, frame)


def test_the_heading_of_an_older_hectors_imu():
    spec = one(plugin("hector_gazebo_ros_imu", "<headingGaussianNoise>0.4</headingGaussianNoise>"))
    assert spec.heading.noise == (0.4,) * 3


def test_a_gaussian_noise_of_hectors_imu_is_that_of_rates_and_acceleration():
    tags = "<accelGaussianNoise>0.1</accelGaussianNoise><gaussianNoise>0.7</gaussianNoise>"
    spec = one(plugin("hector_gazebo_ros_imu", tags))
    assert spec.accel.noise == spec.gyro.noise == (0.7,) * 3
