"""Truck and trailer at rest, under the drive node's commands, stay where they are."""

import math
import unittest

from nav_msgs.msg import Odometry
from sensor_msgs.msg import JointState
from sim_client import Recorder, joint
from truck_client import TRUTH, pose_of, wait_for_truck

LAUNCH = """<launch>
  <include file="$(find cybertruck)/launch/truck.launch">
    <arg name="world" value="$(find cybertruck)/worlds/plane.world"/>
    <arg name="headless" value="true"/>
    <arg name="lidar" value="false"/>
    <arg name="real_time_factor" value="0"/>
  </include>
  <param name="/robot_state_publisher/publish_frequency" value="5.0"/>
  <param name="/gazebo/pub_clock_frequency" value="20.0"/>
</launch>
"""

DURATION = 20.0  # simulated time [s]
CREEP = 0.001  # [m] a minute


class TruckRest(unittest.TestCase):
    """Watches the train for 20 s of simulated time."""

    def test_at_rest(self):
        wait_for_truck()
        joints, truth = Recorder("/joint_states", JointState), Recorder(TRUTH, Odometry)
        before, after = truth.over(DURATION)
        self.assertLess(math.dist(pose_of(before)[:2], pose_of(after)[:2]), CREEP * DURATION / 60.0)
        for name in ("front_left_steer_joint", "front_right_steer_joint", "hitch_yaw_joint"):
            rates = [joint(message, name)[1] for message in joints.messages]
            self.assertLess(math.sqrt(sum(r * r for r in rates) / len(rates)), 0.01, name)
        joints.close()
