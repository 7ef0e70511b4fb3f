"""The backing action stops the truck on faults: standstill, NaN, reset, jackknife."""

import math

from actionlib_msgs.msg import GoalStatus
from back_rig import LAUNCH, Rig  # noqa: F401
from sim_client import wait_until

from cybertruck.msg import BackUpGoal


class BackFaults(Rig):
    """Every test begins at the origin; the rig backs along a line."""

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
