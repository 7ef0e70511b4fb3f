#!/usr/bin/env python
"""Drives the rover through its own command topic and looks where it went."""

import math
import time
import unittest

import rospy
import rostest
from ackermann_msgs.msg import AckermannDriveStamped
from controller_manager_msgs.srv import ListControllers
from gazebo_msgs.srv import GetModelState
from sensor_msgs.msg import Image

from bullet_bridge.srv import Step

STEPS = 100  # of physics in 0.1 s of simulated time
LIMIT = 120.0  # wall time of a wait [s]


class Drive(unittest.TestCase):
    def setUp(self):
        rospy.wait_for_service("/gazebo/step", LIMIT)
        self.step = rospy.ServiceProxy("/gazebo/step", Step)
        self.state = rospy.ServiceProxy("/gazebo/get_model_state", GetModelState)
        self.command = rospy.Publisher(
            "/campus_rover/ackermann_cmd", AckermannDriveStamped, queue_size=1
        )
        self.pictures = 0
        rospy.Subscriber("/campus_rover/front_camera/image_raw", Image, self.on_picture)
        self.wait_for_controllers()

    def on_picture(self, _):
        self.pictures += 1

    def go(self, seconds):
        for _ in range(int(round(seconds * 10.0))):
            self.assertTrue(self.step(STEPS, [], []).success)

    def wait_for_controllers(self):
        name = "/campus_rover/controller_manager/list_controllers"
        rospy.wait_for_service(name, LIMIT)
        states = rospy.ServiceProxy(name, ListControllers)
        end = time.time() + LIMIT
        while time.time() < end:
            running = [item for item in states().controller if item.state == "running"]
            if len(running) == 6 and self.command.get_num_connections() > 0:
                return
            self.go(0.1)
        self.fail(f"the controllers do not run: {states().controller}")

    def test_the_rover_drives_a_left_curve(self):
        before = self.state("campus_rover", "").pose.position
        message = AckermannDriveStamped()
        message.drive.speed, message.drive.steering_angle = 0.8, 0.3
        for _ in range(40):
            self.command.publish(message)
            self.go(0.1)
        after = self.state("campus_rover", "").pose.position
        self.assertGreater(math.hypot(after.x - before.x, after.y - before.y), 1.0)
        self.assertGreater(after.y - before.y, 0.3)
        self.assertGreater(self.pictures, 20)


if __name__ == "__main__":
    rospy.init_node("drive_test")
    rostest.rosrun("campus_rover", "drive", Drive)
