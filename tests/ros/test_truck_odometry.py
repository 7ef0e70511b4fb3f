"""Odometry of the wheels stays near the truth over 20 m of arcs."""

import math
import random
import unittest

from nav_msgs.msg import Odometry
from sim_client import Recorder, turned, wait_until
from truck_client import TRUTH, Driver, Stepper, pose_of, way

LAUNCH = """<launch>
  <include file="$(find cybertruck)/launch/truck.launch">
    <arg name="world" value="$(find cybertruck)/worlds/plane.world"/>
    <arg name="headless" value="true"/>
    <arg name="lidar" value="false"/>
    <arg name="lockstep" value="true"/>
  </include>
  <param name="/robot_state_publisher/publish_frequency" value="5.0"/>
  <param name="/gazebo/pub_clock_frequency" value="20.0"/>
</launch>
"""

DISTANCE = 20.0  # [m]
SPEED = 1.0  # [m/s]
WHEELBASE = 0.508  # [m]


class TruckOdometry(unittest.TestCase):
    """Drives left and right in turn."""

    def test_over_arcs(self):
        odometry, truth = Recorder("/odom", Odometry), Recorder(TRUTH, Odometry)
        stepper, driver = Stepper(), Driver()
        dice, side, driven = random.Random(3), 1, 0.0
        while driven < DISTANCE:
            radius, side = dice.uniform(1.0, 5.0), -side
            steering = side * math.atan(WHEELBASE / radius)
            for _ in range(round(radius * dice.uniform(0.5, 2.0) / SPEED / 0.16)):
                driver.give(steering, SPEED)
                stepper.advance(20)
            driven, total_turn = way(truth.messages[::5])
        truths = {m.header.stamp: m for m in truth.messages}
        last = wait_until(
            lambda: next(
                (m for m in reversed(odometry.messages) if m.header.stamp in truths), None
            ),
            "a common stamp",
        )
        published, true = pose_of(last), pose_of(truths[last.header.stamp])
        error, heading = math.dist(published[:2], true[:2]), abs(turned(published[2], true[2]))
        print(
            f"{driven:.1f} m, {total_turn:.1f} rad: {error:.3f} m, {math.degrees(heading):.3f} deg"
        )
        self.assertGreater(total_turn, 5.0)
        self.assertLess(error, 0.02 * driven)
        self.assertLess(heading, 0.03 * total_turn)
        self.assertGreater(error, 0.0)  # it is not the truth that is published
