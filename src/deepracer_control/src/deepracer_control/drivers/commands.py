"""Commands of a driver: conversion from m/s to the car's units, and publishing."""

import math
import threading
from dataclasses import dataclass

import rospy
from geometry_msgs.msg import Twist
from paddock_common.settings import Checked, choice
from paddock_common.waiting import flush

from deepracer_control import topics
from deepracer_control.ackermann import Geometry
from deepracer_control.control import DEGREES_PER_UNIT, MODES


@dataclass(frozen=True)
class Units(Checked):
    """Units of /cmd_vel.

    Attributes:
        mode: "original" or "ackermann", as control's parameter.
        geometry: The car's Geometry.
    """

    mode: str = choice("ackermann", MODES)
    geometry: Geometry = Geometry()

    def steering(self, curvature):
        """Returns the bicycle's steering angle [rad] for a curvature [1/m], within the limit."""
        limit = self.geometry.max_steering
        return max(-limit, min(limit, math.atan(self.geometry.wheelbase * curvature)))

    def twist(self, speed, curvature):
        """Returns the Twist for a speed [m/s] and a curvature [1/m, left positive]."""
        angle = self.steering(curvature)
        message = Twist()
        if self.mode == "ackermann":
            message.linear.x = speed
            message.angular.z = speed * math.tan(angle) / self.geometry.wheelbase
        else:
            message.linear.x = speed / self.geometry.wheel_radius
            message.angular.z = -math.degrees(angle) / DEGREES_PER_UNIT
        return message


class CommandPublisher:
    """Publishes commands; at shutdown one zero command, and none after it.

    Attributes:
        lock: To be acquired while a command is computed and published.

    Raises:
        ValueError: The parameter ~mode is not valid.
    """

    def __init__(self):
        self._units = Units(mode=str(rospy.get_param("~mode", "ackermann")))
        self.lock, self._closed = threading.Lock(), False
        self._publisher = rospy.Publisher(topics.COMMANDED_DATA_TOPIC, Twist, queue_size=10)
        rospy.on_shutdown(self._stop)

    def send(self, speed, curvature):
        """Commands a speed [m/s] and a curvature [1/m]; call it with the lock acquired."""
        if not self._closed:
            self._publisher.publish(self._units.twist(speed, curvature))

    def _stop(self):
        """Publishes one zero command and waits until it is sent."""
        with self.lock:
            self._closed = True
            self._publisher.publish(Twist())
        flush(self._publisher)
