"""Messages of hector's, velodyne's and gazebo_ros's plugins, without a ROS master."""

import io
import math
from dataclasses import replace

import numpy as np
import pytest
import rospy
from bullet_bridge.plugins import base, lidars
from bullet_bridge.transport.conversions import vector
from bullet_sim.formats.sdf.world import ground_plane, parse_world
from bullet_sim.plugins.drives import PlanarMoveSpec, WheelDriveSpec
from bullet_sim.plugins.gps import GpsSpec, MagneticSpec
from bullet_sim.plugins.inertial import (
    BiasedImuSpec,
    BiasModel,
    ErrorModel,
    GroundTruthSpec,
    ImuSpec,
    ModelImuSpec,
)
from bullet_sim.plugins.lidars import BlockCloudSpec, CloudSpec, RangeSpec
from bullet_sim.pose import Pose
from bullet_sim.world import World
from fake_impl import FakeReceivedCounts, FakeServer, in_thread, plugin_of, twist
from geometry_msgs.msg import Vector3
from hector_gazebo_plugins.srv import SetBiasRequest, SetReferenceGeoPoseRequest
from sensor_msgs.msg import PointCloud, Range
from urdf_texts import joint, link, robot

WALL = (
    '<model name="w"><static>true</static><link name="l"><collision name="c"><geometry><box><size>'
    "0.2 20 20</size></box></geometry></collision></link></model>"
)
CART = robot(
    link("base", 2, 0.02, '<box size="0.3 0.2 0.1"/>'),
    *(
        link(f"{side}_wheel", 0.2, 1e-3, '<cylinder radius="0.1" length="0.04"/>', "1.5707963 0 0")
        + joint(side, "continuous", "base", f"{side}_wheel", f"0.1 {y} 0")
        for side, y in (("left", 0.15), ("right", -0.15))
    ),
    name="cart",
)


@pytest.fixture(name="world")
def _world(world):
    world.spawn(ground_plane())
    world.spawn_sdf("wall", WALL, Pose((5.1, 0.0, 0.0)), str)
    return world


@pytest.fixture(name="cart")
def _cart(world):
    cart = world.spawn_urdf("cart", CART, Pose((0.0, 0.0, 0.1)), str)
    world.step(1)
    return cart


def made(spec, world, model, received=None):
    return plugin_of(world, model, spec, 1, received)


def run(output, world, steps):
    """Updates before each step."""
    for _ in range(steps):
        output.update(world.time, 0.0)
        world.step(1)


SCAN = dict(samples=9, min_angle=-0.4, max_angle=0.4, range_min=0.2, range_max=10.0)


def test_velodyne_cloud(topics, world, cart):
    spec = CloudSpec("v", "base", layers=4, min_elevation=0.0, max_elevation=0.3, topic="/v",
                     frame_id="velo", **SCAN)  # fmt: skip
    made(spec, world, cart).update(0.5, 0.0)
    cloud = topics["/v"].messages[-1]
    cloud.serialize(io.BytesIO())
    assert [field.name for field in cloud.fields] == ["x", "y", "z", "intensity", "ring", "time"]
    assert (cloud.height, cloud.width, cloud.point_step) == (1, 36, 22) and cloud.is_dense
    assert (cloud.header.frame_id, cloud.header.stamp.to_sec()) == ("velo", 0.5)
    data = np.frombuffer(cloud.data, lidars._POINT)
    assert data["xyz"][:, 0] == pytest.approx(5.0, abs=0.01)
    assert sorted(set(data["ring"].tolist())) == [0, 1, 2, 3]


def test_a_velodyne_leaves_out_what_is_below_its_minimal_intensity(topics, world, cart):
    for minimum, count in ((0.0, 9), (0.1, 0)):  # the wall reflects nothing
        spec = CloudSpec("v", "base", layers=1, topic="/v", min_intensity=minimum, **SCAN)
        made(spec, world, cart).update(0.5, 0.0)
        assert topics["/v"].messages[-1].width == count


def test_a_sonars_range_has_hectors_errors_within_its_bounds(topics, world, cart):
    for offset, wanted in ((1.0, 6.0), (9.0, 10.0), (-9.0, 0.2)):
        spec = RangeSpec("s", "base", topic="/s", errors=ErrorModel(offset=(offset,) * 3), **SCAN)
        made(spec, world, cart).update(0.1, 0.0)
        assert topics["/s"].messages[-1].range == pytest.approx(wanted, abs=0.01)


