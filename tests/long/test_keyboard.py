"""Keys in a terminal, checked on /cmd_vel and the screen."""

import os
import signal

from keyboard_rig import STOP, Rig
from sim_client import wait_until
from terminal_rig import parent_of
from testing import is_running

LAUNCH = "<launch></launch>"  # a ROS master


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
            "at rest",
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
            ("s", STOP, "at rest"),
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
        self.wait_command(*STOP)
