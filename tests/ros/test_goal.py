"""The truck without its trailer drives to a goal; tests/long/ has two goals and back, and more."""

import goal_rig

LAUNCH = """<launch>
  <include file="$(find paddock_tests)/ros/goal_world.launch">
    <arg name="trailer" value="false"/>
    <arg name="yaw" value="0.0"/>
  </include>
</launch>
"""


class OneGoal(goal_rig.Rig):
    """The start is along x, the goal ahead and to the left."""

    def test_it_arrives_on_a_short_way(self):
        self.check_drive((3.0, 3.0))
