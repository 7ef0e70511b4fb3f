"""The node teleop_twist_keyboard: keys of a terminal to twists."""

import os
import select
import sys
import termios
import threading
import tty

import rospy
from geometry_msgs.msg import Twist, TwistStamped
from paddock_common.waiting import flush

from paddock_common import nodes

# (forward, left, up, rotation to the left), each -1, 0 or 1
MOVES = {
    "u": (1, 0, 0, 1),
    "i": (1, 0, 0, 0),
    "o": (1, 0, 0, -1),
    "j": (0, 0, 0, 1),
    "l": (0, 0, 0, -1),
    "m": (-1, 0, 0, -1),
    ",": (-1, 0, 0, 0),
    ".": (-1, 0, 0, 1),
    "U": (1, 1, 0, 0),
    "I": (1, 0, 0, 0),
    "O": (1, -1, 0, 0),
    "J": (0, 1, 0, 0),
    "L": (0, -1, 0, 0),
    "M": (-1, 1, 0, 0),
    "<": (-1, 0, 0, 0),
    ">": (-1, -1, 0, 0),
    "t": (0, 0, 1, 0),
    "b": (0, 0, -1, 0),
}
# factors of (speed, yaw rate)
SCALES = {
    "q": (1.1, 1.1),
    "z": (0.9, 0.9),
    "w": (1.1, 1.0),
    "x": (0.9, 1.0),
    "e": (1.0, 1.1),
    "c": (1.0, 0.9),
}
QUIT = "\x03"  # Ctrl-C
STILL = (0, 0, 0, 0)

HELP = """
Keys become velocity commands.

  drive and turn      with Shift: sideways
    u   i   o            U   I   O
    j   k   l            J   K   L
    m   ,   .            M   <   >

  t, b     up, down
  q, z     10 % faster, slower
  w, x     10 % faster, slower, driving alone
  e, c     10 % faster, slower, turning alone
  any other key stops, Ctrl-C ends
"""


class Keys:
    """Direction and speed, changed by keys.

    Args:
        speed: First speed [m/s].
        yaw_rate: First yaw rate [rad/s].
        speed_limit: Maximum speed [m/s].
        yaw_rate_limit: Maximum yaw rate [rad/s].

    Attributes:
        move: (forward, left, up, yaw), each -1, 0 or 1.
    """

    def __init__(self, speed=0.5, yaw_rate=1.0, speed_limit=1000.0, yaw_rate_limit=1000.0):
        self.speed, self.yaw_rate = speed, yaw_rate
        self._limits = speed_limit, yaw_rate_limit
        self.move = STILL

    def press(self, key):
        """Processes a key, or "" when none arrived in time.

        Returns:
            Whether there is a command to send.
        """
        if key in MOVES:
            self.move = MOVES[key]
        elif key in SCALES:
            self.speed = min(self._limits[0], self.speed * SCALES[key][0])
            self.yaw_rate = min(self._limits[1], self.yaw_rate * SCALES[key][1])
        else:
            if key == "" and self.move == STILL:
                return False
            self.move = STILL
        return True

    @property
    def velocity(self):
        """(forward, left, up [m/s], yaw [rad/s])."""
        forward, left, up, yaw_rate = self.move
        return forward * self.speed, left * self.speed, up * self.speed, yaw_rate * self.yaw_rate

    def status(self):
        """One line: speed and yaw rate, and whether they are at their limits."""
        line = f"currently:\tspeed {self.speed:.4g} m/s\tturn {self.yaw_rate:.4g} rad/s"
        for name, value, limit in zip(("speed", "turn"), (self.speed, self.yaw_rate), self._limits):
            if value >= limit:
                line += f"\t{name} is at its limit"
        return line


class Sender:
    """A thread that publishes cmd_vel.

    Args:
        repeat_rate: Messages per second of wall time while nothing changes [Hz]; 0: none.
        stamped: Whether to publish geometry_msgs/TwistStamped.
        frame: frame_id of those.
    """

    def __init__(self, repeat_rate=0.0, stamped=False, frame=""):
        self._stamped, self._frame = stamped, frame
        self.publisher = rospy.Publisher(
            "cmd_vel", TwistStamped if stamped else Twist, queue_size=1
        )
        self._period = 1.0 / repeat_rate if repeat_rate else None
        self._condition = threading.Condition()
        self._velocity, self._waiting, self._closed = None, False, False
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def send(self, velocity):
        """Publishes (forward, left, up [m/s], yaw [rad/s])."""
        with self._condition:
            self._velocity, self._waiting = velocity, True
            self._condition.notify()

    def close(self):
        """Publishes zeros and stops the thread."""
        with self._condition:
            self._closed = True
            self._condition.notify()
        self._thread.join()
        self._publish((0.0, 0.0, 0.0, 0.0))
        flush(self.publisher)

    def _run(self):
        while True:
            with self._condition:
                if not (self._waiting or self._closed):
                    self._condition.wait(self._period)
                if self._closed:
                    return
                self._waiting, velocity = False, self._velocity
            if velocity is not None:
                self._publish(velocity)

    def _publish(self, velocity):
        twist = Twist()
        twist.linear.x, twist.linear.y, twist.linear.z, twist.angular.z = velocity
        if self._stamped:
            message = TwistStamped(twist=twist)
            message.header.stamp = rospy.Time.now()
            message.header.frame_id = self._frame
            twist = message
        self.publisher.publish(twist)


