"""Held keys of an X server, checked on /cmd_vel and the screen."""

import os
import signal

from keyboard_rig import RigWithX
from terminal_rig import parent_of

LAUNCH = "<launch></launch>"  # a ROS master


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
