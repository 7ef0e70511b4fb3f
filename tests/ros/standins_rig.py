"""What the stand-ins' tests share: a clock that a test sets, publishers that somebody hears."""

import contextlib
import threading
import time

import rospy
from geometry_msgs.msg import Twist
from rosgraph_msgs.msg import Clock
from sim_client import START_LIMIT, wait_connected, wait_until


class SetClock:
    """Publishes /clock again and again, as far as a test has set it."""

    def __init__(self):
        self.time = 10.0
        self._publisher = rospy.Publisher("/clock", Clock, queue_size=10)
        threading.Thread(target=self._repeat, daemon=True).start()
        wait_until(lambda: rospy.get_time() > 0.0, "the clock", START_LIMIT)

    def _repeat(self):
        while not rospy.is_shutdown():
            with contextlib.suppress(rospy.ROSException):  # closed at the end of the test
                self._publisher.publish(Clock(rospy.Time.from_sec(self.time)))
            time.sleep(0.02)


def publisher(topic, kind):
    """A publisher that somebody hears."""
    made = rospy.Publisher(topic, kind, queue_size=10)
    wait_connected(made, topic)
    return made


def twist(forward):
    """A command to drive ahead [m/s]."""
    message = Twist()
    message.linear.x = forward
    return message
