"""The drive node without a master: invalid and missing joint states, resets of time and world."""

import math

import pytest
import rospy
from cybertruck.drive import commands
from cybertruck.drive.model import CyberModel
from cybertruck.drive.node import Drive
from fake_ros import FakeRos
from geometry_msgs.msg import Twist
from sensor_msgs.msg import JointState

PERIOD = 0.008  # of joint states [s]
TIMEOUT = 0.5  # command_timeout [s]
RADIUS = 0.1016  # of a wheel [m]
BRAKING = 2.0  # max_acceleration [m/s^2]
START = {"start_x": 1.0, "start_y": -2.0, "start_yaw": 0.5}
NAMES = commands.WHEELS + commands.HINGES + commands.ENCODERS
AXLE = "/cybertruck/axle_controller/command"


class Rig:
    """A drive node whose wheels follow commands at once."""

    def __init__(self, monkeypatch):
        self.ros = FakeRos()
        self.ros.now = 10.0
        self.ros.install(monkeypatch, START)
        self.node = Drive()
        self.wheel = 0.0  # angle of all wheels [rad]

    def joints(self, **changes):
        """One good message of joint states, or one with changed positions, after PERIOD."""
        self.ros.now += PERIOD
        self.wheel += self.axle() * PERIOD
        self.bring({**self.positions(), **changes})

    def positions(self):
        return {name: 0.0 if name in commands.HINGES else self.wheel for name in NAMES}

    def bring(self, positions, stamp=None):
        message = JointState(
            name=list(positions), position=list(positions.values()), velocity=[0.0] * len(positions)
        )
        message.header.stamp = rospy.Time.from_sec(self.ros.now if stamp is None else stamp)
        self.ros.subscribed["/cybertruck/joint_states"](message)

    def drive(self, speed, seconds):
        """Repeats a command while joint states come."""
        message = Twist()
        message.linear.x = speed
        for _ in range(round(seconds / PERIOD)):
            self.ros.subscribed["/cmd_vel"](message)
            self.joints()

    def watch(self):
        for timer in self.ros.timers:
            timer(None)

    def axle(self):
        """Commanded speed of the rear wheels [rad/s]."""
        sent = self.ros.messages(AXLE)
        return sent[-1].data[0] if sent else 0.0

    def pose(self):
        pose = self.ros.messages("/odom")[-1].pose.pose
        return (
            pose.position.x,
            pose.position.y,
            2.0 * math.atan2(pose.orientation.z, pose.orientation.w),
        )


@pytest.fixture
def rig(monkeypatch):
    made = Rig(monkeypatch)
    made.drive(1.0, 1.0)
    assert made.axle() == pytest.approx(1.0 / RADIUS)
    return made


def at_start(rig):
    return rig.pose() == pytest.approx(tuple(START.values()), abs=1e-9)


@pytest.mark.parametrize(
    "bad, words",
    [
        ({"rear_left_wheel_joint": math.nan}, "is nan"),
        ({"front_left_steer_joint": math.inf}, "is inf"),
    ],
)
def test_joint_states_that_are_not_finite_brake_the_truck(rig, bad, words):
    rig.joints(**bad)
    assert rig.axle() == pytest.approx((1.0 - BRAKING * PERIOD) / RADIUS)
    for _ in range(70):  # 1 m/s at 2 m/s^2: 0.5 s
        rig.joints(**bad)
    assert rig.axle() == 0.0
    assert any(words in text and "brakes" in text for text in rig.ros.texts("err"))
    rig.drive(0.5, 1.0)
    assert rig.axle() == pytest.approx(0.5 / RADIUS)


def test_a_missing_joint_brakes_the_truck(rig):
    for _ in range(70):
        rig.ros.now += PERIOD
        positions = rig.positions()
        del positions["rear_right_wheel_joint"]
        rig.bring(positions)
    assert rig.axle() == 0.0
    assert any("'rear_right_wheel_joint' is missing" in text for text in rig.ros.texts("err"))


def test_missing_joint_states_stop_the_wheels(rig):
    rig.ros.now += 0.9 * TIMEOUT
    rig.watch()
    assert rig.axle() == pytest.approx(1.0 / RADIUS)
    rig.ros.now += 0.2 * TIMEOUT
    rig.watch()
    assert tuple(rig.ros.messages(AXLE)[-1].data) == (0.0, 0.0)
    rig.watch()
    assert sum("no message for 0.5 s" in text for text in rig.ros.texts("err")) == 1
    rig.drive(1.0, 2 * PERIOD)  # they are back: from standstill, one step is 0.1 s at the most
    assert 0.0 < rig.axle() <= BRAKING * (0.1 + PERIOD) / RADIUS + 1e-9


