"""Shared by both teleops: ROS, signals, the terminal, and the zero at the end."""

import contextlib
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
from paddock_common.process import StopRequest
from paddock_common.settings import Number, parameter, read
from paddock_common.waiting import flush

from cybertruck.teleop import supervisor
from cybertruck.teleop.limits import Limits, RateLimiter, Speeds
from cybertruck.teleop.screen import Screen, View
from paddock_common import nodes


class TeleopExit(Exception):
    """The teleop exits; the text is the reason."""


class Session:
    """One run of a teleop, from its first message to its last zero command.

    Raises:
        TeleopExit: There is no ROS master.
        ValueError: A parameter is wrong; the message names it.
    """

    def __init__(self, name):
        if not rosgraph.is_master_online():
            raise TeleopExit(f"no ROS master at {rosgraph.get_master_uri()}")
        nodes.init_node(name, disable_signals=True)
        self.stop = StopRequest(supervisor.SIGNALS)
        signal.signal(signal.SIGTSTP, signal.SIG_IGN)  # a suspended teleop could not stop the truck
        self.limits = read(Limits, rospy.get_param)
        self.rate = parameter(rospy.get_param, "rate", 20.0, Number(above=0.0, unit="Hz"))
        self._limiter = RateLimiter(self.limits)
        self.sent = (0.0, 0.0)  # the last command [m/s, rad/s]
        self.screen, self._phase = None, 0
        self._lock = threading.Lock()
        self._over = False
        self._stderr = None
        self._publisher = rospy.Publisher("cmd_vel", Twist, queue_size=10)
        rospy.on_shutdown(self.finish)

    def speeds(self):
        """Returns the Speeds that the parameters set, within the limits.

        Raises:
            ValueError: A parameter is wrong; the message names it.
        """
        return Speeds(
            rospy.get_param("~linear_speed", 0.5),
            rospy.get_param("~angular_speed", 0.5),
            self.limits.max_speed,
            self.limits.max_angular,
        )

    def open_screen(self):
        """Opens the screen, if there is a terminal; then logs go to /rosout only."""
        if not (sys.stdin.isatty() and sys.stdout.isatty()):
            return
        try:
            self.screen = Screen()
        except curses.error as error:
            raise TeleopExit(
                f"TERM={os.environ.get('TERM', '')!r} is not a terminal for the screen: {error}"
            ) from None
        rosout = logging.getLogger("rosout")
        rosout.handlers = [item for item in rosout.handlers if "Stream" not in type(item).__name__]
        self._stderr, sys.stderr = sys.stderr, io.StringIO()

    def send(self, linear, angular, period):
        """Publishes a requested command within the limits, see RateLimiter.step."""
        self.sent = self._limiter.step(linear, angular, period)
        with self._lock:
            if not self._over:
                self._publish(*self.sent)

    def show(self, title, teleop, notes, keys):
        """Shows the motion on the screen, if there is one.

        Args:
            teleop: KeyTeleop or PadTeleop.
            notes: Lines about the source of the events, warnings first.
            keys: Lines of key help.
        """
        if not self.screen:
            return
        self._phase = self._phase + 1 if teleop.motion[0] else 0
        self.screen.show(View(title, self.sent, teleop, self.limits, notes, keys, self._phase // 4))

    def send_zero(self):
        """Publishes one zero and resets the motion."""
        self._limiter.reset()
        self.send(0.0, 0.0, 0.0)

    def loop(self, tick):
        """Calls a function periodically, in wall time, until the session stops.

        Args:
            tick: Function (now [s], time since the last call [s]).

        Raises:
            TeleopExit: The terminal was closed.
        """
        period = 1.0 / self.rate
        last = time.monotonic()
        while not (self.stop.requested() or rospy.is_shutdown()):
            now = time.monotonic()
            tick(now, now - last)
            last = now
            if self.screen and terminal_is_closed():
                raise TeleopExit("the terminal was closed")
            time.sleep(max(0.0, period - (time.monotonic() - now)))

    def finish(self):
        """Publishes the zero; nothing is published after it."""
        with self._lock:
            if self._over:
                return
            self._over = True
            self._publish(0.0, 0.0)
        flush(self._publisher)

    def close(self):
        """Publishes the zero and restores the terminal; may be called twice."""
        self.finish()
        if self.screen:
            with contextlib.suppress(curses.error):  # the terminal was closed
                self.screen.close()
            self.screen = None
        if self._stderr is not None:
            caught, sys.stderr = sys.stderr.getvalue(), self._stderr
            self._stderr = None
            sys.stderr.write(caught)
        if not rospy.is_shutdown():
            rospy.signal_shutdown("the teleop exits")

    def _publish(self, linear, angular):
        message = Twist()
        message.linear.x, message.angular.z = linear, angular
        self._publisher.publish(message)


def terminal_is_closed():
    """Returns whether the terminal was closed."""
    poll = select.poll()
    poll.register(0, select.POLLIN)
    return any(
        event & (select.POLLHUP | select.POLLERR | select.POLLNVAL) for _, event in poll.poll(0)
    )


def run(name, make_node):
    """Runs a teleop under the supervisor of its terminal.

    Args:
        make_node: Class or function (session) whose result has tick(now, period).

    Returns:
        Exit status: 0 after Ctrl-C or a shutdown of the node, 128 + signal number after another
        signal, 1 after an error.
    """
    supervisor.enter()
    session = None
    try:
        session = Session(name)
        node = make_node(session)
        session.open_screen()
        session.loop(node.tick)
    except (TeleopExit, ValueError) as error:
        if session:
            session.close()
        print(f"{name}: {error}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:  # before the signal handlers were installed
        return 0
    finally:
        if session:
            session.close()
    stop_signal = session.stop.signal
    return 0 if stop_signal in (None, signal.SIGINT) else 128 + stop_signal
