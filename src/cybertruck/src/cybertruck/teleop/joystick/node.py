"""The node `joystick`: a pad's /joy to /cmd_vel, with the truck drawn in the terminal."""

import queue
import time

import rospy
from paddock_common.rules import Number
from paddock_common.settings import parameter
from sensor_msgs.msg import Joy

from cybertruck.teleop.joystick.pad_map import PadReader, parse
from cybertruck.teleop.joystick.schemes import PadTeleop
from cybertruck.teleop.session import run

WAITING, DRIVING, LOST = "waiting", "driving", "lost"


class JoystickNode:
    """The joystick node.

    It publishes periodically from the first input of the pad on. When the pad is lost it publishes
    one zero and nothing more until the next input.
    """

    def __init__(self, session):
        """Reads the parameters and subscribes to /joy.

        Args:
            session: Session.

        Raises:
            ValueError: A parameter is wrong; the message names it.
        """
        self._session = session
        self._name = rospy.get_param("~scheme", "traditional")
        self.teleop = PadTeleop(self._name, session.speeds())
        deadzone = parameter(rospy.get_param, "deadzone", 0.05, Number(above=0.0, below=1.0))
        self._reader = PadReader(parse(rospy.get_param("~pad", None)), deadzone)
        self._timeout = parameter(rospy.get_param, "joy_timeout", 0.5, Number(above=0.0, unit="s"))
        self._messages = queue.SimpleQueue()
        self._state, self._received = WAITING, None
        self._complaint = None
        rospy.Subscriber(
            "joy",
            Joy,
            lambda message: self._messages.put((time.monotonic(), message)),
            queue_size=None,
        )

    def tick(self, now, period):
        """Processes the pad's messages, publishes the command, draws.

        Args:
            now: Time [s].
            period: Time since the last call [s].
        """
        while True:
            try:
                when, message = self._messages.get_nowait()
            except queue.Empty:
                break
            self._received = when
            self._take(message)
        if self._state == DRIVING and now - self._received > self._timeout:
            self._on_pad_lost(
                f"no /joy for {self._timeout:g} s: the pad is lost, the truck was stopped"
            )
        if self._state == DRIVING:
            self._session.send(*self.teleop.wanted, period)
        if self._session.screen:
            self._session.screen.keys()  # what is typed here means nothing
        title = f"Cyber Truck: joystick teleop, {self._name}"
        self._session.show(title, self.teleop, self._notes(), self.teleop.scheme.help)

    def _notes(self):
        """Lines about the pad, and what is wrong with it."""
        note = {
            WAITING: "Waiting for /joy: move a stick or press a button.",
            DRIVING: "The pad drives.",
            LOST: "The pad is lost; nothing is sent.",
        }[self._state]
        return (note,) if self._complaint is None else (note, self._complaint)

    def _take(self, message):
        """Processes one Joy message."""
        try:
            pad = self._reader.read(message.axes, message.buttons)
        except ValueError as error:
            self._on_pad_lost(f"/joy: {error}; the truck was stopped")
            return
        if pad.unplugged and self._state == DRIVING:
            self._on_pad_lost("the pad was unplugged; the truck was stopped")
            return
        if self._state != DRIVING:
            if pad.idle:
                return
            self._state, self._complaint = DRIVING, None
        self.teleop.update(pad)

    def _on_pad_lost(self, text):
        """Publishes one zero, stops publishing and logs the reason once."""
        if self._complaint != text:
            rospy.logwarn("joystick: %s", text)
        self._complaint = text
        self.teleop.halt()
        self._reader.reset()
        if self._state == DRIVING:
            self._session.send_zero()
        self._state = LOST


def main():
    """Runs the node.

    Returns:
        Exit status.
    """
    return run("joystick", JoystickNode)
