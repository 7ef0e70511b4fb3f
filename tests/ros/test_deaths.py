"""What the car does when a node of its chain dies: the table of docs/reliability.md."""

import os
import signal
import subprocess
import sys
import unittest
import xmlrpc.client

import rosgraph
import rospy
from geometry_msgs.msg import Twist
from sensor_msgs.msg import JointState
from sim_client import (
    Recorder,
    joint,
    sleep_sim,
    wait_connected,
    wait_for_car,
    wait_until,
    world_time,
)
from testing import wait_ended

LAUNCH = """<launch>
  <include file="$(find track_model)/launch/world.launch">
    <arg name="headless" value="true"/>
    <arg name="state_publisher" value="false"/>
    <arg name="lidar" value="false"/>
  </include>
  <include file="$(find deepracer_control)/launch/control.launch">
    <arg name="command_timeout" value="0.5"/>
  </include>
  <include file="$(find paddock_tests)/ros/pacer.launch">
    <arg name="topics" value="[/cmd_vel]"/>
    <arg name="nodes" value="[/control]"/>
    <arg name="lag" value="0.2"/>
    <arg name="patience" value="1.5"/>
  </include>
</launch>
"""

SPEED = 10.0  # [rad/s] of the wheels
TIMEOUT = 0.5  # command_timeout [s]
LATE = 0.3  # [s] of simulated time: the watchdog's period and the braking
# What stands for the window: it repeats its command at 10 Hz of ROS time, as the window does.
WINDOW = """
import rospy
from geometry_msgs.msg import Twist
rospy.init_node("window", disable_signals=True)
out = rospy.Publisher("/cmd_vel", Twist, queue_size=10)
message = Twist()
message.linear.x = {speed}
while True:
    out.publish(message)
    rospy.sleep(0.1)
"""


def pid_of(node):
    """Process id of a node."""
    uri = rosgraph.Master(rospy.get_name()).lookupNode(node)
    return xmlrpc.client.ServerProxy(uri).getPid(rospy.get_name())[2]


def rosnode_answers(node):
    """Whether a node is registered and there."""
    try:
        return bool(pid_of(node))
    except (rosgraph.MasterException, OSError):
        return False


class Deaths(unittest.TestCase):
    """The car drives, then something dies."""

    @classmethod
    def setUpClass(cls):
        wait_for_car()
        cls.joints = Recorder("/racecar/joint_states", JointState)

    def setUp(self):
        if not rosnode_answers("/control"):
            self.start("rosrun", "deepracer_control", "control")
            wait_until(lambda: rosnode_answers("/control"), "another control")
        self.publisher = rospy.Publisher("/cmd_vel", Twist, queue_size=1)
        wait_connected(self.publisher, "control")
        self.send(0.0, lambda: abs(self.speed()) < 0.05, "the wheels at rest")

    def send(self, speed, condition, what):
        """Sends a speed of the wheels until a condition holds."""
        message = Twist()
        message.linear.x = speed
        wait_until(lambda: self.publisher.publish(message) or condition(), what)

    def start(self, *command):
        """Starts a process that is killed after the class."""
        process = subprocess.Popen(command)
        self.addClassCleanup(process.wait)
        self.addClassCleanup(process.kill)
        return process

    def drive(self):
        """A window holds its command; waits until the wheels turn."""
        window = self.start(sys.executable, "-c", WINDOW.format(speed=SPEED))
        wait_until(lambda: abs(self.speed() - SPEED) < 0.5, "the wheels turning")
        return window

    def speed(self):
        """Speed of a rear wheel [rad/s]."""
        return joint(self.joints.next(), "left_rear_wheel_joint")[1]

    def wait_rest(self):
        wait_until(lambda: abs(self.speed()) < 0.05, "the wheels at rest")

    def test_a_killed_window_stops_the_car_within_the_timeout(self):
        window = self.drive()
        self.joints.clear()
        window.kill()
        window.wait()
        died = world_time()
        self.wait_rest()
        moving = [
            message.header.stamp.to_sec()
            for message in self.joints.messages
            if abs(joint(message, "left_rear_wheel_joint")[1]) > 0.05
        ]
        self.assertLess(max(moving) - died, TIMEOUT + LATE)

    def test_a_control_that_ends_stops_the_car_one_that_is_killed_leaves_the_last_command(self):
        """As with Gazebo and ros_control: a controller holds; drive.launch ends with control."""
        window = self.drive()
        control = pid_of("/control")
        os.kill(control, signal.SIGTERM)
        wait_ended(control, 30.0)
        self.wait_rest()
        sleep_sim(0.5)  # nothing follows the zero
        self.assertLess(abs(self.speed()), 0.05)
        window.kill()
        self.setUp()  # another control
        self.send(SPEED, lambda: self.speed() > 0.9 * SPEED, "the wheels turning")
        control = pid_of("/control")
        os.kill(control, signal.SIGKILL)
        wait_ended(control, 30.0)
        sleep_sim(2.0)
        self.assertGreater(self.speed(), 0.9 * SPEED)
