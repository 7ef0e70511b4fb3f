"""The filter and the satellite fixes, fed with a drive on paper: a circle, with noise.

The truth is a closed form of time, and every estimate is compared at its own stamp.
"""

import contextlib
import math
import threading
import time
import unittest

import numpy as np
import rospy
import tf2_ros
from geometry_msgs.msg import AccelWithCovarianceStamped, Point, PoseWithCovarianceStamped
from nav_msgs.msg import Odometry
from robot_localization.frames import from_quaternion, matrix, to_quaternion
from robot_localization.navsat import UtmGrid
from robot_localization.srv import FromLL, SetPose, ToggleFilterProcessing, ToLL
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import Imu, NavSatFix
from sim_client import START_LIMIT, WALL_LIMIT, Recorder, turned, wait_connected, wait_until, yaw_of
from tf2_msgs.msg import TFMessage

LAUNCH = """<launch>
  <param name="/use_sim_time" value="true"/>

  <node pkg="tf2_ros" type="static_transform_publisher" name="imu_mount"
        args="0.2 0 0.1 1.5707963 0 0 base_link imu_link"/>
  <node pkg="tf2_ros" type="static_transform_publisher" name="gps_mount"
        args="-0.3 0.1 0 0 0 0 base_link gps_link"/>

  <node pkg="robot_localization" type="ekf_localization_node" name="ekf" output="screen">
    <rosparam>
      frequency: 50
      sensor_timeout: 0.1
      two_d_mode: true
      publish_acceleration: true
      odom0: wheel_odometry
      odom0_config: [true, true, false,
                     false, false, false,
                     true, true, false,
                     false, false, true,
                     false, false, false]
      odom0_queue_size: 100
      odom0_pose_rejection_threshold: 8.0
      imu0: imu
      imu0_config: [false, false, false,
                    false, false, true,
                    false, false, false,
                    false, false, true,
                    false, false, false]
      imu0_queue_size: 100
      smooth_lagged_data: true
      history_length: 5.0
      use_control: true
      process_noise_covariance: [1e-4, 1e-4, 1e-4, 1e-4, 1e-4, 1e-4, 0.01, 0.01, 0.01, 0.01, 0.01,
                                 0.01, 0.01, 0.01, 0.01]
      initial_estimate_covariance: [1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0,
                                    1e-9, 1e-9, 1e-9]
    </rosparam>
  </node>

  <node pkg="robot_localization" type="navsat_transform_node" name="navsat" output="screen">
    <rosparam>
      frequency: 50
      wait_for_datum: true
      datum: [48.137, 11.575, 0.0]
      publish_filtered_gps: true
      broadcast_utm_transform: true
    </rosparam>
  </node>

</launch>
"""

START, STEP, PACE = 50.0, 0.02, 0.008  # first time and step [s of ROS time], wall time of a step
DRIVE, STAND = 10.0, 2.0  # how long it drives, and stands after that [s]
SPEED, RATE = 1.2, 0.4  # [m/s], [rad/s]
NOISE = 0.1  # of a measured position [m]
OUTLIERS = 40  # every so many positions one is wrong
END = START + DRIVE + STAND
FIX_EVERY = 10  # steps between two fixes
LATE = 0.2  # age of the last estimate that slows the clock down [s]
DATUM = 48.137, 11.575


def truth(stamp):
    """(x [m], y [m], yaw [rad]) at a time: a circle, then at rest."""
    angle = RATE * min(stamp - START, DRIVE)
    radius = SPEED / RATE
    return radius * math.sin(angle), radius * (1.0 - math.cos(angle)), angle


def fill(message, yaw):
    """Sets a quaternion to a heading."""
    message.x, message.y, message.z, message.w = to_quaternion(matrix(0.0, 0.0, yaw))


