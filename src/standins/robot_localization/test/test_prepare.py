"""Data of sensors that are mounted, turned and late: closed forms."""

import math

import numpy as np
import pytest
from robot_localization.frames import IDENTITY, Transform, angles, matrix
from robot_localization.prepare import (
    PoseInput,
    StateValues,
    acceleration,
    gravity_of,
    rotated,
    twist,
)

ALL = (True,) * 6
NOTHING = np.zeros((6, 6))
QUARTER = math.pi / 2.0


def pose(x, y, yaw, z=0.0):
    return Transform(matrix(0.0, 0.0, yaw), np.array((x, y, z), float))


def test_a_pose_in_the_world_stays_as_it_is():
    covariance = np.diag(np.arange(1.0, 7.0))
    values = PoseInput(ALL).process(0.0, pose(1.0, 2.0, 0.5), covariance)
    assert values.value[:6] == pytest.approx((1, 2, 0, 0, 0, 0.5))
    assert (values.covariance[:6, :6] == covariance).all()
    assert values.used[:6].all() and not values.used[6:].any()


def test_a_pose_in_another_frame_is_turned_with_what_is_used():
    """A frame turned by a quarter: its x is the world's y."""
    sensor = PoseInput((True, False, False, False, False, True))
    covariance = np.diag((0.1, 0.2, 0.3, 0.4, 0.5, 0.6))
    values = sensor.process(0.0, pose(3.0, 0.0, 0.1), covariance, pose(10.0, 20.0, QUARTER))
    assert values.value[:6] == pytest.approx((10, 23, 0, 0, 0, QUARTER + 0.1))
    assert values.used[:6].tolist() == [False, True, False, False, False, True]
    assert np.diagonal(values.covariance)[:6] == pytest.approx((0.2, 0.1, 0.3, 0.5, 0.4, 0.6))


def test_relative_poses_start_at_zero():
    sensor = PoseInput(ALL, relative=True)
    for x, y, yaw, expected in (
        (5.0, 1.0, QUARTER, (0.0, 0.0, 0.0)),
        (5.0, 3.0, QUARTER, (2.0, 0.0, 0.0)),
        (4.0, 1.0, math.pi, (0.0, 1.0, QUARTER)),
    ):
        values = sensor.process(0.0, pose(x, y, yaw), NOTHING)
        assert values.value[[0, 1, 5]] == pytest.approx(expected)


def test_differential_poses_are_velocities_in_the_robot():
    """A circle of radius 2 at 0.5 rad/s, sampled: chords and turns in the robot's frame."""
    sensor, rate, radius, dt = PoseInput(ALL, differential=True), 0.5, 2.0, 0.1
    for count in range(5):
        angle = rate * dt * count
        here = _on_circle(angle, radius)
        values = sensor.process(100.0 + dt * count, here, 0.01 * np.eye(6))
        if count == 0:
            assert values is None
            continue
        chord = 2.0 * radius * math.sin(rate * dt / 2.0) / dt
        half = rate * dt / 2.0
        assert values.value[6:12] == pytest.approx(
            (chord * math.cos(half), chord * math.sin(half), 0, 0, 0, rate)
        )
        assert values.used[6:12].all() and not values.used[:6].any()
        assert np.diagonal(values.covariance)[6:12] == pytest.approx([0.02 * dt] * 6)


def _on_circle(angle, radius):
    """Pose on a circle that starts at (7, -1) with a heading of 2 rad."""
    start = pose(7.0, -1.0, 2.0)
    return start.of(pose(radius * math.sin(angle), radius * (1.0 - math.cos(angle)), angle))


def test_differential_yaw_goes_on_over_half_a_turn():
    sensor = PoseInput(ALL, differential=True)
    sensor.process(0.0, pose(0, 0, 3.1), NOTHING)
    assert sensor.process(0.1, pose(0, 0, -3.1), NOTHING).value[11] == pytest.approx(
        (2 * math.pi - 6.2) / 0.1
    )


def test_differential_poses_of_one_time_are_none():
    sensor = PoseInput(ALL, differential=True)
    sensor.process(1.0, pose(0, 0, 0), NOTHING)
    assert sensor.process(1.0, pose(1, 0, 0), NOTHING) is None


def test_a_pose_of_another_frame_on_the_robot():
    """The pose of a camera 0.5 m ahead of the robot's center, looking left."""
    robot_in_camera = pose(0.5, 0.0, QUARTER).inverse()
    camera = pose(2.0, 3.0, 1.0).of(pose(0.5, 0.0, QUARTER))
    values = PoseInput(ALL).process(0.0, camera, NOTHING, base=robot_in_camera)
    assert values.value[[0, 1, 5]] == pytest.approx((2.0, 3.0, 1.0))


