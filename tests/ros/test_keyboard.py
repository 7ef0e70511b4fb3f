"""A drive by keys of a terminal and by keys of an X server; tests/long/ has all of them."""

import keyboard_rig
from keyboard_rig import STOP
from terminal_rig import parent_of

LAUNCH = "<launch></launch>"  # a ROS master


class WithoutX(keyboard_rig.Rig):
    """Keys read from the terminal."""

    def test_drives_and_ends_with_a_zero(self):
        self.terminal.wait_screen("Keys come from this terminal", "at rest")
        self.terminal.keys("c", "Up")
        self.hold_command(0.5, 0.0)
        self.terminal.wait_screen("+0.500 m/s", "continuous")
        guard = parent_of(self.pid)
        self.terminal.keys("C-c")
        self.assert_ended(self.pid, guard)


class WithX(keyboard_rig.RigWithX):
    """Keys from an X server."""

    def test_a_chord_and_the_end_of_the_server(self):
        self.press("Up", "Left")
        self.hold_command(0.5, 0.5)
        self.release("Up", "Left")
        self.hold_command(*STOP)
        self.hold_up()
        guard = parent_of(self.pid)
        self.server.close()
        self.assert_ended(self.pid, guard)
        self.terminal.wait_screen("the X server has exited; the truck was stopped")