def test_organized_cloud_keeps_the_rays_that_hit_nothing(topics, world, cart):
    spec = CloudSpec("v", "base", layers=2, min_elevation=0.0, max_elevation=0.1, topic="/v",
                     organized=True, **dict(SCAN, range_max=5.2))  # fmt: skip
    made(spec, world, cart).update(0.5, 0.0)
    cloud = topics["/v"].messages[-1]
    assert (cloud.height, cloud.width) == (2, 9) and not cloud.is_dense
    data = np.frombuffer(cloud.data, lidars._POINT).reshape(2, 9)
    assert (data["ring"][0] == 1).all() and (data["ring"][1] == 0).all()  # highest layer first
    assert np.isnan(data["xyz"][:, 0]).all() and np.isfinite(data["xyz"][:, 4]).all()


def test_block_laser_has_a_point_of_each_ray_half_a_ray_beyond_it(topics, world, cart):
    layers = dict(SCAN, layers=2, min_elevation=0.0, max_elevation=0.1)
    made(BlockCloudSpec("b", "base", topic="/b", **layers), world, cart).update(0.1, 0.0)
    cloud = topics["/b"].messages[-1]
    assert isinstance(cloud, PointCloud) and len(cloud.points) == 18
    assert len(cloud.channels[0].values) == 18 and cloud.channels[0].name == ""
    first, last = SCAN["min_angle"], SCAN["max_angle"]
    step = (last - first) / 8
    found = [math.atan2(point.y, point.x) for point in cloud.points[:9]]
    assert found == pytest.approx([first + (i + 0.5) * step for i in range(8)] + [last], abs=1e-5)
    assert math.hypot(cloud.points[4].x, cloud.points[4].y) == pytest.approx(
        5.0 * math.cos(0.05), abs=0.01
    )
    assert cloud.points[4].z == pytest.approx(5.0 * math.sin(0.05), abs=0.01)


def test_rays_of_block_laser_begin_at_their_minimum_range(topics, world, cart):
    """What is nearer is not there for them: a wall at 5 m."""
    layers = dict(SCAN, layers=2, min_elevation=0.0, max_elevation=0.1)
    layers.update(range_min=5.5, range_max=7.0)
    made(BlockCloudSpec("b", "base", topic="/b", **layers), world, cart).update(0.1, 0.0)
    points = topics["/b"].messages[-1].points
    ranges = [math.sqrt(point.x**2 + point.y**2 + point.z**2) for point in points]
    assert min(ranges) > 5.5 - 1e-5 and max(ranges) < 7.0 + 1e-5


def test_an_intensity_of_block_laser_is_the_mean_with_the_next_rays(topics, world, cart):
    retro = WALL.replace(
        '<collision name="c">', '<collision name="c"><laser_retro>80</laser_retro>'
    ).replace("0.2 20 20", "0.2 2 20")
    world.delete("wall")
    world.spawn_sdf("half", retro, Pose((3.1, 1.0, 0.0)), str)  # to the left of the middle ray
    layers = dict(SCAN, samples=4, layers=2, min_elevation=0.0, max_elevation=0.1)
    made(BlockCloudSpec("b", "base", topic="/b", **layers), world, cart).update(0.1, 0.0)
    values = list(topics["/b"].messages[-1].channels[0].values)
    assert values == [0.0, 40.0, 80.0, 80.0] * 2


def test_block_laser_of_one_layer_has_no_numbers(topics, world, cart):
    made(BlockCloudSpec("b", "base", topic="/b", **SCAN), world, cart).update(0.1, 0.0)
    points = topics["/b"].messages[-1].points
    assert len(points) == 9 and all(math.isnan(p.x + p.y + p.z) for p in points)


@pytest.mark.parametrize("farthest, expected", [(10.0, 5.0), (3.0, 3.0)])
def test_range_is_that_of_the_nearest_ray(topics, world, cart, farthest, expected):
    spec = RangeSpec("s", "base", topic="/s", field_of_view=0.4, **dict(SCAN, range_max=farthest))
    made(spec, world, cart).update(0.1, 0.0)
    message = topics["/s"].messages[-1]
    assert message.range == pytest.approx(expected, abs=0.01)
    assert (message.radiation_type, message.field_of_view) == (Range.ULTRASOUND, 0.4)
    assert (message.min_range, message.max_range) == (pytest.approx(0.2), farthest)


