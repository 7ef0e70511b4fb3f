"""Other people's loops: unpause, sleep, pause, read topics; and one /gazebo/step in their place."""

import time
import unittest

import rospy
from nav_msgs.msg import Odometry
from sensor_msgs.msg import Image, Imu, LaserScan
from sim_client import START_LIMIT, Recorder, wait_until, world_time
from std_srvs.srv import Empty

from bullet_bridge.srv import Step

LAUNCH = """<launch>
  <include file="$(find gazebo_ros)/launch/empty_world.launch">
    <arg name="gui" value="false"/>
  </include>
  <param name="cart_description" textfile="$(find paddock_gym)/examples/cart.urdf"/>
  <node name="spawn_cart" pkg="gazebo_ros" type="spawn_model" output="screen"
        args="-urdf -param cart_description -model cart -z 0.1"/>
</launch>
"""
TOPICS = {  # -> type, period [s]
    "/scan": (LaserScan, 0.05),
    "/odom": (Odometry, 0.02),
    "/imu": (Imu, 0.02),
    "/camera/image_raw": (Image, 0.1),
}
ACTION = 0.1  # [s]
STEP = 0.001  # [s]


class SteppedLoop(unittest.TestCase):
    """A robot with sensors in a world that is not in lockstep."""

    def setUp(self):
        self.recorders = {name: Recorder(name, kind) for name, (kind, _) in TOPICS.items()}
        for name in ("pause_physics", "unpause_physics", "step"):
            rospy.wait_for_service(f"/gazebo/{name}", START_LIMIT)
        self.pause = rospy.ServiceProxy("/gazebo/pause_physics", Empty)
        self.unpause = rospy.ServiceProxy("/gazebo/unpause_physics", Empty)
        self.step = rospy.ServiceProxy("/gazebo/step", Step)
        self.unpause()
        for recorder in self.recorders.values():
            recorder.next(START_LIMIT)
        self.pause()

    def tearDown(self):
        for recorder in self.recorders.values():
            recorder.close()

    def check_all_have_arrived(self, now, slack):
        """The latest message of each topic is at most its period old; no time passes."""
        for name, recorder in self.recorders.items():
            after = now - TOPICS[name][1] - slack

            def there(recorder=recorder, after=after):
                return recorder.last.header.stamp.to_sec() > after

            wait_until(there, f"{name} later than {after:g} s", START_LIMIT)
            self.assertLess(recorder.last.header.stamp.to_sec(), now + 0.5 * STEP)
        self.assertEqual(world_time(), now)

    def test_one_step_has_the_length_that_was_asked_for_and_all_sensors(self):
        for _ in range(10):
            before = world_time()
            answer = self.step(round(ACTION / STEP), [], [])
            self.assertTrue(answer.success, answer.status_message)
            now = world_time()
            self.assertAlmostEqual(now - before, ACTION, 9)
            self.check_all_have_arrived(now, -0.5 * STEP)

    def test_unpause_sleep_pause(self):
        for _ in range(3):
            before = world_time()
            self.unpause()
            wait_until(lambda before=before: world_time() > before + ACTION, "time", START_LIMIT)
            time.sleep(ACTION)
            self.pause()
            now = world_time()
            self.assertGreater(now, before + ACTION)
            self.check_all_have_arrived(now, 0.5)  # images take wall time
        self.assertFalse(self.step(0, [], []).success)
