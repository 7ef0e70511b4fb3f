"""The referee against the ground truth, the reference driver's accuracy, off the track and back."""

import math
import os
import signal
import subprocess
import threading
import time
import unittest

import rosgraph
import rospy
from gazebo_msgs.msg import ModelState
from gazebo_msgs.srv import SetModelState
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from sim_client import (
    WALL_LIMIT,
    Recorder,
    sleep_sim,
    wait_connected,
    wait_for_car,
    wait_until,
    world_time,
    yaw_of,
)
from std_srvs.srv import Trigger
from testing import call, executable

from track_model.msg import LapStatus

LAUNCH = """<launch>
  <include file="$(find track_model)/launch/world.launch">
    <arg name="track" value="easy"/>
    <arg name="headless" value="true"/>
    <arg name="state_publisher" value="false"/>
    <arg name="lidar" value="false"/>
    <arg name="lockstep" value="true"/>
  </include>
  <include file="$(find deepracer_control)/launch/control.launch">
    <arg name="mode" value="ackermann"/>
    <arg name="command_timeout" value="0.5"/>
  </include>
  <include file="$(find track_model)/launch/referee.launch">
    <arg name="track" value="easy"/>
  </include>
  <include file="$(find paddock_tests)/ros/pacer.launch">
    <arg name="topics" value="[/cmd_vel, /racecar/left_rear_wheel_velocity_controller/command]"/>
    <arg name="lag" value="0.032"/>
  </include>
</launch>
"""

STEP = 0.001  # physics step [s]
LAP_LIMIT = 300.0  # wall time for a lap of 17 s of simulated time [s]


def crossings(messages):
    """Times [s] at which the reference point crosses the start line x = 0 forwards."""
    times = []
    for first, second in zip(messages[:-1], messages[1:]):
        a, b = first.pose.pose.position, second.pose.pose.position
        if a.x < 0.0 <= b.x and abs(b.y) < 0.5 and b.x - a.x < 0.2:
            begin, end = (item.header.stamp.to_sec() for item in (first, second))
            times.append(begin + (end - begin) * a.x / (a.x - b.x))
    return times


class Lap(unittest.TestCase):
    """Each test puts the car to its start."""

    @classmethod
    def setUpClass(cls):
        wait_for_car()
        cls.status = Recorder("/referee/status", LapStatus)
        cls.odometry = Recorder("/racecar/odom", Odometry)
        cls.status.wait_count(1)
        cls.move = rospy.ServiceProxy("/gazebo/set_model_state", SetModelState)
        cls.move.wait_for_service(LAP_LIMIT)

    def put(self, x, y, yaw):
        state = ModelState(model_name="racecar", reference_frame="world")
        state.pose.position.x, state.pose.position.y = x, y
        state.pose.orientation.z, state.pose.orientation.w = math.sin(yaw / 2), math.cos(yaw / 2)
        self.assertTrue(self.move(state).success)

    def place(self, x, y, yaw):
        self.put(x, y, yaw)
        wait_until(
            lambda: math.dist((x, y), (self.status.next() and self.here()[:2])) < 0.05,
            "the car at its new place",
        )
        rospy.ServiceProxy("/referee/restart", Trigger)()

    def here(self):
        pose = self.odometry.newest.pose.pose
        return pose.position.x, pose.position.y, yaw_of(pose.orientation)

    def test_lap_time_is_that_of_the_odometry(self):
        self.place(-0.3, 0.0, 0.0)
        for recorder in (self.odometry, self.status):
            recorder.clear()
        self.status.next()
        words = "path:=/referee/centreline", "odom:=/racecar/odom", "_max_speed:=1.0"
        driver = subprocess.Popen([executable("deepracer_control", "pure_pursuit"), *words])
        try:
            wait_until(lambda: self.status.last.laps >= 1, "a finished lap", LAP_LIMIT)
        finally:
            driver.terminate()
            driver.wait(LAP_LIMIT)
        status = self.status.last
        times = crossings(self.odometry.messages)
        self.assertEqual(len(times), 2)
        self.assertAlmostEqual(status.last_lap_time, times[1] - times[0], delta=STEP)
        self.assertEqual(status.best_lap_time, status.last_lap_time)
        self.assertEqual(status.penalty, 0.0)
        errors = [
            abs(item.lateral_error)
            for item in self.status.messages
            if item.running and not item.laps
        ]
        self.assertGreater(len(errors), 500)
        mean = sum(errors) / len(errors)
        print(
            f"lap {status.last_lap_time:.3f} s, lateral error mean {mean:.4f} m, "
            f"max {max(errors):.4f} m"
        )
        self.assertLess(mean, 0.03)
        self.assertLess(max(errors), 0.15)

    def test_off_the_track_and_put_back(self):
        publisher = rospy.Publisher("/cmd_vel", Twist, queue_size=10)
        wait_connected(publisher, "control")
        publisher.publish(Twist())
        self.place(0.5, -0.2, -1.2)
        command = Twist()
        command.linear.x = 0.5

        def off():
            publisher.publish(command)
            return self.status.last.off_track

        wait_until(off, "the car off the track", LAP_LIMIT)
        self.assertTrue(all(self.status.last.wheels_off))
        self.assertEqual(self.status.last.penalty, 5.0)
        publisher.publish(Twist())
        answer = rospy.ServiceProxy("/referee/put_back", Trigger)()
        self.assertTrue(answer.success, answer.message)
        wait_until(lambda: abs(self.status.next().lateral_error) < 0.02, "the car on its line")
        self.assertFalse(any(self.status.last.wheels_off))
        wait_until(lambda: abs(self.status.next().speed) < 0.02, "the car at rest")

    def test_odometry_of_before_a_restart_does_not_count(self):
        restart = rospy.ServiceProxy("/referee/restart", Trigger, persistent=True)
        self.place(0.5, -2.0, 0.0)
        wait_until(lambda: self.status.next().off_track, "the car off the track")
        restart()
        referee = call(call(rosgraph.get_master_uri(), "lookupNode", "/referee"), "getPid")
        os.kill(referee, signal.SIGSTOP)  # as on a busy machine: odometry waits to be read
        try:
            sleep_sim(2.0)
            self.put(-0.3, 0.0, 0.0)
            answer = threading.Thread(target=restart)
            answer.start()
            time.sleep(0.5)  # the request waits, too
        finally:
            os.kill(referee, signal.SIGCONT)
        answer.join(WALL_LIMIT)
        begin = world_time()
        wait_until(
            lambda: self.status.next().header.stamp.to_sec() > begin, "the referee at the start"
        )
        self.assertLess(abs(self.status.last.lateral_error), 0.05)
        self.assertEqual(self.status.last.penalty, 0.0)
