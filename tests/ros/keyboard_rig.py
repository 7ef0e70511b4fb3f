"""Keys in a terminal and on an X server, checked on /cmd_vel and the screen."""

import os
import time
import unittest

import rospy
from geometry_msgs.msg import Twist
from sim_client import Recorder, wait_until
from terminal_rig import Terminal, XServer, node_pid
from testing import is_running

NODE = os.path.join(os.environ["PADDOCK_ROOT"], "src", "cybertruck", "nodes", "keyboard")
COMMAND = f"{NODE} _max_acceleration:=0 _max_steering_rate:=0"
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


class RigWithX(Rig):
    """The same with an X server, from which the keys come."""

    def setUp(self):
        self.server = XServer()
        self.addCleanup(self.server.close)
        self.display = self.server.display
        super().setUp()
        self.terminal.wait_screen("Keys come from the X server", "Caps Lock")
        self.hold_up()  # it listens
        self.release("Up")
        self.hold_command(*STOP)

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
