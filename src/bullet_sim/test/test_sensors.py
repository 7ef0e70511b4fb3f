"""Camera arithmetic, lidar, IMU and ground truth against closed forms."""

import math

import numpy as np
import pytest
from bullet_sim.plugins.lidars import RaySpec
from bullet_sim.pose import matrix_from_rpy, rotation_matrix, sensor_in_world
from bullet_sim.sensors import camera, inertial
from bullet_sim.sensors.lidar import Lidar
from pinhole import OPTICAL_FROM_CAMERA, project

LEVEL = (0.0, 0.0, 0.0, 1.0)
YAW_90 = (0.0, 0.0, math.sqrt(0.5), math.sqrt(0.5))


class Room:
    """An engine of walls x = +-half_x and y = +-half_y round the origin."""

    def __init__(self, half_x, half_y):
        self.half = np.array([half_x, half_y])

    def cast_rays(self, rays):
        center, directions, near, far = rays
        way = directions[:, :2]
        with np.errstate(divide="ignore", invalid="ignore"):
            wall = np.where(way == 0.0, np.inf, (np.sign(way) * self.half - center[:2]) / way)
        first = wall.min(axis=1)
        first[(first > far) | (first < near)] = np.inf
        return first


def ray_spec(**changes):
    values = dict(
        name="lidar",
        link="laser",
        samples=5,
        min_angle=-math.pi / 2,
        max_angle=math.pi / 2,
        range_min=0.1,
        range_max=10.0,
    )
    values.update(changes)
    return RaySpec(**values)


@pytest.mark.parametrize(
    "quaternion, rpy",
    [
        (LEVEL, (0, 0, 0)),
        (YAW_90, (0, 0, math.pi / 2)),
        ((math.sqrt(0.5), 0, 0, math.sqrt(0.5)), (math.pi / 2, 0, 0)),
        ((0, math.sqrt(0.5), 0, math.sqrt(0.5)), (0, math.pi / 2, 0)),
        ((0.5, 0.5, 0.5, 0.5), (math.pi / 2, 0, math.pi / 2)),
    ],
)
def test_rotations_agree(quaternion, rpy):
    np.testing.assert_allclose(rotation_matrix(quaternion), matrix_from_rpy(rpy), atol=1e-12)


def test_zero_quaternion_is_refused():
    with pytest.raises(ValueError, match="length 1"):
        rotation_matrix((0, 0, 0, 0))


def test_sensor_in_world_turns_the_offset():
    position, rotation = sensor_in_world((1, 2, 3), YAW_90, ((1, 0, 0.5), (0, 0, 0)))
    np.testing.assert_allclose(position, (1, 3, 3.5), atol=1e-12)
    np.testing.assert_allclose(rotation @ (1, 0, 0), (0, 1, 0), atol=1e-12)


def test_intrinsics_of_a_right_angle():
    k = camera.intrinsics(640, 480, math.pi / 2)
    np.testing.assert_allclose(k, [[320, 0, 319.5], [0, 320, 239.5], [0, 0, 1]])


@pytest.mark.parametrize("width, height, fov", [(640, 480, 1.2), (320, 90, 2.0), (50, 200, 0.4)])
def test_opengl_and_pinhole_agree(width, height, fov):
    """One point through both: OpenGL's matrices (to pixels) and K."""
    position, rotation = np.array([1.0, -2.0, 0.5]), matrix_from_rpy((0.2, -0.1, 2.0))
    in_camera = np.random.default_rng(1).uniform((2, -1, -1), (9, 1, 1), (20, 3))
    in_world = np.hstack([in_camera @ rotation.T + position, np.ones((20, 1))])
    view = np.reshape(camera.view_matrix(position, rotation), (4, 4)).T
    projection = np.reshape(camera.projection_matrix(fov, width / height, 0.1, 50.0), (4, 4)).T
    clip = in_world @ (projection @ view).T
    ndc = clip[:, :2] / clip[:, 3:]
    pixels = np.column_stack(
        [(ndc[:, 0] + 1) * width / 2 - 0.5, (1 - ndc[:, 1]) * height / 2 - 0.5]
    )
    optical = in_camera @ OPTICAL_FROM_CAMERA.T
    expected = project(optical, camera.intrinsics(width, height, fov))
    np.testing.assert_allclose(pixels, expected, atol=1e-9)


def test_camera_info_arrays():
    d, k, r, p = camera.camera_info_arrays(320, 240, 1.0)
    assert (k[2], k[5]) == (160.5, 120.5), "as gazebo_ros_camera_utils, not as the image"
    assert [len(a) for a in (d, k, r, p)] == [5, 9, 9, 12]
    np.testing.assert_array_equal(p.reshape(3, 4)[:, :3], k.reshape(3, 3))
    assert not d.any() and not p.reshape(3, 4)[:, 3].any()