def test_gps(topics, world, cart):
    cart.set_state(Pose((30.0, 40.0, 0.1)), (1.0, 2.0, 0.0))
    spec = GpsSpec("g", "base", heading=math.pi / 2, altitude=100.0,
                   errors=ErrorModel(noise=(0.0, 0.0, 0.3)))  # fmt: skip
    made(spec, world, cart).update(2.0, 0.0)
    fix, velocity = topics["/fix"].messages[-1], topics["/fix_velocity"].messages[-1]
    # x to the east, y to the north
    assert (fix.latitude - spec.latitude) * 111.2e3 == pytest.approx(40.0, rel=0.01)
    assert (fix.longitude - spec.longitude) * 111.3e3 * math.cos(
        math.radians(spec.latitude)
    ) == pytest.approx(30.0, rel=0.01)
    assert fix.altitude == pytest.approx(100.1, abs=1.5)
    assert fix.position_covariance[8] == pytest.approx(0.09) and fix.status.service == 0
    assert (velocity.vector.x, velocity.vector.y) == pytest.approx((2.0, -1.0))


def test_the_reference_of_a_gps_can_be_set(topics, world, cart):
    cart.set_state(Pose((30.0, 40.0, 0.1)))
    output = in_thread(made(GpsSpec("g", "base"), world, cart))
    request = SetReferenceGeoPoseRequest()
    request.geo_pose.position.latitude, request.geo_pose.position.longitude = 10.0, 20.0
    request.geo_pose.orientation.w = 1.0  # x of the world to the east
    topics["/fix/set_reference_geopose"].call(request)
    output.update(2.0, 0.0)
    fix = topics["/fix"].messages[-1]
    assert (fix.latitude - 10.0) * 110.6e3 == pytest.approx(40.0, rel=0.01)
    request.geo_pose.position.latitude = math.nan
    with pytest.raises(rospy.ServiceException, match="nan degrees north.*between -90 and 90"):
        topics["/fix/set_reference_geopose"].call(request)


def test_a_gps_and_a_magnetometer_that_use_the_worlds_place(topics, cart):
    """heading_deg is counter-clockwise from the east: at 90 the world's x points north."""
    world = World()
    world.load(
        parse_world(
            "<sdf version='1.6'><world name='w'><spherical_coordinates><surface_model>EARTH_WGS84"
            "</surface_model><latitude_deg>47.5</latitude_deg><longitude_deg>8.5</longitude_deg>"
            "<elevation>400</elevation><heading_deg>90</heading_deg></spherical_coordinates>"
            "</world></sdf>",
            str,
        )
    )
    cart = world.spawn_urdf("cart", CART, Pose((100.0, 0.0, 0.0)), str)
    names = ("latitude", "longitude", "altitude", "heading")
    made(GpsSpec("g", "base", **dict.fromkeys(names)), world, cart).update(0.0, 0.0)
    fix = topics["/fix"].messages[-1]
    assert (fix.latitude - 47.5) * 111.18e3 == pytest.approx(100.0, rel=1e-3)
    assert (fix.longitude, fix.altitude) == pytest.approx((8.5, 400.0))
    made(MagneticSpec("m", "base", heading=None, topic="/m", magnitude=0.44), world, cart).update(
        0.0, 0.0
    )
    field = topics["/m"].messages[-1].vector
    assert (field.x, field.y) == pytest.approx((0.22, 0.0), abs=1e-9)
    world.close()


def test_a_set_reference_keeps_the_radii_of_the_first_one_as_upstream(topics, world, cart):
    cart.set_state(Pose((0.0, 1000.0, 0.1)))
    output = in_thread(made(GpsSpec("g", "base", latitude=0.0, heading=math.pi / 2), world, cart))
    request = SetReferenceGeoPoseRequest()
    request.geo_pose.position.latitude, request.geo_pose.orientation.w = 60.0, 1.0
    topics["/fix/set_reference_geopose"].call(request)
    output.update(2.0, 0.0)
    degrees = topics["/fix"].messages[-1].latitude - 60.0
    assert degrees * 110574.0 == pytest.approx(1000.0, abs=0.1)  # a degree at the equator


