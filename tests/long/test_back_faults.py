"""The backing action stops the truck on faults: standstill, NaN, reset, jackknife."""

import math

from actionlib_msgs.msg import GoalStatus
from back_rig import LAUNCH, Rig  # noqa: F401
from sim_client import wait_until

from cybertruck.msg import BackUpGoal


class BackFaults(Rig):
    """Every test begins at the origin; the rig backs along a line."""

    def test_arrives_when_nothing_is_wrong(self):
        self.begin(0.3)
        self.assertEqual(self.ended(GoalStatus.SUCCEEDED), "arrived")
        result = self.client.get_result()
        self.assertTrue(result.success)
        self.assertLess(result.end_distance, 0.05)
        self.assertLess(abs(result.end_heading_error), math.radians(1.0))

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
