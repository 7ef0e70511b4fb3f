"""Shared by both teleops: ROS, signals, the terminal, and the zero at the end."""

import curses
import io
import logging
import os
import select
import signal
import sys
import threading
import time

import rosgraph
import rospy
from geometry_msgs.msg import Twist

from cybertruck.teleop import guard
from cybertruck.teleop.limits import Limits, RateLimiter
from cybertruck.teleop.screen import Screen

FLUSH = 0.15  # wall time for rospy's threads to send the last message [s]
LIMIT_NAMES = (
    "wheelbase",
    "max_speed",
    "max_angular",
    "max_steering",
    "max_acceleration",
    "max_steering_rate",
    "trailer",
    "hitch_offset",
    "tongue_length",
    "max_hitch_angle",
)


class Ended(Exception):
    """The teleop ends by itself; the text tells the user why."""


class Session:
    """One run of a teleop, from its first message to its last zero."""

    def __init__(self, name):
        """Starts the ROS node and installs signal handlers.

        Args:
            name: Default name of the node.

        Raises:
            Ended: There is no ROS master.
            ValueError: A parameter is wrong; the message names it.
        """
        if not rosgraph.is_master_online():
            raise Ended(f"no ROS master at {rosgraph.get_master_uri()}")
        self.signal = None  # number of the signal that ends the session
        rospy.init_node(name, disable_signals=True)
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT):
            signal.signal(number, self._on_signal)
        signal.signal(signal.SIGTSTP, signal.SIG_IGN)  # a suspended teleop could not stop the truck
        self.limits = Limits(
            **{key: rospy.get_param("~" + key) for key in LIMIT_NAMES if rospy.has_param("~" + key)}
        )
        self.rate = number_parameter("rate", 20.0)
        self._limiter = RateLimiter(self.limits)
        self.sent = (0.0, 0.0)  # the last command [m/s, rad/s]
        self.screen = None
        self._lock = threading.Lock()
        self._over = False
        self._stderr = None
        self._publisher = rospy.Publisher("cmd_vel", Twist, queue_size=10)
        rospy.on_shutdown(self.finish)

    def open_screen(self):
        """Opens the screen, if there is a terminal; then logs go to /rosout only."""
        if not (sys.stdin.isatty() and sys.stdout.isatty()):
            return
        try:
            self.screen = Screen()
        except curses.error as error:
            raise Ended(
                f"TERM={os.environ.get('TERM', '')!r} is no terminal to draw on: {error}"
            ) from None
        rosout = logging.getLogger("rosout")
        rosout.handlers = [item for item in rosout.handlers if "Stream" not in type(item).__name__]
        self._stderr, sys.stderr = sys.stderr, io.StringIO()

    def send(self, linear, angular, period):
        """Publishes a wanted command within the limits.

        Args:
            linear: Wanted linear.x [m/s].
            angular: Wanted angular.z [rad/s].
            period: Time since the last command [s].
        """
        self.sent = self._limiter.step(linear, angular, period)
        with self._lock:
            if not self._over:
                self._publish(*self.sent)

    def send_zero(self):
        """Publishes one zero and resets the motion."""
        self._limiter.reset()
        self.send(0.0, 0.0, 0.0)

    def loop(self, tick):
        """Calls a function periodically, in wall time, until the session ends.

        Args:
            tick: Function (now [s], time since the last call [s]).

        Raises:
            Ended: The terminal is gone.
        """
        period = 1.0 / self.rate
        last = time.monotonic()
        while self.signal is None and not rospy.is_shutdown():
            now = time.monotonic()
            tick(now, now - last)
            last = now
            if self.screen and terminal_gone():
                raise Ended("the terminal is gone")
            time.sleep(max(0.0, period - (time.monotonic() - now)))

    def finish(self):
        """Publishes the zero; nothing is published after it."""
        with self._lock:
            if self._over:
                return
            self._over = True
            self._publish(0.0, 0.0)
        time.sleep(FLUSH)

    def close(self):
        """Publishes the zero and restores the terminal; may be called twice."""
        self.finish()
        if self.screen:
            try:
                self.screen.close()
            except curses.error:  # the terminal is gone
                pass
            self.screen = None
        if self._stderr is not None:
            caught, sys.stderr = sys.stderr.getvalue(), self._stderr
            self._stderr = None
            sys.stderr.write(caught)
        if not rospy.is_shutdown():
            rospy.signal_shutdown("the teleop ends")

    def _publish(self, linear, angular):
        message = Twist()
        message.linear.x, message.angular.z = linear, angular
        self._publisher.publish(message)

    def _on_signal(self, number, _frame):
        self.signal = number


def number_parameter(name, default):
    """Reads a private parameter that is a number above 0.

    Raises:
        ValueError: It is not; the message names it.
    """
    value = rospy.get_param("~" + name, default)
    if (
        isinstance(value, bool)
        or not isinstance(value, (int, float))
        or not value > 0.0
        or value == float("inf")
    ):
        raise ValueError(f"{name} is {value!r}; it must be a number above 0")
    return float(value)


def terminal_gone():
    """Returns whether the terminal was closed."""
    poll = select.poll()
    poll.register(0, select.POLLIN)
    return any(
        event & (select.POLLHUP | select.POLLERR | select.POLLNVAL) for _, event in poll.poll(0)
    )


def run(name, body):
    """Runs a teleop under the guard of its terminal.

    Args:
        name: Default name of the node.
        body: Function (session) that returns when the teleop ends.

    Returns:
        Exit status: 0 after Ctrl-C or a shutdown of the node, 128 + number after another signal,
        1 after an error.
    """
    guard.enter()
    session = None
    try:
        session = Session(name)
        body(session)
    except (Ended, ValueError) as error:
        if session:
            session.close()
        print(f"{name}: {error}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:  # before the signal handlers were installed
        return 0
    finally:
        if session:
            session.close()
    return 0 if session.signal in (None, signal.SIGINT) else 128 + session.signal
