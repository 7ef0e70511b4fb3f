"""Held keys of an X server, checked on /cmd_vel and the screen."""

import os
import signal

from keyboard_rig import STOP, RigWithX
from terminal_rig import parent_of

LAUNCH = "<launch></launch>"  # a ROS master


class WithX(RigWithX):
    """Keys from an X server; what happens when it goes away."""

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
        ):
            with self.subTest(keys=keys):
                self.press(*keys)
                self.hold_command(*command, count=20)  # a second: longer than any key repeat
                self.release(*keys)
                self.hold_command(*STOP)

    def test_opposite_keys_stop(self):
        self.press("Up")
        self.hold_command(0.5, 0.0)
        self.press("Down")
        self.hold_command(*STOP, count=20)
        self.release("Up")
        self.hold_command(-0.5, 0.0)
        self.release("Down")
        self.hold_command(*STOP)

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
        self.terminal.wait_screen("held", "at rest")
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
        self.terminal.wait_screen("the X server has exited; the truck was stopped")
