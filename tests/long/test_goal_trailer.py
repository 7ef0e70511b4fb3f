"""The truck with its trailer drives to two goals, the start along y."""

import goal_rig

LAUNCH = """<launch>
  <include file="$(find paddock_tests)/ros/goal_world.launch">
    <arg name="original" value="true"/>
    <arg name="trailer" value="true"/>
    <arg name="yaw" value="1.5707963"/>
  </include>
</launch>
"""


class TwoGoals(goal_rig.TwoGoals):
    """Of goal_rig."""
