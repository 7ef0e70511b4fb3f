"""The truck without its trailer drives to two goals, the start along x."""

import goal_rig

LAUNCH = """<launch>
  <include file="$(find paddock_tests)/ros/goal_world.launch">
    <arg name="original" value="true"/>
    <arg name="trailer" value="false"/>
    <arg name="yaw" value="0.0"/>
  </include>
</launch>
"""


class TwoGoals(goal_rig.TwoGoals):
    """Of goal_rig; src/cybertruck/test/test_goal.py has all four starts."""
