"""What the driver nodes share: the last word on /cmd_vel."""

import threading
import time

import rospy
from geometry_msgs.msg import Twist

from deepracer_control import topics
from deepracer_control.drivers.units import Units


class Wheel:
    """Sends commands until the node ends; then one zero and nothing more.

    Attributes:
        lock: Held while a command is worked out and sent.

    Raises:
        ValueError: The parameter ~mode is not valid.
    """

    def __init__(self):
        self._units = Units(mode=str(rospy.get_param("~mode", "ackermann")))
        self.lock, self._over = threading.Lock(), False
        self._publisher = rospy.Publisher(topics.COMMANDED_DATA_TOPIC, Twist, queue_size=10)
        rospy.on_shutdown(self._stop)

    def send(self, speed, curvature):
        """Commands a speed [m/s] and a curvature [1/m]; call it with the lock held."""
        if not self._over:
            self._publisher.publish(self._units.twist(speed, curvature))

    def _stop(self):
        """One zero, then silence; waits until it is on its way."""
        with self.lock:
            self._over = True
            self._publisher.publish(Twist())
        time.sleep(0.1)
