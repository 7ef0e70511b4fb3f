"""The node `joystick`: a pad's /joy to /cmd_vel, with the truck drawn in the terminal."""

import queue
import time

import rospy
from sensor_msgs.msg import Joy

from cybertruck.teleop.joystick.pad_map import PadReader, parse
from cybertruck.teleop.joystick.schemes import PadTeleop
from cybertruck.teleop.screen import View
from cybertruck.teleop.session import number_parameter, run
from cybertruck.teleop.speeds import Speeds

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
        limits = session.limits
        self._session = session
        self._name = rospy.get_param("~scheme", "traditional")
        self.teleop = PadTeleop(
            self._name,
            Speeds(
                rospy.get_param("~linear_speed", 0.5),
                rospy.get_param("~angular_speed", 0.5),
                limits.max_speed,
                limits.max_angular,
            ),
        )
        deadzone = number_parameter("deadzone", 0.05)
        if deadzone >= 1.0:
            raise ValueError(f"deadzone is {deadzone!r}; it must be below 1")
        self._reader = PadReader(parse(rospy.get_param("~pad", None)), deadzone)
        self._timeout = number_parameter("joy_timeout", 0.5)
        self._messages = queue.SimpleQueue()
        self._state, self._received, self._phase = WAITING, None, 0
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
        drive, turn = self.teleop.motion
        self._phase = self._phase + 1 if drive else 0
        screen = self._session.screen
        if screen:
            screen.keys()  # typed keys are ignored
            screen.show(self.view(drive, turn))

    def view(self, drive, turn):
        """Returns the View for the screen."""
        limits, speeds = self._session.limits, self.teleop.speeds
        linear, angular = self._session.sent
        note = {
            WAITING: "Waiting for /joy: move a stick or press a button.",
            DRIVING: "The pad drives.",
            LOST: "The pad is lost; nothing is sent.",
        }[self._state]
        notes = (note,) if self._complaint is None else (note, self._complaint)
        return View(
            f"Cyber Truck: joystick teleop, {self._name}",
            linear,
            angular,
            speeds.linear,
            speeds.angular,
            limits.max_speed,
            limits.max_angular,
            self.teleop.continuous,
            drive,
            turn,
            notes,
            self.teleop.scheme.help,
            self._phase // 4,
        )

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


def body(session):
    """Drives until the session ends."""
    node = JoystickNode(session)
    session.open_screen()
    session.loop(node.tick)


def main():
    """Runs the node.

    Returns:
        Exit status.
    """
    return run("joystick", body)
