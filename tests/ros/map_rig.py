"""A steering map is measured, then predicts curvatures at angles that it has not seen, to 3 %."""

import math
import os
import unittest

import rospy
from cybertruck.trailer.steering import read_map
from nav_msgs.msg import Odometry
from sim_client import START_LIMIT, Recorder, turned, wait_until, yaw_of

from cybertruck.msg import CyberDriveStamped

TEXT = """<launch>
  <include file="$(find cybertruck)/launch/steering_map_drive.launch">
    <arg name="file" value="$(env ROS_LOG_DIR)/steering_map_test.yaml"/>
    <arg name="picture" value="$(env ROS_LOG_DIR)/steering_map_test.png"/>
    <arg name="angles" value="{angles}"/>
    <arg name="check_angles" value="[0.4]"/>
    <arg name="longest" value="1.5"/>
  </include>
  <include file="$(find cybertruck)/launch/truck.launch">
    <arg name="world" value="$(find paddock_tests)/ros/coarse.world"/>
    <arg name="trailer" value="false"/>
    <arg name="lidar" value="false"/>
    <arg name="headless" value="true"/>
    <arg name="lockstep" value="true"/>
  </include>
  <include file="$(find paddock_tests)/ros/pacer.launch">
    <arg name="topics" value="[/odom, /cmd_cyberdrive]"/>
    <arg name="settle" value="0.5"/>
  </include>
</launch>
"""

PATIENCE = 400.0  # wall time that the drive may take on a loaded machine [s]
SPEED = 0.5  # [m/s]


def launch(*angles):
    """Text of a launch file that measures a map at some angles [rad]."""
    return TEXT.replace("{angles}", str(list(angles)))


class MapCase(unittest.TestCase):
    """Waits for the map, then drives itself."""

    def check_map(self, count, angles):
        """Checks a map of so many angles by others [rad]."""
        file = os.path.join(os.environ["ROS_LOG_DIR"], "steering_map_test.yaml")
        truth = Recorder("/ground_truth/odom", Odometry)
        truth.next(START_LIMIT)
        commands = Recorder("/cmd_cyberdrive", CyberDriveStamped)
        picture = os.path.join(os.environ["ROS_LOG_DIR"], "steering_map_test.png")
        wait_until(
            lambda: os.path.exists(picture) and os.path.exists(file), "map and picture", PATIENCE
        )
        self.assertLess(max(abs(item.drive.speed) for item in commands.messages), 0.7)
        steering = read_map(file)
        self.assertEqual(len(steering.angles), count)
        for angle in angles:
            measured = self.curvature(truth, angle)
            expected = float(steering.curvature(angle))
            print(f"{angle:.2f} rad: {measured:.4f} 1/m, map {expected:.4f}")
            self.assertLess(abs(expected / measured - 1.0), 0.03)
            self.assertAlmostEqual(float(steering.steering(measured)), angle, delta=0.03)

    def curvature(self, truth, angle):
        """Drives at an angle [rad] and gives turn per distance [1/m], from ground truth."""
        publisher = rospy.Publisher("/cmd_cyberdrive", CyberDriveStamped, queue_size=1)

        def drive(seconds):
            start = truth.last.header.stamp.to_sec()

            def driven():
                message = CyberDriveStamped()
                message.header.stamp = rospy.Time.now()
                message.drive.steering_angle, message.drive.speed = angle, SPEED
                publisher.publish(message)
                return truth.last.header.stamp.to_sec() - start > seconds

            wait_until(driven, f"{seconds:g} s of driving", PATIENCE)

        drive(2.0)
        truth.clear()
        truth.next()
        drive(2.5)
        poses = [item.pose.pose for item in truth.messages]
        publisher.unregister()
        headings = [yaw_of(pose.orientation) for pose in poses]
        turn = sum(turned(one, two) for one, two in zip(headings, headings[1:]))
        points = [(pose.position.x, pose.position.y) for pose in poses]
        self.assertGreater(len(points), 100)
        return turn / sum(map(math.dist, points, points[1:]))
