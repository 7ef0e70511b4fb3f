#!/usr/bin/env python3
"""Keys in a terminal and on an X server, checked on /cmd_vel and the screen."""

import os
import signal
import sys
import time
import unittest

import rospy
import rostest
from geometry_msgs.msg import Twist
from paddock_common.testing import is_running
from sim_client import Recorder, wait_until
from terminal_rig import Terminal, XServer, node_pid, parent_of

COMMAND = "rosrun cybertruck keyboard _max_acceleration:=0 _max_steering_rate:=0"
QUIET = 0.4  # wall time without a message that counts as silence: eight periods [s]
STOP = (0.0, 0.0)


def forget_parameters():
    """Removes what an earlier start with _name:=value left on the parameter server."""
    if rospy.has_param("/keyboard"):
        rospy.delete_param("/keyboard")


class Rig(unittest.TestCase):
    """A terminal with the teleop in it, and what it publishes."""

    display = None

    def setUp(self):
        forget_parameters()
        self.commands = Recorder("/cmd_vel", Twist)
        self.addCleanup(self.commands.close)
        self.terminal = Terminal(DISPLAY=self.display, WAYLAND_DISPLAY=None)
        self.addCleanup(self.close)
        self.pid = None
        self.start()

    def start(self):
        self.terminal.type(COMMAND)
        self.terminal.wait_screen("keyboard teleop")
        wait_until(lambda: self.commands.last is not None, "the first command")
        self.pid = node_pid("/keyboard")

    def close(self):
        """Ends the terminal and waits for the teleop's end, so that the next test is alone."""
        self.terminal.close()
        if self.pid:
            wait_until(lambda: not is_running(self.pid), "the end of the teleop")

    def last(self):
        message = self.commands.last
        return message and (round(message.linear.x, 4), round(message.angular.z, 4))

    def wait_command(self, linear, angular):
        wait_until(lambda: self.last() == (linear, angular), f"command {(linear, angular)}")

    def sent(self):
        """All commands since they were last cleared."""
        return {(round(m.linear.x, 4), round(m.angular.z, 4)) for m in self.commands.messages}

    def hold_command(self, linear, angular, count=6):
        """The next messages are all this command: it is published periodically."""
        self.wait_command(linear, angular)
        self.commands.clear()
        self.commands.wait_count(count)
        self.assertEqual(self.sent(), {(linear, angular)})

    def assert_ended(self, *pids):
        """The processes are gone, the last of all messages is the only zero, the shell is sane."""
        for pid in pids:
            wait_until(lambda: not is_running(pid), f"the end of process {pid}")
        self.wait_command(*STOP)
        time.sleep(QUIET)
        messages = self.commands.messages
        zeros = [item for item in messages if item.linear.x == 0.0]
        self.assertEqual(zeros, messages[-1:])
        self.assertEqual(self.terminal.run("stty -a"), self.terminal.settings)
        self.assertEqual(self.terminal.state(), ("0", "1"))
        time.sleep(QUIET)
        self.assertEqual(len(self.commands.messages), len(messages))


