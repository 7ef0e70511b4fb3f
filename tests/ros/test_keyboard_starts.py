"""Starts of the keyboard teleop that are refused, or have nothing to read keys from."""

import unittest

from keyboard_rig import forget_parameters
from terminal_rig import Terminal

LAUNCH = "<launch></launch>"  # a ROS master


class BadStarts(unittest.TestCase):
    """Errors at the start are one line."""

    def test_bad_parameters(self):
        terminal = Terminal(DISPLAY=None)
        self.addCleanup(terminal.close)
        for argument, words in (
            ("_linear_speed:=fast", "linear_speed is 'fast'"),
            ("_keys:=x", "DISPLAY is not set"),
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
