"""The backing action arrives, stops on a fault and refuses; tests/long/ has all the others."""

from actionlib_msgs.msg import GoalStatus
from back_rig import LAUNCH, Rig  # noqa: F401

from cybertruck.msg import BackUpGoal


class BackFaults(Rig):
    """One of each kind of end."""

    def test_silent_odometry_stops_the_truck(self):
        self.begin()
        silent, self.rig.odometry_on = self.rig.time, False
        try:
            self.assertIn("no odometry", self.ended(GoalStatus.ABORTED))
            stops = [stamp for stamp, _, speed in self.rig.commands if speed == 0.0]
            self.assertLess(min(stops) - silent, 1.5)  # state_timeout is 0.5 s
        finally:
            self.rig.odometry_on = True

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
