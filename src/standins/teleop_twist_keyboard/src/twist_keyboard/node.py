"""The node teleop_twist_keyboard.py."""

import sys

import rospy

from paddock_common import nodes
from twist_keyboard.keys import HELP, QUIT, SCALES, Keys
from twist_keyboard.sender import Sender
from twist_keyboard.terminal import Terminal

WAIT_PERIOD = 0.5  # wall time between two looks for a subscriber [s]
LINES_PER_HELP = 15  # status lines after which the keys are listed again


def _number(name, default):
    value = rospy.get_param("~" + name, default)
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not value >= 0.0:
        raise ValueError(f"{name} is {value!r}, must be a number of 0 or more")
    return float(value)


def wait_for_subscriber(terminal, publisher):
    """Waits until somebody hears the commands.

    Returns:
        Whether somebody does; False when Ctrl-C came first.
    """
    looks = 0
    while not rospy.is_shutdown() and publisher.get_num_connections() == 0:
        if looks % 5 == 4:
            print(f"waiting for a subscriber of {publisher.resolved_name}")
        looks += 1
        if terminal.key(WAIT_PERIOD) in (QUIT, None):
            return False
    return not rospy.is_shutdown()


def drive(terminal, keys, sender, key_timeout):
    """Hands keys on until Ctrl-C or ROS ends it."""
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


def main():
    """Runs the node; returns 1 when a parameter is wrong or there is no terminal."""
    nodes.init_interruptible("teleop_twist_keyboard")
    try:
        keys = Keys(
            _number("speed", 0.5),
            _number("turn", 1.0),
            _number("speed_limit", 1000.0),
            _number("turn_limit", 1000.0),
        )
        key_timeout = _number("key_timeout", 0.5) or None
        repeat_rate = _number("repeat_rate", 0.0)
        terminal = Terminal(sys.stdin.fileno())
    except ValueError as error:
        rospy.logfatal("teleop_twist_keyboard: %s", error)
        return 1
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
    return 0
