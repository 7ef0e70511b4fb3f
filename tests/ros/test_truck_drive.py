"""The drive node on the ROS graph: commands, outputs, and when it stops."""

import math
import unittest

import rosgraph
import rospy
import tf2_ros
from geometry_msgs.msg import PoseStamped, Twist
from nav_msgs.msg import Odometry
from rosgraph_msgs.msg import Log
from sensor_msgs.msg import JointState, Joy
from sim_client import Recorder, joint, sleep_sim, wait_connected, wait_until
from std_msgs.msg import Float64MultiArray, Int32
from truck_client import TRUTH, Driver, pose_of, wait_for_truck

LAUNCH = """<launch>
  <include file="$(find cybertruck)/launch/truck.launch">
    <arg name="headless" value="true"/>
    <arg name="lockstep" value="true"/>
    <arg name="world" value="$(find cybertruck)/worlds/plane.world"/>
    <arg name="joy" value="true"/>
  </include>
  <include file="$(find paddock_tests)/ros/pacer.launch">
    <arg name="topics" value="[/odom, /cmd_vel, /cmd_cyberdrive, /joy]"/>
    <arg name="lag" value="0.1"/>
    <arg name="patience" value="1.5"/>
  </include>
</launch>
"""

STANDS = 0.01  # [m/s]
PERIOD = 8_000_000  # [ns]


class TruckDrive(unittest.TestCase):
    """One truck for all tests; each leaves it standing."""

    @classmethod
    def setUpClass(cls):
        wait_for_truck()
        cls.odometry = Recorder("/odom", Odometry)
        cls.truth = Recorder(TRUTH, Odometry)
        cls.joints = Recorder("/joint_states", JointState)
        cls.log = Recorder("/rosout", Log)
        cls.driver = Driver()
        cls.twist = rospy.Publisher("/cmd_vel", Twist, queue_size=1)
        wait_connected(cls.twist, "drive node")

    def tearDown(self):
        self.wait_standing()

    def wait_standing(self):
        """Waits until the truck stands and was silent for longer than the watchdog."""
        sleep_sim(0.6)
        wait_until(
            lambda: abs(self.truth.next().twist.twist.linear.x) < STANDS, "the truck standing"
        )
        sleep_sim(0.3)

    def send(self, linear, angular):
        """Publishes one Twist."""
        message = Twist()
        message.linear.x, message.angular.z = linear, angular
        self.twist.publish(message)

    def hold(self, linear, angular, seconds):
        """Repeats a Twist for a simulated time [s]."""
        end = rospy.get_time() + seconds
        while rospy.get_time() < end:
            self.send(linear, angular)
            sleep_sim(0.04)

    def wait_log(self, *words):
        """Waits for a line of the log with all the words."""
        wait_until(
            lambda: any(all(word in line.msg for word in words) for line in self.log.messages),
            f"a log line with {words}",
        )

    def test_what_it_publishes(self):
        """One publisher a topic, a message every 8 ms, transforms down to the trailer."""
        publishers = dict(rosgraph.Master(rospy.get_name()).getSystemState()[0])
        for topic in ("/joint_states", "/odom", "/pose", "/odo_fl", "/odo_fr"):
            self.assertEqual(publishers[topic], ["/drive"], topic)
        self.assertLess(math.dist(pose_of(self.odometry.next()), pose_of(self.truth.next())), 0.2)
        poses = Recorder("/pose", PoseStamped)
        poses.wait_count(100)
        for recorder in (self.joints, self.odometry, poses):
            stamps = [message.header.stamp.to_nsec() for message in recorder.messages[-100:]]
            steps = [after - before for before, after in zip(stamps, stamps[1:])]
            self.assertEqual(min(steps), PERIOD, recorder.topic)
            self.assertTrue(all(step % PERIOD == 0 for step in steps), recorder.topic)
        poses.close()
        buffer = tf2_ros.Buffer()
        listener = tf2_ros.TransformListener(buffer)
        for frame in ("base_footprint", "lidar_link", "front_left_wheel", "trailer_axle"):
            wait_until(
                lambda f=frame: buffer.can_transform("odom", f, rospy.Time(0)),
                f"a transform from odom to {frame}",
            )
        axle = buffer.lookup_transform("base_footprint", "trailer_axle", rospy.Time(0)).transform
        self.assertAlmostEqual(axle.translation.x, -1.0, delta=0.05)
        listener.unregister()

    def test_a_twist_is_driven_and_published_in_the_child_frame(self):
        encoder = Recorder("/odo_fl", Int32)
        self.hold(0.5, 0.4, 3.0)
        for recorder in (self.odometry, self.truth):
            twist = recorder.last.twist.twist
            self.assertAlmostEqual(twist.linear.x, 0.5, delta=0.01, msg=recorder.topic)
            self.assertAlmostEqual(twist.linear.y, 0.0, delta=0.01, msg=recorder.topic)
            self.assertAlmostEqual(twist.angular.z, 0.4, delta=0.01, msg=recorder.topic)
        message = self.odometry.last
        frames = message.header.frame_id, message.child_frame_id
        self.assertEqual(frames, ("odom", "base_footprint"))
        self.assertGreater(message.pose.covariance[35], 0.0)
        self.wait_standing()
        turned = joint(self.joints.next(), "front_left_wheel_joint")[0]
        self.assertAlmostEqual(encoder.next().data, turned * 42 / (2 * math.pi), delta=1.001)
        encoder.close()

    def test_it_stops_without_a_command(self):  # after what time: test_truck_command.py
        axle = Recorder("/cybertruck/axle_controller/command", Float64MultiArray)
        axle.next()
        axle.clear()
        self.send(1.0, 0.0)
        wait_until(
            lambda: max((m.data[0] for m in axle.messages), default=0.0) > 0.5,
            "the truck pulling away",
        )
        wait_until(lambda: axle.last.data[0] == 0.0, "the wheels commanded to stand")
        self.wait_log("older than command_timeout")
        axle.close()

    def test_a_pad_drives_directly_when_it_may(self):
        pad = rospy.Publisher("/joy", Joy, queue_size=1)
        wait_connected(pad, "drive node")
        end = rospy.get_time() + 1.5
        while rospy.get_time() < end:
            pad.publish(Joy(axes=[-0.5, 0.3]))
            sleep_sim(0.04)
        self.assertAlmostEqual(self.odometry.last.twist.twist.linear.x, 0.3, delta=0.01)
        pad.publish(Joy(axes=[0.0]))
        self.wait_log("/joy refused", "1 axes")
        pad.unregister()