def test_an_offset_of_hectors_imu_turns_from_the_left(topics, world, cart):
    """Orientation and accelerations as rpyOffset times the link's; rates in the sensor's axes."""
    cart.set_state(Pose.from_xyz_rpy((0.0, 0.0, 1.0), (0.0, 0.0, math.pi / 2)), angular=(0, 1, 0))
    spec = BiasedImuSpec("i", "base", pose=((0.0,) * 3, (math.pi / 2, 0.0, 0.0)))
    made(spec, world, cart).update(world.time, 0.0)
    message = topics["/imu"].messages[-1]
    turned = Pose.from_xyz_rpy((0.0,) * 3, (math.pi / 2, 0.0, 0.0)) * Pose.from_xyz_rpy(
        (0.0,) * 3, (0.0, 0.0, math.pi / 2)
    )
    q = message.orientation
    assert abs(np.dot((q.x, q.y, q.z, q.w), turned.orientation)) == pytest.approx(1.0)
    force = turned.matrix.T @ (0.0, 0.0, 9.81)
    assert vector(message.linear_acceleration) == pytest.approx(force, abs=0.02)
    assert vector(message.angular_velocity) == pytest.approx((1.0, 0.0, 0.0), abs=1e-6)


@pytest.mark.parametrize(
    "spec",
    [
        BiasedImuSpec("d", "base", rate=100.0, gyro=ErrorModel(drift=(0.3,) * 3)),
        MagneticSpec("d", "base", rate=100.0, errors=ErrorModel(drift=(0.3,) * 3)),
        GpsSpec("d", "base", rate=100.0, velocity_errors=ErrorModel(drift=(0.3,) * 3)),
    ],
    ids=lambda spec: type(spec).__name__,
)
def test_a_drift_does_not_jump_when_nobody_subscribed_for_an_hour(topics, world, cart, spec):
    """hector's sensors measure meanwhile; in one step of an hour it would be 25."""
    output = made(spec, world, cart)
    output.restart_errors()
    (drifting,) = (errors for errors in output.errors if any(errors.spec.drift))
    before = np.array(drifting.drift)
    output.update(world.time + 3600.0, 0.0)
    assert 0.0 < np.abs(drifting.drift - np.exp(-1.0) * before).max() < 0.1


@pytest.mark.parametrize(
    "spec, namespaces",
    [
        (BiasedImuSpec("i", "base"), ("/imu/accel", "/imu/rate", "/imu/yaw")),
        (GpsSpec("g", "base"), ("/fix/position", "/fix/velocity", "/fix/status")),
        (MagneticSpec("m", "base"), ("/magnetic",)),
        (RangeSpec("s", "base", topic="/s", tunable=True, **SCAN), ("/s",)),
        (RangeSpec("s", "base", topic="/s", **SCAN), ()),
    ],
)
def test_errors_of_hectors_sensors_are_reconfigured(topics, world, cart, spec, namespaces):
    made(spec, world, cart)
    assert tuple(FakeServer.made) == namespaces


def test_what_is_reconfigured_counts_for_all_axes(topics, world, cart):
    errors = ErrorModel(offset=(1.0, 2.0, 3.0), noise=(0.0, 0.0, 0.0))
    output = in_thread(made(GpsSpec("g", "base", errors=errors), world, cart))
    server = FakeServer.made["/fix/position"]
    assert server.values["offset"] == pytest.approx(2.0) and server.config.max["offset"] == 10.0
    server.callback({**server.values, "offset": 5.0, "gaussian_noise": 0.0, "drift": 0.5}, 1)
    output.errors[0].drift = (0.0, 0.0, 0.0)
    output.update(2.0, 0.0)
    fix = topics["/fix"].messages[-1]
    assert fix.altitude == pytest.approx(5.0 + cart.pose.position[2], abs=0.2)
    assert fix.position_covariance[::4] == pytest.approx((0.25,) * 3)
    status = FakeServer.made["/fix/status"]
    assert status.values["STATUS_FIX"] and not status.values["SERVICE_GPS"]
    status.callback({**status.values, "STATUS_GBAS_FIX": True, "SERVICE_GALILEO": True}, 1)
    output.update(3.0, 0.0)
    fix = topics["/fix"].messages[-1]
    assert (fix.status.status, fix.status.service) == (2, 8)
    status.callback({**status.values, "STATUS_FIX": False}, 1)
    output.update(4.0, 0.0)
    assert topics["/fix"].messages[-1].status.status == -1


