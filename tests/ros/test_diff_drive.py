"""diff_drive_controller: limits, a circle with true odometry, the transform, the time-out."""

import math
import threading
import unittest

import rospy
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from sim_client import START_LIMIT, Recorder, sleep_sim, turned, wait_connected, wait_until, yaw_of
from std_srvs.srv import Empty
from tf2_msgs.msg import TFMessage

LAUNCH = """<launch>
  <include file="$(find gazebo_ros)/launch/empty_world.launch">
    <arg name="gui" value="false"/>
    <arg name="headless" value="true"/>
    <arg name="lockstep" value="true"/>
  </include>
  <param name="robot_description" textfile="$(find paddock_tests)/ros/diff_bot.urdf"/>
  <rosparam file="$(find paddock_tests)/ros/diff_drive.yaml" command="load"/>
  <node name="spawn_bot" pkg="gazebo_ros" type="spawn_model" output="screen"
        args="-urdf -param robot_description -model diff_bot"/>
  <node name="controllers" pkg="controller_manager" type="spawner" output="screen"
        args="--timeout 120 joint_state_controller mobile_base"/>
  <include file="$(find paddock_tests)/ros/pacer.launch">
    <arg name="topics" value="[/mobile_base/cmd_vel]"/>
    <arg name="lag" value="0.1"/>
    <arg name="patience" value="1.5"/>
  </include>
</launch>
"""

SPEED, RATE = 0.4, 0.8  # [m/s], [rad/s]: a circle with a radius of 0.5 m
ACCELERATION = 2.0  # [m/s^2] limit in diff_drive.yaml
MAX_SPEED = 1.0  # [m/s] limit in diff_drive.yaml
TIMEOUT = 0.25  # [s] in diff_drive.yaml
STANDING = 0.02  # [m/s]: contacts of its narrow wheels leave some millimeters a second


class Driver:
    """Publishes a Twist periodically in a thread, as teleops do."""

    def __init__(self, publisher):
        self._publisher, self._twist = publisher, None
        threading.Thread(target=self._run, daemon=True).start()

    def _run(self):
        while not rospy.is_shutdown():
            twist = self._twist
            if twist is not None:
                self._publisher.publish(twist)
            rospy.rostime.wallsleep(0.02)

    def drive(self, speed, rate):
        """Sends this from now on; None as speed: nothing."""
        twist = Twist()
        if speed is not None:
            twist.linear.x, twist.angular.z = speed, rate
        self._twist = None if speed is None else twist


