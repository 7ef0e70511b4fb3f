"""Drives through /cmd_vel in the original's units: wheel rad/s, and steps of 15 degrees."""

import math
import unittest

import rospy
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from shared_worlds import CAR as LAUNCH  # noqa: F401
from sim_client import CAR_COMMANDS, Recorder, turned, wait_connected, wait_for_car, yaw_of
from stepping import PHYSICS_STEP, Time

WHEEL_RADIUS = 0.03  # [m]
WHEEL_SPEED = 10.0  # [rad/s]
DURATION = 1.0  # simulated time [s]


class Drive(unittest.TestCase):
    """Sends what the window's buttons send and measures on the ground truth."""

    @classmethod
    def setUpClass(cls):
        wait_for_car()
        cls.publisher = rospy.Publisher("/original/cmd_vel", Twist, queue_size=10)
        wait_connected(cls.publisher, "control")
        cls.odometry = Recorder("/racecar/odom", Odometry)
        cls.time = Time(CAR_COMMANDS, [cls.odometry.topic], "/original/control")

    @classmethod
    def tearDownClass(cls):
        cls.time.close()

    def setUp(self):
        self.command(0.0, 0.0)
        self.wait_rest()

    def tearDown(self):
        self.command(0.0, 0.0)

    def command(self, linear, angular):
        message = Twist()
        message.linear.x, message.angular.z = linear, angular
        self.publisher.publish(message)
        self.time.go(PHYSICS_STEP, commands=1)

    def wait_rest(self):
        """Lets time go on until the car stands; gives its pose."""
        for _ in range(10):
            self.time.go(0.5)
            message = self.time.latest(self.odometry)
            speed = message.twist.twist.linear
            if math.hypot(speed.x, speed.y) < 1e-3:
                return message.pose.pose
        raise AssertionError(f"no rest within 5 s: {speed}")

    def timed_move(self, linear, angular):
        """Drives for DURATION of simulated time, then on to rest.

        Returns:
            Poses before and after.
        """
        before = self.time.latest(self.odometry).pose.pose
        self.command(linear, angular)
        self.time.go(DURATION - PHYSICS_STEP)
        self.command(0.0, 0.0)
        return before, self.wait_rest()

    def test_straight_drives_go_as_far_as_the_wheels_turn(self):
        expected = WHEEL_SPEED * WHEEL_RADIUS * DURATION  # [m]
        for sign in (1.0, -1.0):
            before, after = self.timed_move(sign * WHEEL_SPEED, 0.0)
            heading = yaw_of(before.orientation)
            dx = after.position.x - before.position.x
            dy = after.position.y - before.position.y
            along = dx * math.cos(heading) + dy * math.sin(heading)
            aside = dy * math.cos(heading) - dx * math.sin(heading)
            drift = math.degrees(turned(heading, yaw_of(after.orientation)))
            print(f"straight {sign:+g}: {along:.4f} m along, {aside:.5f} m aside, {drift:.3f} deg")
            self.assertAlmostEqual(along, sign * expected, delta=0.05 * expected)
            self.assertLess(abs(aside), 0.01)
            self.assertLess(abs(drift), 1.0)

    def test_left_is_negative_and_turns_left(self):
        for angular, name in ((-1.0, "left"), (5.0, "right")):
            before, after = self.timed_move(WHEEL_SPEED, angular)
            turn = math.degrees(turned(yaw_of(before.orientation), yaw_of(after.orientation)))
            print(f"angular {angular:+g}: turned {turn:.1f} deg")
            self.assertGreater(turn * (1.0 if name == "left" else -1.0), 5.0, name)