def test_noise_of_an_imu_is_that_of_its_seed(topics, world, cart):
    """First of the rates, then of the forces, with a mean for all axes or for each."""
    exact = ImuSpec("i", "base", topic="/exact")
    noisy = ImuSpec(
        "i", "base", topic="/noisy", gyro_noise_mean=0.5, gyro_noise_stddev=0.1,
        accel_noise_mean=(1.0, 2.0, 3.0), accel_noise_stddev=0.2,
    )  # fmt: skip
    outputs, rng = [made(spec, world, cart) for spec in (exact, noisy)], np.random.default_rng(1)
    for _ in range(3):
        world.step(1)
        for output in outputs:
            output.update(world.time, 0.001)
        without, message = (topics[name].messages[-1] for name in ("/exact", "/noisy"))
        rate = vector(without.angular_velocity) + 0.5 + rng.normal(0.0, 0.1, 3)
        force = vector(without.linear_acceleration) + (1.0, 2.0, 3.0) + rng.normal(0.0, 0.2, 3)
        assert vector(message.angular_velocity).tolist() == rate.tolist()
        assert vector(message.linear_acceleration).tolist() == force.tolist()
        assert message.orientation == without.orientation


def test_an_imu_has_the_bias_of_its_sdf(topics, world, cart):
    """The same in each message, another one after a reset with another seed only."""
    exact = ImuSpec("i", "base", topic="/exact")
    biased = ImuSpec(
        "i", "base", topic="/biased", gyro_bias=BiasModel((0.5, 0.25, 0.125)),
        accel_bias=BiasModel(precision=(100.0,) * 3),
    )  # fmt: skip
    outputs = [made(spec, world, cart) for spec in (exact, biased)]
    found = []
    for _ in range(3):
        world.step(1)
        for output in outputs:
            output.update(world.time, 0.001)
        without, message = (topics[name].messages[-1] for name in ("/exact", "/biased"))
        found.append(vector(message.angular_velocity) - vector(without.angular_velocity))
        assert not (vector(message.linear_acceleration) % 100.0).any()
    assert np.abs(found[0]) == pytest.approx((0.5, 0.25, 0.125))
    np.testing.assert_allclose(found[1:], [found[0]] * 2, atol=1e-12)


def test_the_imu_of_a_model_has_no_gravity_and_is_turned_as_in_gazebo(topics, world, cart):
    """libgazebo_ros_imu.so turns by the orientation, and its offset comes last."""
    spec = ModelImuSpec("i", "base", ((1.0, 0.0, 0.0), (0.0, 0.0, 0.25 * math.pi)), topic="/imu")
    output = made(spec, world, cart)
    for speed in (1.0, 3.0):  # along y; 2 m/s in 0.1 s
        pose = Pose.from_xyz_rpy((1.0, 2.0, 0.1), (0.0, 0.0, 0.25 * math.pi))
        cart.set_state(pose, (0.0, speed, 0.0), (0.5, 0.0, 0.0))
        output.update(world.time + 0.1 * speed / 2.0, 0.1)
    message = topics["/imu"].messages[-1]
    assert vector(message.linear_acceleration) == pytest.approx((-20.0, 0.0, 0.0), abs=1e-5)
    assert vector(message.angular_velocity) == pytest.approx((0.0, 0.5, 0.0), abs=1e-5)
    assert message.orientation.z == pytest.approx(math.sqrt(0.5), abs=1e-6)


@pytest.mark.parametrize("offset, share", [(0.0, 0.5), (math.pi / 3.0, -0.5)])
def test_the_imu_of_a_model_on_a_pitched_link_has_a_share_of_the_yaw_rate(
    topics, world, cart, offset, share
):
    """The cosine of link's pitch and <rpyOffset>: GazeboRosIMU rotates the world's rate by both."""
    spec = ModelImuSpec("i", "base", ((0.0, 0.0, 0.0), (0.0, offset, 0.0)), topic="/imu")
    output = made(spec, world, cart)
    pose = Pose.from_xyz_rpy((0.0, 0.0, 1.0), (0.0, math.pi / 3.0, 0.0))
    cart.set_state(pose, (0.0, 0.0, 0.0), (0.0, 0.0, 2.0))
    output.update(world.time, 0.1)
    rate = vector(topics["/imu"].messages[-1].angular_velocity)
    side = math.sqrt(0.75)  # sine of 60 and of 120 degrees
    assert rate == pytest.approx((2.0 * side, 0.0, 2.0 * share), abs=1e-5)