class Robot:
    """Publishes /clock in a thread of its own, and the sensors while it drives."""

    def __init__(self):
        self.now, self._measuring = START - 1.0, False
        self.estimated = START  # stamp of the last estimate
        self._fixed = self._placed = START  # stamps of the last fix and the last position from one
        self._rng, self._count = np.random.default_rng(5), 0
        self._clock = rospy.Publisher("/clock", Clock, queue_size=100)
        self.odometry = rospy.Publisher("/wheel_odometry", Odometry, queue_size=100)
        self.imu = rospy.Publisher("/imu", Imu, queue_size=100)
        self.fix = rospy.Publisher("/gps/fix", NavSatFix, queue_size=100)
        rospy.Subscriber("/odometry/filtered", Odometry, self._see, queue_size=1)
        rospy.Subscriber("/odometry/gps", Odometry, self._see_position, queue_size=1)
        self._grid = UtmGrid.at(*DATUM)
        self._datum = self._grid.forward(*DATUM)
        self._convergence = self._grid.convergence(*DATUM)
        threading.Thread(target=self._run, daemon=True).start()

    def _see(self, estimate):
        self.estimated = estimate.header.stamp.to_sec()

    def _see_position(self, position):
        self._placed = position.header.stamp.to_sec()

    def begin(self):
        """Starts the drive."""
        self._measuring = True

    def end(self):
        """Ends the measurements; the clock goes on."""
        self._measuring = False

    def _run(self):
        while not rospy.is_shutdown():
            self.now += STEP if self._measuring or self.now > START else 0.0
            with contextlib.suppress(rospy.ROSException):  # closed at the end of the test
                if self._measuring:
                    self._measure(rospy.Time.from_sec(self.now))
                self._clock.publish(Clock(rospy.Time.from_sec(self.now)))
            # A node that is late gets time: what it says is compared by stamps, not by the wall.
            is_late = self.now - self.estimated >= LATE
            is_late |= self._placed < self._fixed <= self.now - 0.5 * LATE
            time.sleep(20.0 * PACE if is_late else PACE)

    def _measure(self, stamp):
        self._count += 1
        x, y, yaw = truth(stamp.to_sec())
        drives = stamp.to_sec() < START + DRIVE
        odometry = Odometry()
        odometry.header.stamp, odometry.header.frame_id = stamp, "odom"
        odometry.child_frame_id = "base_link"
        wrong = 5.0 if self._count % OUTLIERS == OUTLIERS - 1 else 0.0
        noise = self._rng.normal(0.0, NOISE, 2)
        odometry.pose.pose.position = Point(x + wrong + noise[0], y + noise[1], 0.0)
        odometry.pose.pose.orientation.w = 1.0
        odometry.pose.covariance = (np.eye(6) * NOISE**2).ravel().tolist()
        odometry.twist.twist.linear.x = SPEED * drives + self._rng.normal(0.0, 0.05)
        odometry.twist.twist.angular.z = RATE * drives + self._rng.normal(0.0, 0.05)
        odometry.twist.covariance = (np.eye(6) * 0.05**2).ravel().tolist()
        self.odometry.publish(odometry)

        imu = Imu()
        imu.header.stamp, imu.header.frame_id = stamp, "imu_link"
        fill(imu.orientation, yaw + math.pi / 2.0 + self._rng.normal(0.0, 0.01))
        imu.orientation_covariance = (np.eye(3) * 0.01**2).ravel().tolist()
        imu.angular_velocity.z = RATE * drives + self._rng.normal(0.0, 0.01)
        imu.angular_velocity_covariance = (np.eye(3) * 0.01**2).ravel().tolist()
        imu.linear_acceleration_covariance = [-1.0] + [0.0] * 8
        self.imu.publish(imu)
        if self._count % FIX_EVERY == 0:
            self.fix.publish(self._place(stamp))
            self._fixed = self.now

    def _place(self, stamp):
        """The fix of the antenna at a time: the world is east and north of the datum."""
        x, y, yaw = truth(stamp.to_sec())
        antenna = matrix(0.0, 0.0, yaw) @ (-0.3, 0.1, 0.0) + (x, y, 0.0)
        way = matrix(0.0, 0.0, self._convergence) @ antenna
        fix = NavSatFix()
        fix.header.stamp, fix.header.frame_id = stamp, "gps_link"
        fix.latitude, fix.longitude, _ = self._grid.back(
            self._datum[0] + way[0], self._datum[1] + way[1]
        )
        fix.position_covariance = (np.eye(3) * 0.01).ravel().tolist()
        return fix


