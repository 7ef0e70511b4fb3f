"""enable_ros_network:=false: a world with its clock and without Gazebo's topics and services."""

import unittest

import rospy
from rosgraph_msgs.msg import Clock
from sim_client import START_LIMIT, Recorder

LAUNCH = """<launch>
  <include file="$(find gazebo_ros)/launch/empty_world.launch">
    <arg name="gui" value="false"/>
    <arg name="enable_ros_network" value="false"/>
  </include>
</launch>
"""


class WithoutNetwork(unittest.TestCase):
    """One world."""

    def test_only_the_clock_is_there(self):
        Recorder("/clock", Clock).wait_count(5, START_LIMIT)
        published, subscribed, services = rospy.get_master().getSystemState()[2]
        topics = {name for name, nodes in published + subscribed if "/gazebo" in nodes}
        self.assertEqual(topics, {"/clock", "/rosout"})
        offered = {name for name, nodes in services if "/gazebo" in nodes}
        self.assertEqual(offered, {"/gazebo/get_loggers", "/gazebo/set_logger_level"})