def test_biases_of_an_imu_are_set_and_decay(topics, world, cart):
    spec = BiasedImuSpec(
        "i", "base", topic="/imu", service="/imu/calibrate", bias_topic="/imu/bias",
        accel=ErrorModel(frequency=(1.0, 1.0, 1.0)), gyro=ErrorModel(offset=(0.0, 0.0, 0.2)),
    )  # fmt: skip
    output = in_thread(made(spec, world, cart))
    cart.set_state(Pose((0.0, 0.0, 0.1)))  # level
    gravity = float(np.linalg.norm(world.gravity))
    for name, bias in (("accel", Vector3(1.0, 0.0, 0.0)), ("rate", Vector3(0.0, 0.0, 0.5))):
        topics[f"/imu/set_{name}_bias"].call(SetBiasRequest(bias))
    output.update(world.time, 0.0)
    message = topics["/imu"].messages[-1]
    assert message.linear_acceleration.x == pytest.approx(1.0, abs=1e-6)
    assert message.angular_velocity.z == pytest.approx(0.7, abs=1e-6)
    assert message.orientation.y == pytest.approx(-0.5 / gravity, rel=0.01)
    biases = topics["/imu/bias"].messages[-1]
    assert (biases.linear_acceleration.x, biases.angular_velocity.z) == (1.0, 0.7)
    topics["/imu/calibrate"].call(None)
    output.update(world.time + 1.0, 0.0)
    message = topics["/imu"].messages[-1]
    assert message.linear_acceleration.x == pytest.approx(math.exp(-1.0), abs=1e-6)
    assert message.angular_velocity.z == pytest.approx(0.2, abs=1e-6)
    with pytest.raises(rospy.ServiceException, match="finite"):
        topics["/imu/set_rate_bias"].call(SetBiasRequest(Vector3(math.inf, 0.0, 0.0)))


def test_covariances_of_an_imu_are_its_noise(topics, world, cart):
    spec = BiasedImuSpec(
        "i",
        "base",
        accel=ErrorModel(noise=(0.1, 0.2, 0.3)),
        gyro=ErrorModel(noise=(1.0, 2.0, 3.0)),
        heading=ErrorModel(noise=(0.5, 0.5, 0.5)),
    )
    made(spec, world, cart).update(world.time, 0.0)
    message = topics["/imu"].messages[-1]
    gravity = float(np.linalg.norm(world.gravity))
    tilt = [0.01 / gravity**2, 0.04 / gravity**2, 0.25]  # as hector's: of gravity's direction
    assert message.orientation_covariance[::4] == pytest.approx(tilt)
    assert message.linear_acceleration_covariance[::4] == pytest.approx((0.01, 0.04, 0.09))
    assert message.angular_velocity_covariance[::4] == (1.0, 4.0, 9.0)


def test_a_heading_error_turns_the_orientation(topics, world, cart):
    cart.set_state(Pose((0.0, 0.0, 0.1)))
    spec = BiasedImuSpec("i", "base", heading=ErrorModel(offset=(0.3, 0.3, 0.3)))
    made(spec, world, cart).update(world.time, 0.0)
    message = topics["/imu"].messages[-1]
    assert 2.0 * math.atan2(message.orientation.z, message.orientation.w) == pytest.approx(0.3)


def test_a_drift_of_a_gps_velocity_adds_up_in_its_position(topics, world, cart):
    drifting = ErrorModel(drift=(5.0, 0.0, 0.0), frequency=(0.0, 0.0, 0.0))
    output = made(GpsSpec("g", "base", velocity_errors=drifting), world, cart)
    first = output.errors[1].drift[0]
    assert first != 0.0, "random at the start"
    for time in range(1, 4):
        output.update(float(time), 1.0)
    assert output.errors[1].drift[0] == first, "it decays and wanders with no frequency"
    assert output.errors[0].drift[0] == pytest.approx(3.0 * first, rel=1e-3)
    assert topics["/fix"].messages[-1].position_covariance[0] == 0.0
    assert topics["/fix_velocity"].messages[-1].vector.x == pytest.approx(first, rel=1e-3)


@pytest.mark.parametrize("angle", [0.0, 1.0])
def test_an_imu_sensors_offset_and_first_orientation(topics, world, cart, angle):
    cart.set_state(Pose.from_xyz_rpy((0, 0, 0.1), (0, 0, angle)))
    turn = Pose.from_xyz_rpy((0, 0, 0), (0, 0, 0.5)).orientation
    output = made(ImuSpec("i", "base", turn=turn, relative=True), world, cart)
    cart.set_state(Pose.from_xyz_rpy((0, 0, 0.1), (0, 0, angle + 0.2)))
    output.update(world.time, 0.0)
    message = topics["/imu"].messages[-1]
    yaw = 2.0 * math.atan2(message.orientation.z, message.orientation.w)
    assert yaw == pytest.approx(0.7, abs=1e-6)
    assert message.linear_acceleration.z == pytest.approx(-world.gravity[2], rel=0.01)


