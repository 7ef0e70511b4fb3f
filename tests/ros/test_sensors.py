"""Sensors as the gazebo_ros plugins publish them: names, rates, and what they measure."""

import json
import math
import unittest

import numpy as np
import rospy
from gazebo_msgs.msg import ModelState
from gazebo_msgs.srv import ApplyBodyWrench, BodyRequest, SetModelState
from nav_msgs.msg import Odometry
from sensor_msgs.msg import CameraInfo, Image, LaserScan, PointCloud2
from sim_client import START_LIMIT, Recorder, sleep_sim, wait_until
from std_msgs.msg import String

LAUNCH = """<launch>
  <include file="$(find gazebo_ros)/launch/empty_world.launch">
    <arg name="world_name" value="$(find paddock_tests)/ros/sensors.world"/>
    <arg name="gui" value="false"/>
    <arg name="labels" value="true"/>
  </include>
  <param name="robot_description" textfile="$(find paddock_tests)/ros/sensor_bot.urdf"/>
  <node name="spawn" pkg="gazebo_ros" type="spawn_model" output="screen"
        args="-urdf -param robot_description -model bot -z 0.1"/>
  <param name="/gazebo/pub_clock_frequency" value="50.0"/>
</launch>
"""

WALL = 3.0 - 0.25  # from the mast to the wall's face [m]
REST = 0.1  # height of its link frame at rest [m]


def periods(messages):
    """Simulated times between messages [s]."""
    return np.diff([message.header.stamp.to_sec() for message in messages])


class Sensors(unittest.TestCase):
    """The bot faces a red wall; nothing moves unless a test moves it."""

    @classmethod
    def setUpClass(cls):
        rospy.wait_for_service("/gazebo/set_model_state", START_LIMIT)
        cls.move = rospy.ServiceProxy("/gazebo/set_model_state", SetModelState)
        cls.push = rospy.ServiceProxy("/gazebo/apply_body_wrench", ApplyBodyWrench)
        cls.release = rospy.ServiceProxy("/gazebo/clear_body_wrenches", BodyRequest)
        wait_until(
            lambda: any(name == "/imu/data" for name, _ in rospy.get_published_topics()),
            "the bot's topics",
            START_LIMIT,
        )

    def setUp(self):
        """Each test finds the bot facing the wall, however long it had to wait."""
        self.place(0.0)
        sleep_sim(0.3)

    def place(self, x):
        state = ModelState(model_name="bot")
        state.pose.position.x, state.pose.position.z = x, REST
        self.assertTrue(self.move(state).success)

    def record(self, topic, kind, count):
        recorder = Recorder(topic, kind)
        messages = recorder.wait_count(count, START_LIMIT)[:count]
        recorder.close()
        return messages

    def test_label_images_tell_the_model_of_each_pixel(self):
        message = self.record("/kinect/rgb/labels/image_raw", Image, 3)[-1]
        self.assertEqual((message.encoding, message.header.frame_id), ("32SC1", "kinect_optical"))
        labels = np.frombuffer(message.data, np.int32).reshape(message.height, message.width)
        names = json.loads(self.record("/gazebo/labels", String, 1)[0].data)
        self.assertEqual(names[str(labels[60, 80])], "wall")
        self.assertLessEqual({str(label) for label in np.unique(labels)}, {"0", *names})

    def test_depth_camera(self):
        """Pictures at its rate, points on the wall, both infos alike."""
        topics = "depth/image_raw", "depth/points", "rgb/camera_info", "depth/camera_info"
        kinds = Image, PointCloud2, CameraInfo, CameraInfo
        recorders = [Recorder(f"/kinect/{name}", kind) for name, kind in zip(topics, kinds)]
        for recorder in recorders:
            self.addCleanup(recorder.close)
        pictures, clouds, *infos = (recorder.wait_count(4, START_LIMIT) for recorder in recorders)
        counts = periods(pictures) / 0.1  # a slow renderer may leave some out
        np.testing.assert_allclose(counts, np.rint(counts), atol=1e-6)
        self.assertGreaterEqual(counts.min(), 0.999)
        picture, cloud = pictures[-1], clouds[-1]
        form = picture.encoding, picture.width, picture.height, picture.step
        self.assertEqual(form, ("32FC1", 160, 120, 640))
        depth = np.frombuffer(picture.data, "<f4").reshape(120, 160)
        np.testing.assert_allclose(depth[40:60, 40:120], WALL, atol=0.01)  # [m], along the axis
        self.assertTrue(np.isnan(depth[0, :]).all())  # above the wall: beyond the cut-off
        self.assertEqual([field.name for field in cloud.fields], ["x", "y", "z", "rgb"])
        points = np.frombuffer(cloud.data, "<f4").reshape(120, 160, cloud.point_step // 4)
        self.assertAlmostEqual(points[50, 80, 2], WALL, delta=0.01)
        self.assertEqual(infos[0][-1].K, infos[1][-1].K)
        self.assertAlmostEqual(infos[0][-1].K[0], 80.0 / math.tan(0.6), places=6)
        frames = {message.header.frame_id for message in (picture, cloud, *infos[0], *infos[1])}
        self.assertEqual(frames, {"kinect_optical"})

    def test_a_robot_of_the_world_file_has_its_sensors(self):
        scan = self.record("/post/scan", LaserScan, 2)[-1]
        self.assertAlmostEqual(scan.ranges[0], 1.8, delta=0.01)
        self.assertEqual(scan.header.frame_id, "link")
        odometry = self.record("/post/odom", Odometry, 4)
        np.testing.assert_allclose(periods(odometry), 0.05, atol=1e-6)
        self.assertAlmostEqual(odometry[-1].pose.pose.position.y, -3.0, delta=0.01)
