#!/usr/bin/env python3
"""The stand-ins' nodes at work: what is sent to them, and what comes of it.

Time is simulated and stands still unless a test sets it.
"""

import contextlib
import math
import subprocess
import tempfile
import threading
import time
import unittest
from pathlib import Path

import rosnode
import rospy
import rostest
from actionlib import SimpleActionClient
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import Twist
from nav_msgs.msg import MapMetaData, OccupancyGrid
from nav_msgs.srv import GetMap, LoadMap
from rosgraph_msgs.msg import Clock, Log
from sensor_msgs.msg import Joy
from sim_client import START_LIMIT, WALL_LIMIT, Recorder, wait_connected, wait_until
from std_msgs.msg import Bool
from terminal_rig import Terminal
from twist_mux_msgs.msg import JoyPriorityAction, JoyPriorityGoal
from visualization_msgs.msg import InteractiveMarkerFeedback, InteractiveMarkerInit, Marker

CELLS = [0, 0, 100, 100, -1, 0]  # of models/small_map.yaml, lowest row first


class SetClock:
    """Publishes /clock again and again, as far as a test has set it."""

    def __init__(self):
        self.time = 10.0
        self._publisher = rospy.Publisher("/clock", Clock, queue_size=10)
        threading.Thread(target=self._repeat, daemon=True).start()

    def _repeat(self):
        while not rospy.is_shutdown():
            with contextlib.suppress(rospy.ROSException):  # closed at the end of the test
                self._publisher.publish(Clock(rospy.Time.from_sec(self.time)))
            time.sleep(0.02)


def publisher(topic, kind):
    """A publisher that somebody hears."""
    made = rospy.Publisher(topic, kind, queue_size=10)
    wait_connected(made, topic)
    return made


def twist(forward):
    """A command to drive ahead [m/s]."""
    message = Twist()
    message.linear.x = forward
    return message


