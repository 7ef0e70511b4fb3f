"""The backing action beside a truck of kinematics: how a goal begins and ends."""

import unittest

import actionlib
import rospy
from actionlib_msgs.msg import GoalStatusArray
from fake_rig import FakeRig
from sim_client import START_LIMIT, Recorder, wait_until

from cybertruck.msg import BackUpAction, BackUpGoal

LAUNCH = """<launch>
  <param name="/use_sim_time" value="true"/>
  <include file="$(find cybertruck)/launch/back_up.launch"/>
</launch>
"""


class Rig(unittest.TestCase):
    """Every test begins at the origin; the rig backs along a line."""

    @classmethod
    def setUpClass(cls):
        cls.rig = FakeRig()
        cls.client = actionlib.SimpleActionClient("back_up", BackUpAction)
        cls.status = Recorder("back_up/status", GoalStatusArray)
        cls.rig.wait()
        wait_until(rospy.get_time, "/clock", START_LIMIT)
        wait_until(
            lambda: cls.client.wait_for_server(rospy.Duration(0.5)), "the action", START_LIMIT
        )

    @classmethod
    def tearDownClass(cls):
        cls.rig.close()

    def begin(self, hitch_angle=0.0, goal=None):
        """Resets, sends a goal and waits until the truck is commanded to move."""
        self.rig.place(hitch_angle)
        self.wait_node(0.3)  # states of the fresh start
        self.client.send_goal(goal or BackUpGoal(shape="line", size=[4.0]))
        wait_until(
            lambda: any(speed for *_, speed in self.rig.commands) or self.client.get_result(),
            "a command or the end",
        )

    def wait_node(self, seconds):
        """Lets time pass by the node's clock, which may lag behind the rig's."""
        end = rospy.Time.from_sec(self.rig.time + seconds)
        wait_until(
            lambda: self.status.last and self.status.last.header.stamp > end,
            f"{seconds:g} s of the node's clock",
        )

    def ended(self, status):
        """Waits for the end, checks status and that the truck was stopped; returns the text."""
        wait_until(self.client.get_result, "the result")
        self.assertEqual(self.client.get_state(), status, self.client.get_result().message)
        wait_until(lambda: self.rig.command[1] == 0.0, "speed 0")
        return self.client.get_result().message
