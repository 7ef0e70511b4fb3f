#!/usr/bin/env python3
"""Drives through /cmd_vel in the original's units: wheel rad/s, and steps of 15 degrees."""

import math
import unittest

import rospy
import rostest
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from sim_client import Recorder, sleep_sim, turned, wait_connected, wait_for_car, wait_until, yaw_of

WHEEL_RADIUS = 0.03  # [m]
WHEEL_SPEED = 10.0  # [rad/s]
DURATION = 1.0  # simulated time [s]
STEADY_FROM, STEADY_TO = 0.4, 0.9  # part of a drive at full speed [s]


class Drive(unittest.TestCase):
    """Sends what the window's buttons send and measures on the ground truth."""

    @classmethod
    def setUpClass(cls):
        wait_for_car()
        cls.publisher = rospy.Publisher("/cmd_vel", Twist, queue_size=10)
        wait_connected(cls.publisher, "control")
        cls.odometry = Recorder("/racecar/odom", Odometry)

    def setUp(self):
        self.command(0.0, 0.0)
        self.wait_rest()

    def tearDown(self):
        self.command(0.0, 0.0)

    def command(self, linear, angular):
        message = Twist()
        message.linear.x, message.angular.z = linear, angular
        self.publisher.publish(message)

    def wait_rest(self):
        sleep_sim(0.5)
        wait_until(
            lambda: (
                math.hypot(
                    self.odometry.last.twist.twist.linear.x, self.odometry.last.twist.twist.linear.y
                )
                < 1e-3
            ),
            "rest",
        )

    def timed_move(self, linear, angular):
        """Drives for DURATION of simulated time, then waits for rest.

        Returns:
            (pose before, pose after, odometry messages in between).
        """
        before = self.odometry.next().pose.pose
        self.odometry.clear()
        self.command(linear, angular)
        sleep_sim(DURATION)
        self.command(0.0, 0.0)
        self.wait_rest()
        return before, self.odometry.next().pose.pose, self.odometry.messages

    def test_straight_drives_go_as_far_as_the_wheels_turn(self):
        expected = WHEEL_SPEED * WHEEL_RADIUS * DURATION  # [m]
        for sign in (1.0, -1.0):
            before, after, _ = self.timed_move(sign * WHEEL_SPEED, 0.0)
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

    def test_steady_speed_is_wheel_speed_times_radius(self):
        start = rospy.get_time()
        _, _, messages = self.timed_move(WHEEL_SPEED, 0.0)
        steady = [
            item
            for item in messages
            if STEADY_FROM <= item.header.stamp.to_sec() - start <= STEADY_TO
        ]
        first, last = steady[0], steady[-1]
        distance = math.hypot(
            last.pose.pose.position.x - first.pose.pose.position.x,
            last.pose.pose.position.y - first.pose.pose.position.y,
        )
        speed = distance / (last.header.stamp - first.header.stamp).to_sec()
        print(f"steady speed: {speed:.5f} m/s")
        self.assertAlmostEqual(speed, WHEEL_SPEED * WHEEL_RADIUS, delta=0.003)
        for item in steady:  # the twist is in the child frame: forward is x, whatever the heading
            self.assertAlmostEqual(item.twist.twist.linear.x, speed, delta=0.01)
            self.assertAlmostEqual(item.twist.twist.linear.y, 0.0, delta=0.01)

    def test_left_is_negative_and_turns_left(self):
        for angular, name in ((-1.0, "left"), (1.0, "right"), (-5.0, "left"), (5.0, "right")):
            before, after, _ = self.timed_move(WHEEL_SPEED, angular)
            turn = math.degrees(turned(yaw_of(before.orientation), yaw_of(after.orientation)))
            print(f"angular {angular:+g}: turned {turn:.1f} deg")
            self.assertGreater(turn * (1.0 if name == "left" else -1.0), 5.0, name)

    def test_commands_that_are_no_numbers_stop_the_car(self):
        self.command(WHEEL_SPEED, 0.0)
        sleep_sim(0.5)
        self.command(math.nan, 0.0)
        self.wait_rest()


if __name__ == "__main__":
    rospy.init_node("drive_test")
    rostest.rosrun("paddock_tests", "drive", Drive)