class Nodes(unittest.TestCase):
    """One test for each stand-in."""

    @classmethod
    def setUpClass(cls):
        cls.clock = SetClock()
        wait_until(lambda: rospy.get_time() > 0.0, "the clock", START_LIMIT)

    def state_of(self, diagnostics, *words):
        """Whether the mux' last report holds all (key, start of the value)."""
        reports = [s for m in diagnostics.messages for s in m.status if "Twist mux" in s.name]
        values = {item.key: item.value for item in reports[-1].values} if reports else {}
        return all(values.get(key, "").startswith(value) for key, value in words)

    def wait_state(self, diagnostics, *words):
        wait_until(lambda: self.state_of(diagnostics, *words), f"the mux to report {words}")

    def test_twist_mux(self):
        diagnostics, out = Recorder("/diagnostics", DiagnosticArray), Recorder("/mux/out", Twist)
        markers = Recorder("/mux/marker", Marker)
        for recorder in (diagnostics, out, markers):
            self.addCleanup(recorder.close)
        low, high = publisher("/mux/low_vel", Twist), publisher("/mux/high_vel", Twist)
        pause = publisher("/mux/pause", Bool)
        masked, unmasked = ("velocity low", "masked"), ("velocity low", "unmasked")
        self.wait_state(diagnostics, masked, ("lock pause", "free"))

        high.publish(twist(0.9))
        out.wait_count(1)
        low.publish(twist(0.2))
        self.wait_state(diagnostics, unmasked, ("velocity high", "unmasked"))  # it was heard
        self.assertEqual([m.linear.x for m in out.messages], [0.9])

        self.clock.time += 1.0  # both fall silent
        self.wait_state(diagnostics, masked, ("velocity high", "masked"))
        low.publish(twist(0.3))
        self.assertEqual(out.wait_count(2)[-1].linear.x, 0.3)
        self.wait_state(diagnostics, unmasked, ("velocity high", "masked"))

        pause.publish(True)
        self.wait_state(diagnostics, masked, ("lock pause", "locked"), ("current priority", "50"))
        high.publish(twist(0.8))
        self.assertEqual(out.wait_count(3)[-1].linear.x, 0.8)
        pause.publish(False)
        self.wait_state(diagnostics, unmasked, ("lock pause", "free"))
        wait_until(lambda: markers.last and markers.last.points[1].x == 0.8, "the arrow")

    def test_joystick_relay(self):
        out, drives = Recorder("/mux/joy_vel_out", Twist), Recorder("/mux/joy_priority", Bool)
        for recorder in (out, drives):
            self.addCleanup(recorder.close)
        stick = publisher("/mux/joy_vel_in", Twist)
        stick.publish(twist(1.0))
        # Second of four steps from 0.5 to 1 m/s.
        self.assertAlmostEqual(out.wait_count(1)[-1].linear.x, 0.5 + 0.5 / 3)
        self.assertTrue(drives.wait_count(1)[-1].data)
        action = SimpleActionClient("/mux/joy_priority_action", JoyPriorityAction)
        wait_connected(action.action_client.pub_goal, "the relay's action")
        action.send_goal(JoyPriorityGoal())
        self.assertFalse(drives.wait_count(2)[-1].data)

    def test_teleop_twist_joy_and_a_pad_that_is_not_there(self):
        log, commands = Recorder("/rosout_agg", Log), Recorder("/pad/cmd_vel", Twist)
        for recorder in (log, commands):
            self.addCleanup(recorder.close)
        pad = publisher("/pad/joy", Joy)
        held = [int(number == 10) for number in range(12)]
        pad.publish(Joy(axes=[0.5, 1.0, -1.0], buttons=held))
        first = commands.wait_count(1)[0]
        self.assertEqual((first.linear.x, first.linear.y, first.angular.z), (0.4, 0.2, -0.5))
        for _ in range(3):
            pad.publish(Joy(axes=[0.5, 1.0, -1.0], buttons=[0] * 12))
        self.assertEqual(commands.wait_count(2)[1], Twist())
        pad.publish(Joy(axes=[0.0, -1.0, 0.0], buttons=held))
        self.assertEqual([m.linear.x for m in commands.wait_count(3)], [0.4, 0.0, -0.4])
        self.assertTrue(rosnode.rosnode_ping("/pad/joy_node", max_count=1))
        words = "waiting for the joystick /dev/input/pad_that_is_not_there"
        said = [m for m in log.messages if words in m.msg]
        self.assertLessEqual(len(said), 1)

    def test_interactive_marker_twist_server(self):
        commands = Recorder("/twist_marker_server/cmd_vel", Twist)
        markers = Recorder("/twist_marker_server/update_full", InteractiveMarkerInit)
        for recorder in (commands, markers):
            self.addCleanup(recorder.close)
        marker = markers.wait_count(1)[-1].markers[0]
        self.assertEqual(marker.header.frame_id, "base_link")
        self.assertEqual([c.name for c in marker.controls], ["move_x", "move_y", "rotate_z"])
        mouse = publisher("/twist_marker_server/feedback", InteractiveMarkerFeedback)
        drag = InteractiveMarkerFeedback(client_id="rviz", marker_name=marker.name)
        drag.event_type = InteractiveMarkerFeedback.POSE_UPDATE
        drag.pose.position.x, drag.pose.position.y = 0.25, -3.0
        drag.pose.orientation.z, drag.pose.orientation.w = math.sin(0.1), math.cos(0.1)
        mouse.publish(drag)
        command = commands.wait_count(1)[0]
        self.assertEqual((command.linear.x, command.linear.y), (0.25, -1.0))
        self.assertAlmostEqual(command.angular.z, 2.2 * 0.2)

    def test_map_server_and_map_saver(self):
        grids, infos = Recorder("/map", OccupancyGrid), Recorder("/map_metadata", MapMetaData)
        for recorder in (grids, infos):
            self.addCleanup(recorder.close)
        grid = grids.wait_count(1)[0]
        self.assertEqual(list(grid.data), CELLS)
        self.assertEqual((grid.info.width, grid.info.height), (3, 2))
        self.assertEqual(grid.header.frame_id, "world")
        self.assertAlmostEqual(grid.info.resolution, 0.5)
        self.assertAlmostEqual(grid.info.origin.orientation.z, math.sqrt(0.5))
        self.assertEqual(infos.wait_count(1)[0], grid.info)
        rospy.wait_for_service("/static_map", WALL_LIMIT)
        self.assertEqual(rospy.ServiceProxy("/static_map", GetMap)().map, grid)

        with tempfile.TemporaryDirectory() as directory:
            name = str(Path(directory) / "saved")
            subprocess.run(
                ["rosrun", "map_server", "map_saver", "-f", name, "__name:=saver"],
                check=True,
                timeout=START_LIMIT,
            )
            change = rospy.ServiceProxy("/change_map", LoadMap)
            self.assertEqual(change(name + ".yaml").result, 0)
            again = grids.wait_count(2)[-1]
            self.assertEqual(list(again.data), CELLS)
            self.assertAlmostEqual(again.info.origin.orientation.z, math.sqrt(0.5), places=6)
            self.assertEqual(again.info.origin.position, grid.info.origin.position)
            self.assertNotEqual(change("/nowhere.yaml").result, 0)
        self.assertEqual(len(grids.messages), 2)

    def test_teleop_twist_keyboard(self):
        commands = Recorder("/keys/cmd_vel", Twist)
        self.addCleanup(commands.close)
        terminal = Terminal()
        self.addCleanup(terminal.close)
        terminal.type(
            "rosrun teleop_twist_keyboard teleop_twist_keyboard.py __ns:=keys _key_timeout:=0"
        )
        terminal.wait_screen("Ctrl-C ends", "speed 0.5 m/s")
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
        wait_until(lambda: commands.last.linear.x == 0.55, "the last command")
        terminal.keys("C-c")
        wait_until(lambda: commands.last.linear.x == 0.0, "the zero at the end")
        self.assertEqual(terminal.run("stty -a"), terminal.settings)


if __name__ == "__main__":
    rospy.init_node("standins_nodes_test")
    rostest.rosrun("paddock_tests", "standins_nodes", Nodes)