@pytest.mark.parametrize("mount", [(0, 0, QUARTER), (math.pi, 0, 0), (0.1, -0.2, 2.5)])
def test_an_imu_is_mounted_anyhow(mount):
    robot = matrix(0.05, -0.03, 0.8)
    values = PoseInput(ALL).process_attitude(
        0.0, robot @ matrix(*mount), np.zeros((3, 3)), Transform(matrix(*mount), np.ones(3))
    )
    assert values.value[3:6] == pytest.approx((0.05, -0.03, 0.8))


def test_an_imu_mounted_sideways_swaps_roll_and_pitch():
    sensor = PoseInput((False, False, False, True, False, True))
    values = sensor.process_attitude(
        0.0, np.eye(3), np.diag((0.1, 0.2, 0.3)), pose(0.0, 0.0, QUARTER)
    )
    assert values.used[3:6].tolist() == [False, True, True]
    assert np.diagonal(values.covariance)[3:6] == pytest.approx((0.2, 0.1, 0.3))


def test_a_differential_imu_gives_turn_rates():
    sensor = PoseInput((False, False, False, False, False, True), differential=True)
    assert sensor.process_attitude(0.0, matrix(0, 0, 1.0), np.eye(3)) is None
    values = sensor.process_attitude(0.25, matrix(0, 0, 1.2), np.eye(3))
    assert values.value[11] == pytest.approx(0.8)
    assert values.select()[0].tolist() == [11]


def test_a_relative_imu_starts_at_zero():
    sensor = PoseInput(ALL, relative=True)
    assert sensor.process_attitude(0.0, matrix(0, 0, 1.0), np.eye(3)).value[5] == pytest.approx(0.0)
    assert sensor.process_attitude(0.1, matrix(0, 0, 1.2), np.eye(3)).value[5] == pytest.approx(0.2)


def test_a_speedometer_off_the_center_of_a_turning_robot():
    """1 m ahead, looking left: at 0.5 rad/s it moves 0.5 m/s sideways more than the center."""
    mount, rate, speed = pose(1.0, 0.0, QUARTER), 0.5, 2.0
    in_sensor = mount.rotation.T @ (speed, rate * 1.0, 0.0)
    values = twist(
        in_sensor,
        (0.0, 0.0, rate),
        np.diag((0.1, 0.2, 0.3, 0.4, 0.5, 0.6)),
        (True, False, False, False, False, True),
        mount,
        np.array((0.0, 0.0, rate)),
    )
    assert values.value[6:12] == pytest.approx((speed, 0, 0, 0, 0, rate))
    assert values.used[6:12].tolist() == [False, True, False, False, False, True]
    assert np.diagonal(values.covariance)[6:12] == pytest.approx((0.2, 0.1, 0.3, 0.5, 0.4, 0.6))


def test_an_accelerometer_off_the_center_of_a_turning_robot():
    """At (x, y) it feels the centripetal -w^2 r and the tangential dw x r beside the center's."""
    mount, rate, change = pose(0.4, 0.2, QUARTER), 1.5, 0.7
    center = np.array((0.3, -0.1, 0.0))
    arm = np.array((0.4, 0.2, 0.0))
    felt = center - rate**2 * arm + change * np.array((-0.2, 0.4, 0.0))
    values = acceleration(
        mount.rotation.T @ felt,
        np.diag((0.1, 0.2, 0.3)),
        (True, False, False),
        mount,
        np.array((0.0, 0.0, rate)),
        np.array((0.0, 0.0, change)),
    )
    assert values.value[12:15] == pytest.approx(center)
    assert values.used[12:15].tolist() == [False, True, False]
    assert np.diagonal(values.covariance)[12:15] == pytest.approx((0.2, 0.1, 0.3))


def test_gravity_on_a_slope():
    felt = gravity_of(matrix(0.0, -0.1, 2.0), 9.81)  # nose up by 0.1 rad
    assert felt == pytest.approx((9.81 * math.sin(0.1), 0.0, 9.81 * math.cos(0.1)))


def test_in_the_plane_the_rest_is_zero():
    values = StateValues().set(slice(6, 12), [False] * 6, np.ones(6), np.eye(6)).flatten()
    index, value, covariance = values.select()
    assert index.tolist() == [2, 3, 4, 8, 9, 10, 14]
    assert (value == 0.0).all() and np.diagonal(covariance) == pytest.approx([1e-6] * 7)


def test_used_axes_that_are_turned_a_little_use_both():
    used = rotated(matrix(0.0, 0.0, 0.1), (True, False, False))
    assert used.tolist() == [True, True, False]
    assert rotated(IDENTITY.rotation, ALL).tolist() == [True] * 6
    assert angles(IDENTITY.rotation).tolist() == [0, 0, 0]