class Localization(unittest.TestCase):
    """One drive, then what the services do; the tests run in the order of their names."""

    @classmethod
    def setUpClass(cls):
        cls.robot = Robot()
        cls.estimates = Recorder("/odometry/filtered", Odometry)
        cls.accelerations = Recorder("/accel/filtered", AccelWithCovarianceStamped)
        cls.positions = Recorder("/odometry/gps", Odometry)
        cls.places = Recorder("/gps/filtered", NavSatFix)
        cls.frames = Recorder("/tf", TFMessage)
        for sender in (cls.robot.odometry, cls.robot.imu, cls.robot.fix):
            wait_connected(sender, "the nodes")
        buffer = tf2_ros.Buffer()
        cls.listener = tf2_ros.TransformListener(buffer)
        wait_until(
            lambda: buffer.can_transform("imu_link", "gps_link", rospy.Time()),
            "the mounts",
            START_LIMIT,
        )
        cls.robot.begin()
        wait_until(lambda: cls.robot.now > END, "the end of the drive", 2.0 * START_LIMIT)
        cls.robot.end()
        wait_until(lambda: rospy.get_time() > END + 1.0, "a second of silence")

    def between(self, recorder, begin, end):
        """Messages with stamps between two times after the start [s]; there must be some."""
        found = [m for m in recorder.messages if begin < m.header.stamp.to_sec() - START < end]
        self.assertGreater(len(found), 5)
        return found

    def test_a_estimates_are_better_than_the_measurements(self):
        off = []
        for message in self.between(self.estimates, 2.0, DRIVE):
            x, y, yaw = truth(message.header.stamp.to_sec())
            here = message.pose.pose
            off.append(math.hypot(here.position.x - x, here.position.y - y))
            self.assertLess(abs(turned(yaw, yaw_of(here.orientation))), 0.05)
            self.assertLess(abs(message.twist.twist.linear.x - SPEED), 0.15)
            self.assertLess(abs(message.twist.twist.angular.z - RATE), 0.05)
            self.assertLess(abs(here.position.z), 1e-3)
        self.assertLess(math.sqrt(np.mean(np.square(off))), 0.6 * NOISE)
        self.assertLess(max(off), 2.0 * NOISE)  # outliers are off by 5 m

    def test_b_frames_and_stamps(self):
        estimates = self.estimates.messages
        stamps = [m.header.stamp for m in estimates]
        self.assertEqual(stamps, sorted(set(stamps)))
        self.assertEqual(
            (estimates[0].header.frame_id, estimates[0].child_frame_id), ("odom", "base_link")
        )
        sent = {
            t.header.stamp: t.transform
            for m in self.frames.messages
            for t in m.transforms
            if (t.header.frame_id, t.child_frame_id) == ("odom", "base_link")
        }
        both = [message for message in estimates if message.header.stamp in sent]
        # two topics: a subscriber that connects later, or is slow, misses some of one
        self.assertGreater(len(both), 0.9 * len(estimates))
        for message in both:
            transform = sent[message.header.stamp]
            self.assertEqual(transform.translation.x, message.pose.pose.position.x)
            self.assertEqual(transform.rotation, message.pose.pose.orientation)
        self.assertEqual(self.accelerations.messages[0].header.frame_id, "base_link")

    def test_c_silence_is_predicted_over(self):
        last = self.estimates.last
        self.assertGreater(last.header.stamp.to_sec(), END + 0.5)

    def test_d_fixes_are_positions_of_the_robot(self):
        # While it drives the heading that turns the receiver's arm may be an older one.
        for begin, end, tolerance in ((1.0, DRIVE, 0.65), (DRIVE + 0.5, DRIVE + STAND, 0.02)):
            for message in self.between(self.positions, begin, end):
                x, y, _ = truth(message.header.stamp.to_sec())
                here = message.pose.pose.position
                self.assertLess(math.hypot(here.x - x, here.y - y), tolerance)
                self.assertEqual(message.header.frame_id, "odom")
        self.assertLess(abs(self.places.newest.latitude - DATUM[0]), 1e-3)

    def test_e_places_there_and_back(self):
        to_place = rospy.ServiceProxy("/toLL", ToLL)
        to_world = rospy.ServiceProxy("/fromLL", FromLL)
        rospy.wait_for_service("/toLL", WALL_LIMIT)
        place = to_place(Point(3.0, -4.0, 1.0)).ll_point
        here = to_world(place).map_point
        self.assertAlmostEqual(here.x, 3.0, places=3)
        self.assertAlmostEqual(here.y, -4.0, places=3)
        self.assertAlmostEqual(here.z, 1.0, places=6)
        origin = to_place(Point()).ll_point
        self.assertAlmostEqual(origin.latitude, DATUM[0], places=8)

    def test_f_set_pose_is_a_robot_at_rest_there(self):
        pose = PoseWithCovarianceStamped()
        pose.header.frame_id, pose.header.stamp = "odom", rospy.Time.now()
        pose.pose.pose.position = Point(5.0, 6.0, 0.0)
        fill(pose.pose.pose.orientation, 0.5)
        pose.pose.covariance = (np.eye(6) * 0.01).ravel().tolist()
        rospy.ServiceProxy("/set_pose", SetPose)(pose)
        wait_until(lambda: self.estimates.last.pose.pose.position.x > 4.9, "an estimate of there")
        seen = len(self.estimates.messages)
        message = self.estimates.wait_count(seen + 5)[-1]
        here = message.pose.pose
        self.assertAlmostEqual(here.position.x, 5.0, places=6)
        self.assertAlmostEqual(here.position.y, 6.0, places=6)
        self.assertAlmostEqual(yaw_of(here.orientation), 0.5, places=6)
        self.assertEqual(message.twist.twist.linear.x, 0.0)
        rotation = from_quaternion(0.0, 0.0, here.orientation.z, here.orientation.w)
        self.assertAlmostEqual(rotation[0, 0], math.cos(0.5), places=6)

    def test_g_toggle_says_whether_something_changed(self):
        toggle = rospy.ServiceProxy("/ekf/toggle", ToggleFilterProcessing)
        self.assertEqual([toggle(on).status for on in (True, False, False)], [False, True, False])
        self.assertTrue(toggle(True).status)
