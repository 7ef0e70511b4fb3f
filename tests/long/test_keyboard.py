"""How a drive by keys of a terminal or of an X server ends, checked on /cmd_vel and the screen."""

import os
import signal

from keyboard_rig import STOP, Rig, RigWithX
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


class WithX(RigWithX):
    """Keys from an X server; what happens when it goes away."""

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
        self.terminal.wait_screen("the X server has exited; the truck was stopped")