class DiffDrive(unittest.TestCase):
    """Drives on /mobile_base/cmd_vel, reads /mobile_base/odom, /tf and the ground truth."""

    @classmethod
    def setUpClass(cls):
        publisher = rospy.Publisher("/mobile_base/cmd_vel", Twist, queue_size=1)
        wait_connected(publisher, "the base's controller")
        cls.driver = Driver(publisher)
        cls.odom = Recorder("/mobile_base/odom", Odometry)
        cls.truth = Recorder("/ground_truth", Odometry)
        cls.tf = Recorder("/tf", TFMessage)
        cls.odom.wait_count(1, START_LIMIT)
        cls.truth.wait_count(1)

    def tearDown(self):
        self.driver.drive(None, 0.0)
        wait_until(
            lambda: (
                abs(self.truth.last.twist.twist.linear.x) < STANDING
                and abs(self.truth.last.twist.twist.linear.y) < STANDING
            ),
            "the base standing",
        )

    def pair(self):
        """Odometry and truth of one time."""
        self.odom.clear()
        self.truth.clear()

        def match():
            stamps = {m.header.stamp: m for m in self.truth.messages}
            return next(
                (
                    (m, stamps[m.header.stamp])
                    for m in self.odom.messages
                    if m.header.stamp in stamps
                ),
                None,
            )

        return wait_until(match, "odometry and truth of one time")

    def test_circle_has_its_radius_and_odometry_agrees_with_the_truth(self):
        self.driver.drive(SPEED, RATE)
        sleep_sim(1.0)
        first, first_truth = self.pair()
        headings = [yaw_of(first_truth.pose.pose.orientation)]
        travelled = 0.0
        while travelled < 2.0 * math.pi:
            sleep_sim(0.25)
            last, last_truth = self.pair()
            headings.append(yaw_of(last_truth.pose.pose.orientation))
            travelled += turned(headings[-2], headings[-1])
        seconds = (last.header.stamp - first.header.stamp).to_sec()
        self.assertAlmostEqual(travelled / seconds, RATE, delta=0.02 * RATE)
        self.assertAlmostEqual(last.twist.twist.linear.x, SPEED, delta=0.01 * SPEED)
        self.assertAlmostEqual(last.twist.twist.angular.z, RATE, delta=0.01 * RATE)
        # both paths, brought to a common start, must stay together
        difference = self.relative(first, last), self.relative(first_truth, last_truth)
        self.assertLess(math.dist(*[d[:2] for d in difference]), 0.03)
        self.assertAlmostEqual(turned(difference[0][2], difference[1][2]), 0.0, delta=0.06)

    @staticmethod
    def relative(start, end):
        """Position and heading of `end` in the frame of `start`."""
        heading = yaw_of(start.pose.pose.orientation)
        dx = end.pose.pose.position.x - start.pose.pose.position.x
        dy = end.pose.pose.position.y - start.pose.pose.position.y
        return (
            math.cos(heading) * dx + math.sin(heading) * dy,
            -math.sin(heading) * dx + math.cos(heading) * dy,
            turned(heading, yaw_of(end.pose.pose.orientation)),
        )

    def test_acceleration_and_speed_are_limited(self):
        self.odom.clear()
        self.driver.drive(5.0, 0.0)
        wait_until(
            lambda: (
                self.odom.last is not None
                and self.odom.last.twist.twist.linear.x > 0.98 * MAX_SPEED
            ),
            "top speed",
        )
        sleep_sim(0.3)
        speeds = [(m.header.stamp.to_sec(), m.twist.twist.linear.x) for m in self.odom.messages]
        self.assertLess(max(speed for _, speed in speeds), 1.01 * MAX_SPEED)
        for (t0, v0), (t1, v1) in zip(speeds, speeds[1:]):
            self.assertLess((v1 - v0) / (t1 - t0), 1.15 * ACCELERATION)

    def test_the_base_stops_when_commands_cease(self):
        self.driver.drive(0.5, 0.0)
        wait_until(lambda: self.odom.last.twist.twist.linear.x > 0.49, "0.5 m/s")
        self.driver.drive(None, 0.0)
        self.odom.clear()
        wait_until(
            lambda: self.odom.last is not None and abs(self.odom.last.twist.twist.linear.x) < 0.005,
            "standing still",
        )
        moving = [
            m.header.stamp.to_sec() for m in self.odom.messages if m.twist.twist.linear.x > 0.49
        ]
        self.assertTrue(moving, "it did not go on until the time-out")
        stopped = next(
            stamp
            for message in self.odom.messages
            if abs(message.twist.twist.linear.x) < 0.005
            and (stamp := message.header.stamp.to_sec()) > moving[-1]
        )
        self.assertAlmostEqual(stopped - moving[-1], 0.5 / ACCELERATION, delta=0.1)
        # the last command may be late by the pacer's lag; exactly: test_drive_controllers.py
        self.assertLess(stopped - moving[0], TIMEOUT + 0.5 / ACCELERATION + 0.5)

    def test_frames_covariances_and_transform(self):
        message = self.odom.next()
        self.assertEqual(
            (message.header.frame_id, message.child_frame_id), ("odom", "base_footprint")
        )
        self.assertEqual(message.pose.covariance[0], 0.001)
        self.assertEqual(message.twist.covariance[35], 0.03)

        def same():
            return next(
                (
                    t
                    for m in self.tf.messages
                    for t in m.transforms
                    if t.header.stamp == message.header.stamp
                    and t.child_frame_id == "base_footprint"
                ),
                None,
            )

        transform = wait_until(same, "the transform of the odometry's time")
        self.assertEqual(transform.header.frame_id, "odom")
        self.assertEqual(transform.transform.translation.x, message.pose.pose.position.x)
        self.assertEqual(transform.transform.rotation, message.pose.pose.orientation)

    def test_reset_puts_the_odometry_back(self):
        self.driver.drive(0.5, 0.0)
        wait_until(lambda: abs(self.odom.last.pose.pose.position.x) > 0.2, "some way")
        self.driver.drive(None, 0.0)
        rospy.ServiceProxy("/gazebo/reset_simulation", Empty)()  # reset_world resets no controller
        wait_until(
            lambda: (
                math.hypot(self.odom.last.pose.pose.position.x, self.odom.last.pose.pose.position.y)
                < 0.02
            ),
            "odometry at its origin",
        )