def test_gaussian_noise_of_an_imu_sensor_is_on_the_orientation_too(topics, world, cart):
    output = made(ImuSpec("i", "base", orientation_noise=0.1), world, cart)
    for number in range(50):
        output.update(world.time + 0.01 * number, 0.01)
    found = [message.orientation.x for message in topics["/imu"].messages]
    assert 0.05 < np.std(found) < 0.15


def test_ground_truth_relative_to_a_link(topics, world, cart):
    cart.set_state(Pose.from_xyz_rpy((1.0, 2.0, 0.1), (0.0, 0.0, math.pi / 2)), (1.0, 0.0, 0.0))
    offset = ((0.0, 0.0, 5.0), (0.0, 0.0, 0.0))
    spec = GroundTruthSpec("left_wheel", "/truth", "base", reference="base", offset=offset)
    made(spec, world, cart).update(0.0, 0.0)
    message = topics["/truth"].messages[-1]
    p = message.pose.pose.position
    assert (p.x, p.y) == pytest.approx((0.1, 0.15), abs=1e-6) and p.z > 4.5
    assert message.header.frame_id == "base"
    assert message.twist.twist.linear.x == pytest.approx(0.0, abs=1e-6)
    nowhere = made(GroundTruthSpec("base", "/none", "odom", reference=None), world, cart)
    assert not nowhere.needs_update() and topics["/none"].subscribers == 1


@pytest.mark.parametrize("field_message", [False, True])
def test_magnetic(topics, world, cart, field_message):
    cart.set_state(Pose.from_xyz_rpy((0, 0, 0.1), (0, 0, math.pi / 2)))
    spec = MagneticSpec("m", "base", inclination=0.0, magnitude=0.44, field_message=field_message)
    made(spec, world, cart).update(0.1, 0.0)
    message = topics["/magnetic"].messages[-1]
    vector = message.magnetic_field if field_message else message.vector
    assert (vector.x, vector.y, vector.z) == pytest.approx((0.0, -0.44, 0.0), abs=1e-6)


def test_planar_move(topics, world, cart, monkeypatch):
    received = FakeReceivedCounts()
    output = made(PlanarMoveSpec("p", "base", rate=20.0, timeout=0.5), world, cart, received)
    assert received.topic == "/cmd_vel" and output.needs_update()
    world.engine.set_gravity((0.0, 0.0, 0.0))  # friction slows it within a step, as in Gazebo
    cart.set_state(Pose((0.0, 0.0, 1.0)))
    received.take(twist(0.4, y=0.2))
    run(output, world, 400)
    x, y, _ = cart.pose.position
    assert (x, y) == pytest.approx((0.16, 0.08), abs=1e-3)
    odometry = topics["/odom"].messages[-1]
    assert odometry.twist.twist.linear.y == pytest.approx(0.2, abs=1e-3)
    assert odometry.pose.pose.position.z == 0.0, "upstream does not set it"
    assert topics["/tf"].messages[-1].transforms[0].transform.translation.z == pytest.approx(1.0)
    assert len(topics["/odom"].messages) == pytest.approx(8, abs=1)  # 20 Hz for 0.4 s
    assert topics["/tf"].messages[-1].transforms[0].child_frame_id == "base_footprint"
    run(output, world, 400)  # beyond the timeout
    assert cart.link_state("base")[1] == pytest.approx((0.0, 0.0, 0.0), abs=1e-2)
    assert cart.pose.position[0] == pytest.approx(0.2, abs=0.01)
    logged = []
    monkeypatch.setattr(base.rospy, "logerr", lambda _, text: logged.append(text))
    received.take(twist(math.nan))
    output.update(world.time, 0.0)
    assert len(logged) == 1 and "/cmd_vel" in logged[0]
    output.close()


@pytest.mark.parametrize("rate, count", [(0.0, 0), (-1.0, 0), (1000.0, 10), (2000.0, 20)])
def test_planar_moves_odometry_rate(topics, world, cart, rate, count):
    """None without a rate above 0; upstream waits for more than a period."""
    output = made(PlanarMoveSpec("p", "base", rate=rate), world, cart, FakeReceivedCounts())
    for _ in range(20):
        world.step(1)
        output.update(world.time, 0.0)
    assert len(topics["/odom"].messages) == count
    output.close()


@pytest.mark.parametrize("rate, waits", [(50.0, True), (0.0, False)])
def test_an_imu_waits_for_its_time_where_it_has_a_rate(topics, world, cart, rate, waits):
    output = made(ImuSpec("i", "base", rate=rate), world, cart)
    world.step(40)
    assert output.schedule.check_subscribers(world.step_count), "the first look starts it"
    world.start_over()
    output.go_back(world.time)
    assert (output.schedule.next > 40) is waits


