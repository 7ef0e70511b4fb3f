"""The backing action stops the truck on faults: time-outs, standstill, NaN, reset, jackknife."""

import math
import unittest

import actionlib
import rospy
from actionlib_msgs.msg import GoalStatus, GoalStatusArray
from fake_rig import FakeRig
from sim_client import START_LIMIT, Recorder, wait_until

from cybertruck.msg import BackUpAction, BackUpGoal

LAUNCH = """<launch>
  <param name="/use_sim_time" value="true"/>
  <include file="$(find cybertruck)/launch/back_up.launch"/>
</launch>
"""


class BackFaults(unittest.TestCase):
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

    def test_arrives_when_nothing_is_wrong(self):
        self.begin(0.3)
        self.assertEqual(self.ended(GoalStatus.SUCCEEDED), "arrived")
        result = self.client.get_result()
        self.assertTrue(result.success)
        self.assertLess(result.end_distance, 0.05)
        self.assertLess(abs(result.end_heading_error), math.radians(1.0))

    def test_silent_odometry_stops_the_truck(self):
        self.begin()
        silent, self.rig.odometry_on = self.rig.time, False
        try:
            self.assertIn("no odometry", self.ended(GoalStatus.ABORTED))
            stops = [stamp for stamp, _, speed in self.rig.commands if speed == 0.0]
            self.assertLess(min(stops) - silent, 1.5)  # state_timeout is 0.5 s
        finally:
            self.rig.odometry_on = True

    def test_silent_joint_states_stop_the_truck(self):
        self.begin()
        self.rig.joints_on = False
        try:
            self.assertIn("hitch_yaw_joint", self.ended(GoalStatus.ABORTED))
        finally:
            self.rig.joints_on = True

    def test_goal_without_joint_states_is_rejected(self):
        self.rig.place(0.0)
        self.rig.joints_on = False
        try:
            self.wait_node(1.0)
            self.client.send_goal(BackUpGoal(shape="line"))
            self.assertIn("hitch_yaw_joint", self.ended(GoalStatus.REJECTED))
        finally:
            self.rig.joints_on = True

    def test_nan_stops_the_truck(self):
        self.begin()
        self.rig.hitch_offset = math.nan
        try:
            self.assertIn("finite", self.ended(GoalStatus.ABORTED))
        finally:
            self.rig.hitch_offset = 0.0

    def test_a_truck_that_does_not_move_ends_the_goal(self):
        self.rig.brakes_on = True
        try:
            self.begin()
            self.assertIn("not moved", self.ended(GoalStatus.ABORTED))
        finally:
            self.rig.brakes_on = False

    def test_time_that_goes_back_ends_the_goal(self):
        self.begin()
        wait_until(lambda: self.rig.state[0] < -0.3, "some way")
        with self.rig.lock:
            self.rig.time -= 8.0
        self.assertIn("reset", self.ended(GoalStatus.ABORTED))

    def test_beyond_the_guard_it_pulls_forward_first(self):
        self.begin(math.radians(78.0))
        self.assertEqual(self.ended(GoalStatus.SUCCEEDED), "arrived")
        moving = [speed for _, _, speed in self.rig.commands if speed != 0.0]
        self.assertGreater(moving[0], 0.0)
        self.assertLess(moving[-1], 0.0)
        self.assertLess(max(map(abs, moving)), 0.7)

    def test_a_hitch_that_stays_folded_ends_the_goal(self):
        self.rig.hitch_offset = math.radians(78.0)
        try:
            self.begin()
            self.assertIn("could not be unfolded", self.ended(GoalStatus.ABORTED))
        finally:
            self.rig.hitch_offset = 0.0

    def test_held_curvature_bends_the_way_that_is_asked_for(self):
        self.begin(-0.4, BackUpGoal(shape="hold", size=[0.5, 4.0]))
        self.assertEqual(self.ended(GoalStatus.SUCCEEDED), "arrived")
        # left as driven: backing along -x from the origin, the left is -y
        self.assertLess(self.rig.state[1], -0.5)
        self.assertAlmostEqual(
            self.rig.state[3],
            math.atan(0.7 * 0.5) + math.atan(0.3 * 0.5 / math.sqrt(1.0 + 0.25 * (0.49 - 0.09))),
            delta=0.05,
        )

    def test_bad_goals_are_rejected_with_a_reason(self):
        self.rig.place(0.0)
        self.wait_node(0.3)
        for goal, word in (
            (BackUpGoal(), "neither"),
            (BackUpGoal(shape="loop"), "loop"),
            (BackUpGoal(shape="line", size=[-1.0]), "-1"),
            (BackUpGoal(shape="line", speed=0.9), "0.9"),
            (BackUpGoal(shape="arc", size=[0.4]), "0.40 m"),
        ):
            self.client.send_goal(goal)
            self.assertIn(word, self.ended(GoalStatus.REJECTED))
            self.assertFalse(self.client.get_result().success)
        self.assertEqual([item for item in self.rig.commands if item[2] != 0.0], [])
