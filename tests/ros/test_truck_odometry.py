"""The truck step by step: how long a command lasts, and resets.

Odometry over arcs: tests/unit/test_truck_dead_reckoning.py.
"""

import math
import unittest

import rospy
from geometry_msgs.msg import Twist
from launches import wait_subscribed
from nav_msgs.msg import Odometry
from sim_client import Recorder, wait_connected, wait_until, world_time
from truck_client import TRUTH, Driver, Stepper, pose_of, way

LAUNCH = """<launch>
  <include file="$(find cybertruck)/launch/truck.launch">
    <arg name="world" value="$(find cybertruck)/worlds/plane.world"/>
    <arg name="headless" value="true"/>
    <arg name="x" value="1.0"/>
    <arg name="y" value="-0.5"/>
    <arg name="yaw" value="0.5"/>
    <arg name="lidar" value="false"/>
    <arg name="lockstep" value="true"/>
  </include>
  <param name="/robot_state_publisher/publish_frequency" value="5.0"/>
  <param name="/gazebo/pub_clock_frequency" value="20.0"/>
</launch>
"""

SPEED = 1.0  # [m/s]
START = (1.0, -0.5, 0.5)  # x, y [m], yaw [rad] of LAUNCH
PULLS_AWAY = 0.05  # [m/s]
STANDS = 0.01  # [m/s]


class TruckOdometry(unittest.TestCase):
    """One truck in a world that waits for its drive node."""

    @classmethod
    def setUpClass(cls):
        cls.stepper, cls.driver = Stepper(), Driver()

    def advance_until(self, condition, truth):
        """Makes periods until a condition of the truck's true speed [m/s] holds."""
        for _ in range(500):
            count = len(truth.messages)
            self.stepper.advance()
            truth.wait_count(count + 1)
            if condition(abs(truth.last.twist.twist.linear.x)):
                return
        raise AssertionError(f"not within 4 s of simulated time:\n{truth.last}")

    def test_a_command_lasts_half_a_second(self):
        truth, twist = Recorder(TRUTH, Odometry), rospy.Publisher("/cmd_vel", Twist, queue_size=1)
        wait_connected(twist, "drive node")
        wait_subscribed([TRUTH])
        message = Twist()
        message.linear.x = 1.0
        twist.publish(message)
        self.advance_until(lambda speed: speed > PULLS_AWAY, truth)
        begin = truth.last.header.stamp
        self.advance_until(lambda speed: speed < STANDS, truth)
        first, last = truth.messages[0], truth.last
        driven, seconds = way([first, last])[0], (last.header.stamp - begin).to_sec()
        print(f"{driven:.3f} m, {seconds:.3f} s")
        # 0.5 s at 2 m/s^2 to 1 m/s, and the same way back; /clock, by which commands age, comes
        # every 0.05 s
        self.assertAlmostEqual(seconds, 1.0, delta=0.1)
        self.assertAlmostEqual(driven, 0.5, delta=0.1)
        truth.close()

    def drive_and_reset(self, steering, service):
        """Drives, resets and makes 0.48 s; returns odometry and truth of before and of now."""
        recorders = [Recorder("/odom", Odometry), Recorder(TRUTH, Odometry)]
        wait_subscribed(["/odom"], publisher="/drive")
        wait_subscribed([TRUTH])
        for _ in range(8):
            self.driver.give(steering, SPEED)
            self.stepper.advance(20)
        before = [recorder.newest for recorder in recorders]
        self.assertGreater(math.dist(pose_of(before[1])[:2], START[:2]), 0.7)
        self.stepper.reset(service)
        self.stepper.advance(59)
        end = world_time()
        for recorder in recorders:
            wait_until(
                lambda each=recorder: abs(each.last.header.stamp.to_sec() - end) < 0.0085,
                f"{recorder.topic} at {end:g} s",
            )
            recorder.close()
        return before, [recorder.last for recorder in recorders]

    def test_reset_simulation_starts_afresh(self):
        before, after = self.drive_and_reset(0.4, "/gazebo/reset_simulation")
        self.assertLess(after[0].header.stamp.to_sec(), 0.5)
        self.assertGreater(before[0].header.stamp.to_sec(), 1.0)
        for message in after:
            for value, wanted in zip(pose_of(message), START):
                self.assertAlmostEqual(value, wanted, delta=0.01)

    def test_reset_world_puts_the_truck_back_and_its_odometry_goes_on(self):
        """As in Gazebo: the wheels stay where they are, so odometry of wheels notices nothing."""
        before, after = self.drive_and_reset(0.0, "/gazebo/reset_world")
        self.assertGreater(after[0].header.stamp, before[0].header.stamp)
        driven = math.dist(pose_of(after[0])[:2], pose_of(before[0])[:2])
        self.assertLess(driven, SPEED * 0.6, "no jump, it may roll on")
        self.assertLess(math.dist(pose_of(after[1])[:2], START[:2]), driven + 0.05)
        self.assertGreater(math.dist(pose_of(before[1])[:2], START[:2]), 0.7)