def test_planar_move_drives_on_when_time_goes_back_and_its_odometry_waits(topics, world, cart):
    received = FakeReceivedCounts()
    output = made(PlanarMoveSpec("p", "base", rate=20.0), world, cart, received)
    received.take(twist(0.5))
    for time, odometry in ((0.4, 7), (0.39, 0), (0.5, 2)):
        sent = len(topics["/odom"].messages)
        while world.time < time - 1e-6:
            world.step(1)
            output.update(world.time, 0.0)
        assert len(topics["/odom"].messages) - sent == odometry
        assert cart.link_state("base")[1][0] == pytest.approx(0.5, abs=0.01)
        if time == 0.4:
            world.start_over()
            output.go_back(world.time)
    output.close()


@pytest.mark.parametrize("resets, count", [(False, 0), (True, 7)])
def test_a_drive_without_a_reset_of_its_own_waits_for_its_time(topics, world, cart, resets, count):
    """gazebo_ros_skid_steer_drive has none; gazebo_ros_diff_drive forgets its command, too."""
    received = FakeReceivedCounts()
    spec = replace(CART_DRIVE, rate=20.0, resets=resets)
    output = made(spec, world, cart, received)
    assert output.resets_with_model is resets
    received.take(twist(0.5))

    def run_to(until):
        while world.time < until - 1e-6:
            world.step(1)
            output.schedule.check_subscribers(world.step_count)
            if output.schedule.due(world.step_count):
                output.update(world.time, 0.0)

    run_to(0.4)
    world.start_over()
    (output.reset if resets else output.go_back)(world.time)
    sent = len(topics["/odom"].messages)
    run_to(0.39)
    assert len(topics["/odom"].messages) - sent == count
    speed = 0.0 if resets else 5.0
    assert cart.joints.state()[1]["left"] == pytest.approx(speed, abs=0.1)
    output.close()


CART_DRIVE = WheelDriveSpec(
    "d", "base", left=("left",), right=("right",), separation=0.3, diameter=0.2
)


@pytest.mark.parametrize(
    "spec",
    [
        PlanarMoveSpec("p", "base", rate=20.0),
        replace(CART_DRIVE, rate=20.0),
    ],
    ids=["planar_move", "diff_drive"],
)
def test_a_command_before_the_first_update_counts(topics, world, cart, spec):
    received = FakeReceivedCounts()
    output = made(spec, world, cart, received)
    output.prepare()
    received.take(twist(0.3))
    assert output.schedule.check_subscribers(world.step_count), "the first look starts it"
    run(output, world, 500)
    assert cart.link_state("base")[1][0] == pytest.approx(0.3, abs=0.03)
    output.reset(world.time)
    output.prepare()
    run(output, world, 500)
    assert cart.link_state("base")[1][0] == pytest.approx(0.0, abs=0.01), "a reset drops it"
    output.close()


def test_diff_drive_tells_of_its_wheels(topics, world, cart):
    frames = {side: ("tb3/base", f"tb3/{side}_wheel") for side in ("right", "left")}
    spec = replace(CART_DRIVE, wheel_states_topic="/joint_states", wheel_frames=frames)
    received = FakeReceivedCounts()
    output = made(spec, world, cart, received)
    received.take(twist(0.3))
    for _ in range(50):
        output.update(world.time, 0.0)
        world.step(10)
    output.update(world.time, 0.0)
    state = topics["/joint_states"].messages[-1]
    assert state.name == ["right", "left"] and state.position[1] == pytest.approx(1.5, rel=0.1)
    assert list(state.velocity) == list(state.effort) == []
    frames = [
        transform
        for message in topics["/tf"].messages[-2:]
        for transform in message.transforms
        if transform.header.frame_id == "tb3/base"
    ]
    assert [frame.child_frame_id for frame in frames] == [
        "tb3/right_wheel",
        "tb3/left_wheel",
    ]
    assert frames[1].transform.translation.y == pytest.approx(0.15, abs=5e-6)  # of the axle
    turned = 2 * math.atan2(frames[1].transform.rotation.y, frames[1].transform.rotation.w)
    assert math.remainder(turned - state.position[1], 2 * math.pi) == pytest.approx(0.0, abs=1e-6)
    output.close()
    assert topics["/joint_states"].closed
