"""Speed and curvature -> Twist for the car's control, in either mode."""

import math
from dataclasses import dataclass

from geometry_msgs.msg import Twist
from paddock_common.settings import check, choice

from deepracer_control.ackermann import Geometry
from deepracer_control.control import DEGREES_PER_UNIT, MODES


@dataclass(frozen=True)
class Units:
    """Units of /cmd_vel.

    Attributes:
        mode: "original" or "ackermann", as control's parameter.
        geometry: The car's Geometry.
    """

    mode: str = choice("ackermann", MODES)
    geometry: Geometry = Geometry()

    def __post_init__(self):
        check(self)

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