class Terminal:
    """A terminal that returns each key immediately; to be used with `with`.

    Args:
        descriptor: File descriptor of the terminal.

    Raises:
        ValueError: It is not a terminal.
    """

    def __init__(self, descriptor):
        if not os.isatty(descriptor):
            raise ValueError(
                "standard input is not a terminal; start the node in one with rosrun, or in a "
                "launch file with launch-prefix, such as launch-prefix='xterm -e'"
            )
        self._descriptor = descriptor

    def __enter__(self):
        self._settings = termios.tcgetattr(self._descriptor)
        tty.setraw(self._descriptor, termios.TCSANOW)
        output_as_before = termios.tcgetattr(self._descriptor)
        output_as_before[1] = self._settings[1]  # lines still start at the left margin
        termios.tcsetattr(self._descriptor, termios.TCSANOW, output_as_before)
        return self

    def __exit__(self, *_):
        termios.tcsetattr(self._descriptor, termios.TCSADRAIN, self._settings)

    def key(self, timeout):
        """Waits for a key.

        Args:
            timeout: Maximum wait in wall time [s]; None: unlimited.

        Returns:
            The key, "" when none arrived in time, or None when the terminal was closed.
        """
        ready, _, _ = select.select([self._descriptor], [], [], timeout)
        if not ready:
            return ""
        try:
            data = os.read(self._descriptor, 1)
        except OSError:
            return None
        return data.decode("latin-1") if data else None


WAIT_PERIOD = 0.5  # wall time between two checks for a subscriber [s]
LINES_PER_HELP = 15  # status lines after which the keys are listed again


def _number(name, default):
    value = rospy.get_param("~" + name, default)
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not value >= 0.0:
        raise ValueError(f"{name} is {value!r}, must be a number of 0 or more")
    return float(value)


def wait_for_subscriber(terminal, publisher):
    """Waits for a subscriber of the commands.

    Returns:
        Whether there is one; False after Ctrl-C.
    """
    checks = 0
    while not rospy.is_shutdown() and publisher.get_num_connections() == 0:
        if checks % 5 == 4:
            print(f"waiting for a subscriber of {publisher.resolved_name}")
        checks += 1
        if terminal.key(WAIT_PERIOD) in (QUIT, None):
            return False
    return not rospy.is_shutdown()


def drive(terminal, keys, sender, key_timeout):
    """Processes keys until Ctrl-C or a shutdown of ROS."""
    print(HELP)
    print(keys.status())
    lines = 0
    while not rospy.is_shutdown():
        key = terminal.key(key_timeout)
        if key in (QUIT, None):
            return
        if keys.press(key):
            sender.send(keys.velocity)
        if key in SCALES:
            lines += 1
            if lines % LINES_PER_HELP == 0:
                print(HELP)
            print(keys.status())


def read_parameters():
    """Keys, time-out of a key [s] or None, repeat rate [Hz], Terminal.

    Raises:
        ValueError: A parameter is wrong or there is no terminal.
    """
    keys = Keys(
        _number("speed", 0.5),
        _number("turn", 1.0),
        _number("speed_limit", 1000.0),
        _number("turn_limit", 1000.0),
    )
    rates = _number("key_timeout", 0.5) or None, _number("repeat_rate", 0.0)
    return keys, *rates, Terminal(sys.stdin.fileno())


def main():
    keys, key_timeout, repeat_rate, terminal = nodes.start("teleop_twist_keyboard", read_parameters)
    with terminal:
        sender = Sender(
            repeat_rate,
            bool(rospy.get_param("~stamped", False)),
            str(rospy.get_param("~frame_id", "")),
        )
        try:
            if wait_for_subscriber(terminal, sender.publisher):
                sender.send(keys.velocity)
                drive(terminal, keys, sender, key_timeout)
        finally:
            sender.close()