@pytest.mark.parametrize(
    "values, word",
    [
        ((0, 480, 1.0, 0.1, 10.0), "0x480"),
        ((181_000_000, 1, 1.0, 0.1, 10.0), "181000000x1: at most 16384 a side"),
        ((10_000, 10_000, 1.0, 0.1, 10.0), "10000x10000: at most"),
        ((640, 480, 3.2, 0.1, 10.0), "3.2"),
        ((640, 480, 1.0, 0.0, 10.0), "near 0.0"),
        ((640, 480, 1.0, 5.0, 2.0), "near 5.0"),
    ],
)
def test_bad_cameras_are_named(values, word):
    with pytest.raises(ValueError, match=word):
        camera.check(*values)


def test_camera_noise_has_its_deviation_and_repeats():
    gray = np.full((200, 300, 3), 128, np.uint8)
    noisy = camera.add_noise(gray, 0.02, np.random.default_rng(3))
    assert noisy.dtype == np.uint8
    assert noisy.std() == pytest.approx(0.02 * 255, rel=0.02)
    assert noisy.mean() == pytest.approx(128, abs=0.1)
    assert (noisy == noisy[:, :, :1]).all(), "as in Gazebo gray, whatever the color"
    np.testing.assert_array_equal(noisy, camera.add_noise(gray, 0.02, np.random.default_rng(3)))
    white = camera.add_noise(np.full((9, 9, 3), 255, np.uint8), 0.02, np.random.default_rng(3))
    assert white.min() > 200  # cut off, not wrapped round
    assert camera.add_noise(gray, 0.0, None) is gray


def test_lidar_in_a_room_of_known_walls():
    lidar = Lidar(ray_spec())
    ranges = lidar.scan(Room(3.0, 2.0), (0, 0, 0.2), LEVEL)
    assert ranges.dtype == np.float32
    corner = math.sqrt(2) * 2.0
    np.testing.assert_allclose(ranges, [2, corner, 3, corner, 2], rtol=1e-6)
    assert lidar.angle_increment == pytest.approx(math.pi / 4)


def test_lidar_counts_counter_clockwise_from_min_angle():
    ranges = Lidar(ray_spec(samples=3)).scan(Room(3.0, 2.0), (0.5, 0.5, 0), LEVEL)
    np.testing.assert_allclose(ranges, [2.5, 2.5, 1.5], rtol=1e-6)
    turned = Lidar(ray_spec(samples=3)).scan(Room(3.0, 2.0), (0.5, 0.5, 0), YAW_90)
    np.testing.assert_allclose(turned, [2.5, 1.5, 3.5], rtol=1e-6)


def test_a_lidar_goes_from_its_first_angle_to_its_last_whichever_is_smaller():
    """As MultiRayShape of Gazebo; the scan tells a negative angle_increment."""
    spec = ray_spec(samples=3, min_angle=math.pi / 2, max_angle=-math.pi / 2)
    lidar = Lidar(spec)
    assert lidar.angle_increment == pytest.approx(-math.pi / 2)
    ranges = lidar.scan(Room(3.0, 2.0), (0.5, 0.5, 0), LEVEL)
    np.testing.assert_allclose(ranges, [1.5, 2.5, 2.5], rtol=1e-6)


def test_a_bias_and_a_precision_of_a_lidar():
    """As RaySensor: what is hit within the ranges gets them, rounded, within the ranges."""
    room = Room(3.0, 2.0)
    lidar = Lidar(ray_spec(samples=3, precision=0.25))
    np.testing.assert_allclose(lidar.scan(room, (0, 0, 0), LEVEL, bias=0.4), [2.5, 3.5, 2.5])
    far = Lidar(ray_spec(samples=3, range_max=3.2)).scan(room, (0, 0, 0), LEVEL, bias=0.4)
    np.testing.assert_allclose(far, [2.4, 3.2, 2.4], rtol=1e-6)
    near = Lidar(ray_spec(samples=3, range_max=2.5)).scan(room, (0, 0, 0), LEVEL, bias=0.4)
    np.testing.assert_allclose(near, [2.4, math.inf, 2.4], rtol=1e-6)


def test_a_single_ray_points_ahead_as_in_gazebo():
    lidar = Lidar(ray_spec(samples=1, min_angle=-1.0, max_angle=1.0))
    np.testing.assert_allclose(lidar.directions, [(1.0, 0.0, 0.0)])
    assert lidar.angle_increment == math.inf
    assert math.isnan(Lidar(ray_spec(samples=1, min_angle=0.0, max_angle=0.0)).angle_increment)


