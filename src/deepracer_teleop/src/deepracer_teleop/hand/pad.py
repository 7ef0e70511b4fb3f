"""A game pad on PAD_TOPIC: the left stick drives and steers, any button stops."""

import math

import rospy
from deepracer_control.topics import PAD_TOPIC
from PyQt5.QtCore import QObject, Qt, pyqtSignal
from sensor_msgs.msg import Joy

from deepracer_teleop.camera.latest import LatestValue

STEERING_AXIS, SPEED_AXIS = 0, 1  # left and up are positive
DEAD_ZONE = 0.1  # of the stick's way that counts as its middle


def deflection(value):
    """Returns -1..1 from an axis, 0 in the middle; the rest of the way is stretched.

    What is no finite number counts as the middle.
    """
    if not math.isfinite(value):
        return 0.0
    size = max(0.0, min(1.0, abs(value)) - DEAD_ZONE) / (1.0 - DEAD_ZONE)
    return size if value > 0.0 else -size


class Pad(QObject):
    """Follows the pad, if there is one.

    Attributes:
        present: Whether somebody publishes PAD_TOPIC.
    """

    moved = pyqtSignal(float, float)  # speed, steering: -1..1, right is positive; on a change
    stopped = pyqtSignal()
    _arrived = pyqtSignal()  # from the subscriber's thread to Qt's

    def __init__(self, parent):
        """Prepares; start() subscribes.

        Args:
            parent: Qt parent.
        """
        super().__init__(parent)
        self.present = False
        self._latest, self._subscriber = LatestValue(), None
        self._shares, self._pressed, self._latched = (0.0, 0.0), False, False
        self._arrived.connect(self._follow, Qt.QueuedConnection)

    def start(self):
        """Subscribes."""
        self._subscriber = rospy.Subscriber(PAD_TOPIC, Joy, self.callback, queue_size=5)

    def stop(self):
        """Unsubscribes."""
        if self._subscriber is not None:
            self._subscriber.unregister()
            self._subscriber = None

    def clear(self):
        """Lets the stick count again only after it was in its middle. Emits nothing."""
        self._latched = self._latched or self._shares != (0.0, 0.0)
        self._shares = (0.0, 0.0)

    def check(self):
        """Lets go of the stick when nobody publishes any more."""
        self.present = self._subscriber is not None and self._subscriber.get_num_connections() > 0
        if not self.present:
            self._move((0.0, 0.0))

    def callback(self, message):
        """Stores a Joy message; runs in the subscriber's thread."""
        if self._latest.put(message):
            self._arrived.emit()

    def _follow(self):
        message = self._latest.take()
        if message is None or len(message.axes) <= max(STEERING_AXIS, SPEED_AXIS):
            return
        pressed = any(message.buttons)
        if pressed and not self._pressed:
            self.clear()
            self.stopped.emit()
        self._pressed = pressed
        self._move((deflection(message.axes[SPEED_AXIS]), deflection(-message.axes[STEERING_AXIS])))

    def _move(self, shares):
        if self._latched:
            self._latched = shares != (0.0, 0.0)
        elif shares != self._shares:
            self._shares = shares
            self.moved.emit(*shares)
