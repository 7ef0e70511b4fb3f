"""A world that Gazebo has saved goes on at the time and the place of its state, until a reset."""

import unittest

import rospy
from nav_msgs.msg import Odometry
from rosgraph_msgs.msg import Clock
from sim_client import START_LIMIT, Recorder, wait_until
from std_srvs.srv import Empty

LAUNCH = """<launch>
  <include file="$(find gazebo_ros)/launch/empty_world.launch">
    <arg name="world_name" value="$(find paddock_tests)/ros/saved.world"/>
    <arg name="gui" value="false"/>
  </include>
</launch>
"""
SAVED = 100.5  # [s]


class SavedWorld(unittest.TestCase):
    def test_it_goes_on_at_its_time_until_a_reset(self):
        clock, truth = Recorder("/clock", Clock), Recorder("/truth", Odometry)
        rospy.wait_for_service("/gazebo/reset_simulation", START_LIMIT)
        self.assertGreaterEqual(clock.newest.clock.to_sec(), SAVED)
        self.assertLess(clock.messages[0].clock.to_sec(), SAVED + START_LIMIT)
        stamps = [message.header.stamp.to_sec() for message in truth.wait_count(5)]
        self.assertGreaterEqual(stamps[0], SAVED)
        for one, two in zip(stamps, stamps[1:]):  # a period is counted from the last message
            self.assertAlmostEqual(two - one, 0.1, delta=0.002)
        place = truth.last.pose.pose.position
        self.assertAlmostEqual(place.x, 3.0, delta=1e-3)
        rospy.ServiceProxy("/gazebo/reset_simulation", Empty)()
        wait_until(lambda: clock.last.clock.to_sec() < SAVED, "a time after the reset")
        truth.clear()
        wait_until(
            lambda: truth.last is not None and abs(truth.last.pose.pose.position.x) < 1e-3,
            "the model where its <pose> is",
        )