def test_lidar_offset_pose():
    spec = ray_spec(samples=1, min_angle=0.0, max_angle=0.0, pose=((0.5, 0, 0), (0, 0, math.pi)))
    np.testing.assert_allclose(Lidar(spec).scan(Room(3.0, 2.0), (0, 0, 0), LEVEL), [3.5])


def test_lidar_beyond_and_before_its_ranges():
    ranges = Lidar(ray_spec(range_max=2.5)).scan(Room(3.0, 2.0), (0, 0, 0), LEVEL)
    np.testing.assert_array_equal(np.isposinf(ranges), [False, True, True, True, False])
    near = ray_spec(samples=3, range_min=2.5)
    ranges = Lidar(near).scan(Room(3.0, 2.0), (0, 0, 0), LEVEL)
    np.testing.assert_array_equal(ranges, [np.inf, 3.0, np.inf])


def test_lidar_noise_has_its_deviation_and_repeats():
    lidar = Lidar(ray_spec(samples=4000, min_angle=-0.1, max_angle=0.1, noise_stddev=0.01))
    exact = 3.0 / np.cos(lidar.angles)
    scans = [
        lidar.scan(Room(3.0, 2.0), (0, 0, 0), LEVEL, np.random.default_rng(5)) for _ in range(2)
    ]
    error = scans[0] - exact
    assert error.std() == pytest.approx(0.01, rel=0.05)
    assert error.mean() == pytest.approx(0.0, abs=0.001)
    np.testing.assert_array_equal(*scans)
    with pytest.raises(ValueError, match="rng"):
        lidar.scan(Room(3.0, 2.0), (0, 0, 0), LEVEL)


@pytest.mark.parametrize(
    "changes",
    [
        {"samples": 0},
        {"samples": 181_000_000_000},
        {"range_min": 5.0, "range_max": 1.0},
        {"range_max": math.inf},
        {"noise_stddev": -0.1},
    ],
)
def test_bad_lidars_are_named(changes):
    with pytest.raises(ValueError, match="lidar lidar: .*expected"):
        Lidar(ray_spec(**changes))


def test_imu_at_rest_feels_up_and_turns_with_the_sensor():
    roll_90 = (math.sqrt(0.5), 0, 0, math.sqrt(0.5))
    gravity, rest = (0.0, 0.0, -9.81), (0.0, 0.0, 0.0)
    for before in (None, (rest, 1.0)):
        force = inertial.specific_force(rest, before, 1.01, gravity)
        force, rate = inertial.twist(roll_90, force, (0, 0, 2.0))
        np.testing.assert_allclose(rate, (0, 2.0, 0), atol=1e-12)
        np.testing.assert_allclose(force, (0, 9.81, 0), atol=1e-12)
    falling = inertial.specific_force((0.0, 0.0, -0.0981), (rest, 1.0), 1.01, gravity)
    np.testing.assert_allclose(falling, 0, atol=1e-12)


def test_imu_acceleration():
    nothing = (0.0, 0.0, 0.0)
    force = inertial.specific_force((1.0, 0, 0), ((0.5, 0.0, 0.0), 2.0), 2.01, nothing)
    np.testing.assert_allclose(force, (50, 0, 0))
    with pytest.raises(ValueError, match="elapsed 0"):
        inertial.specific_force((1.0, 0, 0), ((1.0, 0.0, 0.0), 2.0), 2.0, nothing)


def test_twist_in_child_and_in_world():
    linear, angular = inertial.twist(YAW_90, (0, 2, 0), (1, 0, 3))
    np.testing.assert_allclose(linear, (2, 0, 0), atol=1e-12)
    np.testing.assert_allclose(angular, (0, -1, 3), atol=1e-12)
    linear, _ = inertial.twist(YAW_90, (0, 2, 0), (1, 0, 3), in_child=False)
    np.testing.assert_array_equal(linear, (0, 2, 0))
    for wrong in ((0, 0, 0, 0), (0, 0, 0, np.nan), (np.inf, 0, 0, 0)):
        with pytest.raises(ValueError, match="is no rotation"):
            inertial.twist(wrong, (0, 2, 0), (1, 0, 3))


def test_twist_is_that_of_the_rotation_matrix():
    rng = np.random.default_rng(4)
    for _ in range(50):
        orientation, linear, angular = rng.normal(size=4), rng.normal(size=3), rng.normal(size=3)
        to_link = rotation_matrix(orientation).T
        found = inertial.twist(orientation, linear, angular)
        np.testing.assert_allclose(found, (to_link @ linear, to_link @ angular), atol=1e-12)