class WithoutX(Rig):
    """Keys read from the terminal."""

    def hold_key(self, key, words, command):
        """Has a key repeat, as a held one does, until screen and topic show what it does."""

        def shown():
            self.terminal.keys(key)
            return words in self.terminal.screen() and command in self.sent()

        wait_until(shown, f"{words} on the screen and {command} while {key} is held")

    def test_bindings_and_screen(self):
        terminal = self.terminal
        text = terminal.wait_screen(
            "keyboard teleop",
            "Keys come from this terminal",
            "DISPLAY is not set",
            "C is Caps Lock",
            "no chords",
            "held",
            "+0.000 m/s",
            "standing",
        )
        self.assertIn("| |  /_________\\  | |", text)
        self.hold_command(*STOP)
        for key, command, words in (
            ("Up", (0.5, 0.0), "forward"),
            ("Down", (-0.5, 0.0), "backward"),
        ):
            self.commands.clear()
            self.hold_key(key, words, command)
            self.wait_command(*STOP)  # no repeat came
        for key in ("Left", "Right"):
            terminal.keys(key)
        self.hold_command(*STOP)
        for key, words in (
            ("q", "0.550 m/s"),
            ("z", "0.495 m/s"),
            ("w", "0.550 rad/s"),
            ("x", "0.495 rad/s"),
            ("r", "0.500 m/s"),
            ("Q", "0.550 m/s"),
            ("R", "0.500 rad/s"),
        ):
            terminal.keys(key)
            terminal.wait_screen(words)
        terminal.keys("c")
        terminal.wait_screen("continuous")
        for key, command, words in (
            ("Up", (0.5, 0.0), "forward"),
            ("Left", (0.5, 0.5), "forward, wheels left"),
            ("Right", (0.5, -0.5), "forward, wheels right"),
            ("Down", (-0.5, 0.0), "backward"),
            ("Left", (-0.5, -0.5), "backward, wheels left"),
            ("Right", (-0.5, 0.5), "backward, wheels right"),
            ("s", STOP, "standing"),
        ):
            terminal.keys(key)
            self.hold_command(*command)
            terminal.wait_screen(words)
        terminal.keys("Up")
        self.wait_command(0.5, 0.0)
        terminal.keys("c")
        self.hold_command(*STOP)

    def test_sizes(self):
        terminal = self.terminal
        small = terminal.wait_screen("keyboard teleop", "Ctrl-C", "continuous mode (C)")
        self.assertTrue(all(len(line) < 80 for line in small.splitlines()))
        terminal.keys("c", "Up")
        terminal.wait_screen("+0.500 m/s", "^ ^ ^", "continuous")
        terminal.resize(120, 40)
        wait_until(
            lambda: any(len(line) > 100 for line in terminal.screen().splitlines()),
            "the picture at 120x40",
        )
        large = terminal.wait_screen("+0.500 m/s", "^ ^ ^", "continuous", "Ctrl-C")
        self.assertTrue(all(len(line) < 120 for line in large.splitlines()))
        terminal.resize(30, 5)
        terminal.wait_screen("+0.50 m/s +0.00 rad/s", "continuous, forward")
        terminal.resize(1, 1)
        self.hold_command(0.5, 0.0)
        terminal.resize(80, 24)
        terminal.wait_screen("keyboard teleop", "+0.500 m/s")
        self.hold_command(0.5, 0.0)

    def drive_on(self):
        """Drives in continuous mode and clears the zeros before."""
        self.terminal.keys("c", "Up")
        self.hold_command(0.5, 0.0)

    def test_ends(self):
        self.drive_on()
        for number in (None, signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGKILL):
            with self.subTest(signal=number):
                guard = parent_of(self.pid)
                if number is None:
                    self.terminal.keys("C-c")
                else:
                    os.kill(self.pid, number)
                self.assert_ended(self.pid, guard)
            self.commands.clear()
            self.start()
            self.drive_on()
        with self.subTest("the guard is killed"):
            guard = parent_of(self.pid)
            os.kill(guard, signal.SIGKILL)
            self.assert_ended(self.pid, guard)

    def test_ctrl_z_does_not_leave_the_truck_alone(self):
        self.drive_on()
        self.terminal.keys("C-z")
        self.hold_command(0.5, 0.0)

    def test_terminal_goes_away(self):
        self.drive_on()
        self.terminal.tmux("respawn-pane", "-k", "bash --norc --noprofile")
        wait_until(lambda: not is_running(self.pid), "the end of the teleop")
        self.assertEqual(self.last(), STOP)


