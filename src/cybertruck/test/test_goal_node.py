"""The goal node without a master: ends of goals, resets with and without odometry after them."""

import time

import pytest
import rospy
from actionlib_msgs.msg import GoalStatus
from cybertruck.goal.node import GoalNode
from fake_ros import FakeRos
from nav_msgs.msg import Odometry

from cybertruck.srv import GoalRequest


class Rig:
    """A goal node with a goal 10 m ahead at a ROS time of 50 s.

    Attributes:
        wall: What time.monotonic() gives [s].
    """

    def __init__(self, monkeypatch):
        self.ros = FakeRos()
        self.wall = 1000.0
        self.ros.install(monkeypatch, {"odom_timeout": 0.5})
        monkeypatch.setattr(time, "monotonic", lambda: self.wall)
        self.node = GoalNode()
        self.odometry(50.0)
        self.send(10.0)
        self.odometry(50.008)

    def send(self, x):
        request = GoalRequest()
        request.pose.position.x = x
        assert self.ros.services["goal"](request).success

    def odometry(self, stamp):
        self.ros.now = stamp
        message = Odometry()
        message.header.stamp = rospy.Time.from_sec(stamp)
        message.pose.pose.orientation.w = 1.0
        self.ros.subscribed["odom"](message)

    def watch(self):
        for timer in self.ros.timers:
            timer(None)

    def status(self):
        last = self.ros.messages("goal/status")[-1]
        return last.status, last.text

    def speeds(self):
        return [message.linear.x for message in self.ros.messages("cmd_vel")]


@pytest.fixture
def rig(monkeypatch):
    made = Rig(monkeypatch)
    assert made.status()[0] == GoalStatus.ACTIVE
    assert made.speeds()[-1] > 0.0
    return made


def test_a_reset_aborts_the_goal_with_one_zero(rig):
    before = len(rig.speeds())
    rig.odometry(0.008)
    assert rig.status() == (GoalStatus.ABORTED, "time went back: the simulation was reset")
    assert rig.speeds()[before:] == [0.0]
    rig.odometry(0.016)
    rig.watch()
    assert rig.speeds()[before:] == [0.0]


def test_a_reset_without_odometry_after_it_times_out(rig):
    rig.ros.now = 0.1
    rig.wall += 0.4
    rig.watch()
    assert rig.status()[0] == GoalStatus.ACTIVE  # it may still come
    rig.wall += 0.2
    rig.watch()
    status, text = rig.status()
    assert (status, rig.speeds()[-1]) == (GoalStatus.ABORTED, 0.0) and "no odometry" in text


@pytest.mark.parametrize(
    "ros, wall, status",
    [
        (0.0, 60.0, GoalStatus.ACTIVE),  # a paused world
        (5.0, 0.1, GoalStatus.ACTIVE),  # a world much faster than real time
        (0.6, 0.6, GoalStatus.ABORTED),
    ],
)
def test_the_timeout_has_to_pass_in_both_times(rig, ros, wall, status):
    rig.ros.now += ros
    rig.wall += wall
    rig.watch()
    assert rig.status()[0] == status


def test_a_new_goal_and_a_cancel_preempt(rig):
    rig.send(-5.0)
    first, second, third = rig.ros.messages("goal/status")[-3:]
    found = [each.status for each in (first, second, third)]
    assert found == [GoalStatus.ACTIVE, GoalStatus.PREEMPTED, GoalStatus.ACTIVE]
    assert first.goal_id.id == second.goal_id.id != third.goal_id.id
    cancel = rig.ros.services["goal/cancel"]
    assert cancel(None).success and rig.status()[0] == GoalStatus.PREEMPTED
    assert rig.speeds()[-1] == 0.0 and not cancel(None).success
