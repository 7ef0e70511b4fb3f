"""Dead reckoning on closed forms; encoders; messages."""

import math
from dataclasses import replace

import numpy as np
import pytest
from cybertruck.drive import commands
from cybertruck.drive.model import CyberModel
from cybertruck.drive.odometry import Errors, Measured, WheelOdometry, ticks

MODEL = CyberModel()
RADIUS = MODEL.geometry.wheel_radius


def along(steering, distance, speed=0.0):
    """Measured after a distance [m] at a steering angle [rad] held constant."""
    angles, rates = MODEL.wheels(steering, distance), MODEL.wheels(steering, speed)
    return Measured(
        angles.left_rear,
        angles.right_rear,
        angles.left_steering,
        angles.right_steering,
        rates.left_rear,
        rates.right_rear,
    )


def run(steering, distance, steps, start=(0.0, 0.0, 0.0)):
    odometry = WheelOdometry(MODEL, start)
    for driven in np.linspace(0.0, distance, steps + 1):
        odometry.update(along(steering, driven, 0.5))
    return odometry


@pytest.mark.parametrize("steps", [1, 7, 1000])
@pytest.mark.parametrize(
    "degrees, distance", [(0, 2.0), (0, -2.0), (20, 1.5), (-35, 2.0), (30, -1.0)]
)
def test_arc(degrees, distance, steps):
    steering = math.radians(degrees)
    odometry = run(steering, distance, steps)
    k = math.tan(steering) / 0.508
    turn = k * distance
    x = math.sin(turn) / k if k else distance
    y = (1 - math.cos(turn)) / k if k else 0.0
    assert (odometry.x, odometry.y) == pytest.approx((x, y), abs=1e-9)
    assert math.remainder(odometry.yaw - turn, 2 * math.pi) == pytest.approx(0.0, abs=1e-9)
    assert (odometry.speed, odometry.yaw_rate) == pytest.approx((0.5, 0.5 * k))


def test_start_pose_and_reset():
    odometry = run(0.0, 2.0, 5, (1.0, -2.0, math.pi / 2))
    assert (odometry.x, odometry.y, odometry.yaw) == pytest.approx((1.0, 0.0, math.pi / 2))
    odometry.reset()
    assert (odometry.x, odometry.y, odometry.yaw) == (1.0, -2.0, math.pi / 2)
    odometry.update(along(0.0, 55.0))  # where the wheels stand at first counts for nothing
    assert odometry.x == 1.0


@pytest.mark.parametrize("period, limit", [(0.0, 0.6), (0.008, 0.6), (0.1, 0.6), (2.0, 12.0)])
def test_a_jump_is_more_than_twice_the_top_speed(period, limit):
    odometry = run(0.0, 2.0, 5)
    for side in (1.0, -1.0):
        assert not odometry.jumped(along(0.0, 2.0 + side * 0.99 * limit), period)
        assert odometry.jumped(along(0.0, 2.0 + side * 1.01 * limit), period)
    one = along(0.0, 2.0)
    assert odometry.jumped(replace(one, rear_left=one.rear_left + 1.01 * limit / RADIUS), period)
    odometry.reset()
    assert not odometry.jumped(along(0.0, 55.0), period)


def test_heading_stays_within_a_turn():
    odometry = run(0.7, 20.0, 400)
    assert -math.pi <= odometry.yaw <= math.pi


def test_covariance_on_a_straight_line():
    """After d meters: along sqrt(d) e, heading sqrt(d) f; across: sum of (d - s)^2 = d^3 / 3."""
    errors = Errors(distance_error=0.01, heading_error=0.0, heading_drift=0.002)
    odometry = WheelOdometry(MODEL, (0.0, 0.0, 0.0), errors)
    still = np.diag(odometry.covariance).copy()
    for driven in np.linspace(0.0, 9.0, 901):
        odometry.update(along(0.0, driven))
    grown = np.diag(odometry.covariance) - still
    assert grown[0] == pytest.approx(9.0 * 0.01**2, rel=1e-6)
    assert grown[2] == pytest.approx(9.0 * 0.002**2, rel=1e-6)
    assert grown[1] == pytest.approx(9.0**3 / 3 * 0.002**2 + 81.0 * still[2], rel=1e-2)
    assert np.linalg.eigvalsh(odometry.covariance).min() > 0.0


def test_covariance_is_constant_at_rest():
    odometry = run(0.3, 3.0, 10)
    before = odometry.covariance.copy()
    for _ in range(100):
        odometry.update(along(0.3, 3.0))
    assert (odometry.covariance == before).all()


@pytest.mark.parametrize(
    "values", [{"distance_error": -0.1}, {"heading_error": math.nan}, {"heading_drift": "much"}]
)
def test_wrong_errors(values):
    with pytest.raises(ValueError, match=next(iter(values))):
        Errors(**values)


@pytest.mark.parametrize(
    "turns, count", [(0, 0), (1, 42), (2.5, 105), (-1, -42), (0.03, 1), (-0.01, -1), (100, 4200)]
)
def test_ticks(turns, count):
    assert ticks(turns * 2 * math.pi + 1e-9) == count


class State:
    """A sensor_msgs/JointState without ROS."""

    def __init__(self, **positions):
        self.name = list(positions)
        self.position = list(positions.values())
        self.velocity = [value / 2.0 for value in self.position]


def full(**changes):
    names = commands.WHEELS + commands.HINGES + commands.ENCODERS + ("hitch_yaw_joint",)
    return State(**{**{name: float(i) for i, name in enumerate(names)}, **changes})


def test_measured_picks_joints_by_name():
    measured, encoders = commands.measured(full())
    assert measured == Measured(0.0, 1.0, 2.0, 3.0, 0.0, 0.5)
    assert encoders == {"front_left_wheel_joint": 4.0, "front_right_wheel_joint": 5.0}


def test_measured_refuses():
    state = full()
    state.velocity.pop()
    with pytest.raises(ValueError, match="velocities"):
        commands.measured(state)
    with pytest.raises(ValueError, match="nan"):
        commands.measured(full(rear_left_wheel_joint=math.nan))
    with pytest.raises(ValueError, match="'rear_left_wheel_joint' is missing"):
        commands.measured(State(other=1.0))


def test_message():
    odometry = run(math.radians(20), 1.0, 100, (1.0, 2.0, 0.5))
    message = commands.odometry(None, ("odom", "base_footprint"), odometry)
    assert (message.header.frame_id, message.child_frame_id) == ("odom", "base_footprint")
    pose, twist = message.pose.pose, message.twist.twist
    assert (pose.position.x, pose.position.y, pose.position.z) == (odometry.x, odometry.y, 0.0)
    assert 2 * math.atan2(pose.orientation.z, pose.orientation.w) == pytest.approx(odometry.yaw)
    # The twist is in the child frame: forward speed, whatever the heading.
    assert (twist.linear.x, twist.linear.y) == (pytest.approx(0.5), 0.0)
    assert twist.angular.z == pytest.approx(0.5 * math.tan(math.radians(20)) / 0.508)
    for matrix in (message.pose.covariance, message.twist.covariance):
        matrix = np.reshape(matrix, (6, 6))
        assert (matrix == matrix.T).all() or np.allclose(matrix, matrix.T)
        assert np.linalg.eigvalsh(matrix).min() > 0.0
    assert message.pose.covariance[35] == odometry.covariance[2, 2]
