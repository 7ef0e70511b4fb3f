"""A fake pad on /joy, checked on /cmd_vel: driving, invalid messages, a lost pad; the screen."""

import threading
import time
import unittest

import rospy
from geometry_msgs.msg import Twist
from launches import wait_subscribed
from rosgraph_msgs.msg import Log
from sensor_msgs.msg import Joy
from sim_client import Recorder, wait_connected, wait_until
from terminal_rig import Terminal

LAUNCH = """<launch>
  <include file="$(find cybertruck)/launch/teleop_joystick.launch">
    <arg name="start_joy" value="false"/>
    <arg name="trailer" value="false"/>
  </include>
</launch>
"""

QUIET = 0.5  # wall time without a message that counts as silence: ten periods [s]
REST = {2: 1.0, 5: 1.0}
FULL = {2: 1.0, 5: -1.0}


class Pad:
    """A driver of a pad: repeats its state at 20 Hz until it is unplugged."""

    def __init__(self, topic):
        self._publisher = rospy.Publisher(topic, Joy, queue_size=10)
        self._message = None
        self._lock = threading.Lock()  # nothing follows silence()
        threading.Thread(target=self._repeat, daemon=True).start()

    def wait(self):
        wait_connected(self._publisher, "the joystick teleop")

    def hold(self, axes=None, buttons=()):
        """Holds axes (index -> value) and buttons (indices) from now on."""
        message = Joy(axes=[0.0] * 8, buttons=[0] * 13)
        for index, value in (axes or REST).items():
            message.axes[index] = value
        for index in buttons:
            message.buttons[index] = 1
        with self._lock:
            self.send(message)
            self._message = message

    def send(self, message):
        self._publisher.publish(message)

    def silence(self):
        """Stops publishing."""
        with self._lock:
            self._message = None

    def _repeat(self):
        while not rospy.is_shutdown():
            with self._lock:
                if self._message is not None:
                    self.send(self._message)
            time.sleep(0.05)


class Joystick(unittest.TestCase):
    """The traditional scheme on a PS4 pad, through messages."""

    @classmethod
    def setUpClass(cls):
        cls.commands = Recorder("/cmd_vel", Twist)
        cls.log = Recorder("/rosout", Log)
        cls.pad = Pad("/joy")
        cls.pad.wait()

    def setUp(self):
        self.pad.hold()
        time.sleep(QUIET)

    def tearDown(self):
        self.pad.silence()
        time.sleep(2.0 * QUIET)

    def last(self):
        message = self.commands.last
        return message and (round(message.linear.x, 3), round(message.angular.z, 3))

    def wait_command(self, linear, angular):
        wait_until(lambda: self.last() == (linear, angular), f"command {(linear, angular)}")

    def warned(self, words):
        return sum(words in item.msg for item in self.log.messages if item.level >= Log.WARN)

    def wait_warned(self, words, count):
        wait_until(lambda: self.warned(words) >= count, f"{count} warnings '{words}'")

    def assert_one_zero_then_silence(self):
        self.wait_command(0.0, 0.0)
        time.sleep(QUIET)
        messages = self.commands.messages
        # earlier zeros are of a pad whose thread had no processor for joy_timeout
        self.assertEqual([item.linear.x == 0.0 for item in messages[-2:]], [False, True])
        time.sleep(QUIET)
        self.assertEqual(len(self.commands.messages), len(messages))

    def full_speed(self):
        self.pad.hold(FULL)
        self.wait_command(0.5, 0.0)
        self.commands.clear()
        self.commands.wait_count(5)  # it is repeated
        self.pad.hold(FULL)  # just now: what follows comes while the pad drives

    def test_silent_until_it_is_touched(self):
        self.pad.silence()
        time.sleep(2.0 * QUIET)
        self.commands.clear()
        self.pad.hold()
        time.sleep(QUIET)
        self.assertEqual(self.commands.messages, [])
        self.pad.hold({**FULL, 0: 1.0})
        self.wait_command(0.5, 0.5)
        self.pad.hold()
        self.wait_command(0.0, 0.0)

    def test_unplugged_without_a_word(self):
        self.full_speed()
        self.pad.silence()
        self.assert_one_zero_then_silence()
        self.wait_warned("the pad is disconnected", 1)
        self.full_speed()  # it is plugged in again

    def test_screen(self):
        """A second teleop in a terminal of its own, with another scheme and a low acceleration."""
        pad, commands = Pad("/other/joy"), Recorder("/other/cmd_vel", Twist)
        terminal = Terminal(DISPLAY=None)
        self.addCleanup(terminal.close)
        config = "$(rospack find cybertruck)/config"
        terminal.type(
            f"export ROS_NAMESPACE=/other; rosparam load {config}/joystick_ps4.yaml joystick; clear"
        )
        terminal.type("rosrun cybertruck joystick _scheme:=alternate _max_acceleration:=0.1")
        terminal.wait_screen("joystick teleop, alternate", "Waiting for /joy", "Cross")
        pad.wait()
        wait_subscribed([commands.topic], publisher="/other/joystick")
        pad.hold({**REST, 1: -1.0, 0: 1.0})
        terminal.wait_screen("forward, wheels left", "+0.500 m/s", "The pad drives")
        speeds = [item.linear.x for item in commands.messages]
        self.assertLess(min(filter(None, speeds)), 0.5)  # which takes it 5 s
        rises = [later >= before for before, later in zip(speeds, speeds[1:]) if later != 0.0]
        self.assertEqual(rises, [True] * len(rises))  # a stop may be of a pad without a processor
        pad.hold({**REST}, [3])
        terminal.wait_screen("continuous")
        pad.silence()
        terminal.wait_screen("The pad is disconnected", "at rest", "no /joy for 0.5 s")
        terminal.keys("C-c")
        self.assertEqual(terminal.run("stty -a"), terminal.settings)
        self.assertEqual(terminal.state(), ("0", "1"))
