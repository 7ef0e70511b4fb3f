"""diff_drive_controller on a ROS graph: commands arrive, odometry and transform are sent.

Limits, circle, time-out and reset: src/bullet_bridge/test/test_diff_bot.py.
"""

import subprocess
import unittest
from pathlib import Path

import rospy
import yaml
from gazebo_msgs.srv import DeleteModel, SpawnModel
from geometry_msgs.msg import Point, Pose, Quaternion, Twist
from nav_msgs.msg import Odometry
from paddock_common.process import stop_session
from shared_worlds import EFFORT_BOT as LAUNCH  # noqa: F401
from sim_client import START_LIMIT, Recorder, wait_connected, wait_until
from testing import executable
from tf2_msgs.msg import TFMessage

HERE = Path(__file__).resolve().parent
BASE = "/diff_bot/mobile_base"
AWAY = Pose(Point(5.0, 0.0, 0.0), Quaternion(0.0, 0.0, 0.0, 1.0))
SPEED = 0.4  # [m/s]


class DiffDrive(unittest.TestCase):
    """Drives by cmd_vel, reads odom, /tf and the ground truth."""

    @classmethod
    def setUpClass(cls):
        for name, value in yaml.safe_load((HERE / "diff_drive.yaml").read_text()).items():
            rospy.set_param(f"/diff_bot/{name}", value)
        rospy.wait_for_service("/gazebo/spawn_urdf_model", START_LIMIT)
        spawn = rospy.ServiceProxy("/gazebo/spawn_urdf_model", SpawnModel)
        text = (HERE / "diff_bot.urdf").read_text()
        assert spawn("diff_bot", text, "/diff_bot", AWAY, "world").success
        delete = rospy.ServiceProxy("/gazebo/delete_model", DeleteModel)
        cls.addClassCleanup(delete, "diff_bot")
        spawner = subprocess.Popen(
            [executable("controller_manager", "spawner"), "mobile_base"]
            + ["--namespace", "/diff_bot"],
            start_new_session=True,
        )
        cls.addClassCleanup(stop_session, spawner, START_LIMIT)
        cls.commands = rospy.Publisher(f"{BASE}/cmd_vel", Twist, queue_size=1)
        wait_connected(cls.commands, "the base's controller")
        cls.odom = Recorder(f"{BASE}/odom", Odometry)
        cls.truth = Recorder("/ground_truth", Odometry)
        cls.tf = Recorder("/tf", TFMessage)
        cls.odom.wait_count(1, START_LIMIT)
        cls.truth.wait_count(1)

    def test_it_drives_by_twists(self):
        command = Twist()
        command.linear.x = SPEED

        def fast():
            self.commands.publish(command)
            return abs(self.odom.last.twist.twist.linear.x - SPEED) < 0.01 * SPEED

        wait_until(fast, f"{SPEED} m/s")
        wait_until(lambda: self.truth.last.pose.pose.position.x > AWAY.position.x + 0.05, "its way")

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
