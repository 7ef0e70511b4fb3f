"""Robots driven by a joystick, by keys and by a marker in rviz.

Time is simulated and stands still unless a test sets it.
"""

import math
import unittest

import rosnode
from geometry_msgs.msg import Twist
from rosgraph_msgs.msg import Log
from sensor_msgs.msg import Joy
from sim_client import START_LIMIT, Recorder, wait_until
from standins_rig import SetClock, publisher, send_until_answered
from terminal_rig import Terminal
from visualization_msgs.msg import InteractiveMarkerFeedback, InteractiveMarkerInit

LAUNCH = """<launch>
  <param name="/use_sim_time" value="true"/>

  <group ns="pad">
    <!-- joy_node of this launch file waits for its pad all the time. -->
    <include file="$(find teleop_twist_joy)/launch/teleop.launch">
      <arg name="joy_config" value="ps3-holonomic"/>
      <arg name="joy_dev" value="/dev/input/pad_that_is_not_there"/>
    </include>
  </group>

  <include file="$(find interactive_marker_twist_server)/launch/interactive_markers.launch">
    <arg name="config" value="planar"/>
  </include>

</launch>
"""


class Teleops(unittest.TestCase):
    """One test for each package."""

    @classmethod
    def setUpClass(cls):
        cls.clock = SetClock()

    def test_teleop_twist_joy_and_a_pad_that_is_not_there(self):
        log, commands = Recorder("/rosout_agg", Log), Recorder("/pad/cmd_vel", Twist)
        for recorder in (log, commands):
            self.addCleanup(recorder.close)
        pad = publisher("/pad/joy", Joy)
        held = [int(number == 10) for number in range(12)]
        send_until_answered(pad, Joy(axes=[0.5, 1.0, -1.0], buttons=held), commands)
        for _ in range(3):
            pad.publish(Joy(axes=[0.5, 1.0, -1.0], buttons=[0] * 12))
        wait_until(lambda: commands.last == Twist(), "the zero")
        pad.publish(Joy(axes=[0.0, -1.0, 0.0], buttons=held))
        wait_until(lambda: commands.newest.linear.x == -0.4, "the last command")
        *first, zero, last = commands.messages
        for command in first:
            speeds = (command.linear.x, command.linear.y, command.angular.z)
            self.assertEqual(speeds, (0.4, 0.2, -0.5))
        self.assertEqual((zero, last.linear.x), (Twist(), -0.4))  # zero once
        wait_until(lambda: rosnode.rosnode_ping("/pad/joy_node", max_count=1), "joy_node")
        words = "waiting for the joystick /dev/input/pad_that_is_not_there"
        said = [m for m in log.messages if words in m.msg]
        self.assertLessEqual(len(said), 1)

    def test_interactive_marker_twist_server(self):
        commands = Recorder("/twist_marker_server/cmd_vel", Twist)
        markers = Recorder("/twist_marker_server/update_full", InteractiveMarkerInit)
        for recorder in (commands, markers):
            self.addCleanup(recorder.close)
        # the server's first message may come before its marker
        marker = wait_until(lambda: markers.last and markers.last.markers, "a marker")[0]
        self.assertEqual(marker.header.frame_id, "base_link")
        self.assertEqual([c.name for c in marker.controls], ["move_x", "move_y", "rotate_z"])
        mouse = publisher("/twist_marker_server/feedback", InteractiveMarkerFeedback)
        drag = InteractiveMarkerFeedback(client_id="rviz", marker_name=marker.name)
        drag.event_type = InteractiveMarkerFeedback.POSE_UPDATE
        drag.pose.position.x, drag.pose.position.y = 0.25, -3.0
        drag.pose.orientation.z, drag.pose.orientation.w = math.sin(0.1), math.cos(0.1)
        send_until_answered(mouse, drag, commands)
        command = commands.messages[0]
        self.assertEqual((command.linear.x, command.linear.y), (0.25, -1.0))
        self.assertAlmostEqual(command.angular.z, 2.2 * 0.2)

    def test_teleop_twist_keyboard(self):
        commands = Recorder("/keys/cmd_vel", Twist)
        self.addCleanup(commands.close)
        terminal = Terminal()
        self.addCleanup(terminal.close)
        terminal.type(
            "rosrun teleop_twist_keyboard teleop_twist_keyboard.py __ns:=keys _key_timeout:=0"
        )
        wait_until(lambda: "speed 0.5 m/s" in terminal.screen(), "the keys", 2.0 * START_LIMIT)
        for keys, expected in (("i", (0.5, 0.0)), ("wu", (0.55, 1.0)), ("k", (0.0, 0.0))):
            terminal.keys(*keys)
            wait_until(
                lambda e=expected: (
                    commands.last
                    and (round(commands.last.linear.x, 6), commands.last.angular.z) == e
                ),
                f"{expected} for {keys}",
            )
        terminal.keys("i")
        wait_until(lambda: commands.newest.linear.x == 0.55, "the last command")
        terminal.keys("C-c")
        wait_until(lambda: commands.newest.linear.x == 0.0, "the zero at the end")
        self.assertEqual(terminal.run("stty -a"), terminal.settings)
