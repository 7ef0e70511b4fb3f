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
