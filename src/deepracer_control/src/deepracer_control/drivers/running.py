"""Shared by the driver nodes: number parameters, the publisher of /cmd_vel, running the node."""

import sys
import threading
import time

import rospy
from geometry_msgs.msg import Twist

from deepracer_control import topics
from deepracer_control.drivers.units import Units


def number(name, default):
    """Returns a private parameter as a float.

    Raises:
        ValueError: It is not a number.
    """
    value = rospy.get_param("~" + name, default)
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise ValueError(f"parameter ~{name} is {value!r}; it must be a number")
    return float(value)


class CommandPublisher:
    """Publishes commands; at shutdown one zero, and nothing after it.

    Attributes:
        lock: Held while a command is computed and published.

    Raises:
        ValueError: The parameter ~mode is not valid.
    """

    def __init__(self):
        self._units = Units(mode=str(rospy.get_param("~mode", "ackermann")))
        self.lock, self._ended = threading.Lock(), False
        self._publisher = rospy.Publisher(topics.COMMANDED_DATA_TOPIC, Twist, queue_size=10)
        rospy.on_shutdown(self._stop)

    def send(self, speed, curvature):
        """Commands a speed [m/s] and a curvature [1/m]; call it with the lock held."""
        if not self._ended:
            self._publisher.publish(self._units.twist(speed, curvature))

    def _stop(self):
        """Publishes one zero and waits until it is sent."""
        with self.lock:
            self._ended = True
            self._publisher.publish(Twist())
        time.sleep(0.1)


def run(name, driver):
    """Runs a driver's node until ROS shuts down.

    Args:
        name: Of the node.
        driver: Class or function that connects, without arguments.
    """
    rospy.init_node(name)
    try:
        driver()
    except ValueError as error:
        rospy.logfatal("%s cannot start: %s", name, error)
        sys.exit(1)
    rospy.spin()