def test_a_command_without_joint_states_does_not_move_the_wheels(rig):
    rig.ros.now += 1.2 * TIMEOUT
    message = Twist()
    message.linear.x = 1.0
    rig.ros.subscribed["/cmd_vel"](message)
    rig.watch()
    assert rig.axle() == 0.0


def test_before_the_first_joint_states_nothing_is_published(monkeypatch):
    rig = Rig(monkeypatch)
    rig.ros.now += 10.0
    rig.watch()
    assert rig.ros.messages(AXLE) == [] and rig.ros.texts("err") == []


def test_the_timeout_restarts_when_time_goes_back(rig):
    rig.ros.now = 0.1
    rig.watch()
    assert rig.axle() == pytest.approx(1.0 / RADIUS)
    rig.ros.now = 0.1 + 1.1 * TIMEOUT
    rig.watch()
    assert rig.axle() == 0.0


def test_a_clock_behind_the_joint_states_does_not_stop_the_truck(rig):
    stopped = rig.ros.now  # where /clock stands, while joint states and commands come
    message = Twist()
    message.linear.x = 1.0
    for step in range(round(2.0 * TIMEOUT / PERIOD)):
        rig.ros.subscribed["/cmd_vel"](message)
        rig.bring(rig.positions(), stopped + step * PERIOD)
        rig.wheel += rig.axle() * PERIOD
    rig.ros.now = stopped + 2.0 * TIMEOUT  # then it catches up
    rig.watch()
    assert rig.axle() == pytest.approx(1.0 / RADIUS)


def test_time_that_goes_back_restarts_odometry(rig):
    assert not at_start(rig)
    rig.ros.now, rig.wheel = 0.0, 0.0
    rig.joints()
    assert at_start(rig) and rig.axle() == 0.0


def test_wheels_that_jump_restart_odometry(rig):
    """After a reset with a monotonic clock time continues, and the wheels are at their start."""
    rig.drive(1.0, 1.0)
    assert math.dist(rig.pose()[:2], (1.0, -2.0)) > 1.0
    rig.wheel = -rig.axle() * PERIOD
    rig.joints()
    assert at_start(rig) and rig.axle() == 0.0
    assert any("jumped" in text for text in rig.ros.texts("info"))
    rig.drive(0.5, 0.5)
    assert math.dist(rig.pose()[:2], (1.0, -2.0)) < 0.3


def test_lost_joint_states_are_no_jump(rig):
    """Two seconds at top speed turn the wheels far, but no further than they can."""
    before = rig.pose()
    rig.ros.now += 2.0
    rig.wheel += 2.0 * 3.0 / RADIUS
    rig.bring(rig.positions())
    assert math.dist(rig.pose()[:2], before[:2]) == pytest.approx(6.0)


def test_wheel_speeds_of_the_model_are_within_the_jump_limit():
    """The outer wheel of the tightest circle at top speed is slower than twice the mean."""
    model = CyberModel()
    wheels = model.wheels(0.7854, 3.0)
    assert max(wheels.left_rear, wheels.right_rear) < 2.0 * 3.0 / RADIUS


def test_at_shutdown_the_wheels_stop_and_nothing_follows(rig):
    rig.drive(0.5, 1.0)
    (end,) = rig.ros.hooks
    end()
    assert rig.axle() == 0.0
    before = len(rig.ros.sent)
    rig.drive(0.5, 0.1)  # messages that were being handled
    rig.watch()
    assert len(rig.ros.sent) == before


@pytest.mark.parametrize(
    "name, value, words",
    [
        ("odom_source", "gps", "odom_source is 'gps'.*wheels, ground_truth"),
        ("wheelbase", -0.5, "wheelbase is -0.5.*above 0"),
        ("start_x", "here", "start_x is 'here'.*must be a number"),
        ("joy", "maybe", "joy is 'maybe'.*true or false"),
    ],
)
def test_wrong_parameters_are_named(monkeypatch, name, value, words):
    FakeRos().install(monkeypatch, {name: value})
    with pytest.raises(ValueError, match=words):
        Drive()