class WithX(Rig):
    """Keys from an X server; what happens when it goes away."""

    def setUp(self):
        self.server = XServer()
        self.addCleanup(self.server.close)
        self.display = self.server.display
        super().setUp()
        self.terminal.wait_screen("Keys come from the X server", "Caps Lock")

    def press(self, *names):
        self.server.key("keydown", *names)

    def release(self, *names):
        self.server.key("keyup", *names)

    def hold_up(self):
        """Holds Up; pressed before the teleop listens to the server it counts for nothing."""

        def driving():
            self.press("Up")
            for _ in range(200):
                if self.last() == (0.5, 0.0):
                    return True
                time.sleep(0.01)
            self.release("Up")
            return False

        wait_until(driving, "a command while Up is held")
        self.hold_command(0.5, 0.0)

    def test_held_keys_and_chords(self):
        for keys, command in (
            (["Up"], (0.5, 0.0)),
            (["Down"], (-0.5, 0.0)),
            (["Left"], STOP),
            (["Right"], STOP),
            (["Up", "Left"], (0.5, 0.5)),
            (["Up", "Right"], (0.5, -0.5)),
            (["Down", "Left"], (-0.5, -0.5)),
            (["Down", "Right"], (-0.5, 0.5)),
            (["Up", "Down"], STOP),
        ):
            with self.subTest(keys=keys):
                self.press(*keys)
                self.hold_command(*command, count=20)  # a second: longer than any key repeat
                self.release(*keys)
                self.hold_command(*STOP)

    def test_letters_and_stop(self):
        for key, words in (
            ("q", "0.550 m/s"),
            ("z", "0.495 m/s"),
            ("w", "0.550 rad/s"),
            ("x", "0.495 rad/s"),
            ("r", "0.500 m/s"),
        ):
            self.server.key("key", key)
            self.terminal.wait_screen(words)
        self.press("Up", "Left")
        self.hold_command(0.5, 0.5)
        self.press("s")
        self.release("s")
        self.hold_command(*STOP)
        self.release("Up", "Left")

    def test_caps_lock(self):
        self.server.key("key", "Caps_Lock")
        self.terminal.wait_screen("continuous")
        self.server.key("key", "Up")
        self.hold_command(0.5, 0.0)
        self.server.key("key", "Left")
        self.hold_command(0.5, 0.5)
        self.server.key("key", "q")  # a capital letter now
        self.hold_command(0.55, 0.5)
        self.server.key("key", "s")
        self.hold_command(*STOP)
        self.server.key("key", "Down")
        self.hold_command(-0.55, 0.0)
        self.server.key("key", "Caps_Lock")
        self.terminal.wait_screen("held", "standing")
        self.hold_command(*STOP)

    def test_ends(self):
        for number in (None, signal.SIGTERM, signal.SIGKILL):
            with self.subTest(signal=number):
                guard = parent_of(self.pid)
                self.hold_up()
                if number is None:
                    self.terminal.keys("C-c")
                else:
                    os.kill(self.pid, number)
                self.assert_ended(self.pid, guard)
                self.release("Up")
            self.commands.clear()
            self.start()

    def test_the_server_goes_away(self):
        self.hold_up()
        guard = parent_of(self.pid)
        self.server.close()
        self.assert_ended(self.pid, guard)
        self.terminal.wait_screen("the X server is gone; the truck was stopped")


class BadStarts(unittest.TestCase):
    """Errors at the start are one line."""

    def test_bad_parameters(self):
        terminal = Terminal(DISPLAY=None)
        self.addCleanup(terminal.close)
        for argument, words in (
            ("_linear_speed:=fast", "linear_speed is 'fast'"),
            ("_keys:=mouse", "one of auto, x, terminal"),
            ("_keys:=x", "DISPLAY is not set"),
            ("_rate:=0", "rate is 0"),
            ("_trailer:=1", "trailer is 1"),
        ):
            forget_parameters()
            terminal.type(f"clear; rosrun cybertruck keyboard {argument}; echo status=$?")
            terminal.wait_screen(words, "status=1")
            self.assertEqual(terminal.run("stty -a"), terminal.settings)

    def test_no_terminal_and_no_server(self):
        forget_parameters()
        terminal = Terminal(DISPLAY=":987")
        self.addCleanup(terminal.close)
        terminal.type("rosrun cybertruck keyboard < /dev/null; echo status=$?")
        terminal.wait_screen("no keys", "no X server at DISPLAY=:987", "status=1")

    def test_no_master(self):
        terminal = Terminal(DISPLAY=None, ROS_MASTER_URI="http://127.0.0.1:1")
        self.addCleanup(terminal.close)
        terminal.type("rosrun cybertruck keyboard; echo status=$?")
        terminal.wait_screen("no ROS master at http://127.0.0.1:1", "status=1")


if __name__ == "__main__":
    rospy.init_node("keyboard_test")
    tests = {kind.__name__: kind for kind in (WithoutX, WithX, BadStarts)}
    rostest.rosrun("paddock_tests", rospy.get_name().strip("/"), tests[sys.argv[1]])
