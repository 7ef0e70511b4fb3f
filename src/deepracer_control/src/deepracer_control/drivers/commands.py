"""Shared by the driver nodes: the publisher of /cmd_vel, which ends with a zero."""

import threading

import rospy
from geometry_msgs.msg import Twist
from paddock_common.sending import flush

from deepracer_control import topics
from deepracer_control.drivers.units import Units


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
        flush(self._publisher)
