"""The node `pure_pursuit`: the reference driver, from odometry and a path."""

import math

import rospy
from nav_msgs.msg import Odometry
from nav_msgs.msg import Path as PathMessage
from paddock_common.geometry import yaw_of
from paddock_common.nodes import run
from paddock_common.settings import Number, parameter

from deepracer_control.drivers.commands import CommandPublisher
from deepracer_control.drivers.pursuit import Path, Pursuit

REAR_AXLE = -0.081663  # x of the rear axle from base_link [m]


class PurePursuit:
    """Follows `path` (nav_msgs/Path, its frame is the odometry's) with /cmd_vel.

    Raises:
        ValueError: A parameter is not valid.
    """

    def __init__(self):
        self._limits = {
            name: rospy.get_param("~" + name, default)
            for name, default in (
                ("lookahead", 0.4),
                ("max_speed", 1.0),
                ("max_lateral_acceleration", 2.0),
            )
        }
        self._rear_axle = parameter(rospy.get_param, "rear_axle", REAR_AXLE, Number(unit="m"))
        Pursuit(Path([(0, 0), (1, 0), (2, 0)]), **self._limits)  # checks the limits
        self._commands, self._pursuit = CommandPublisher(), None
        rospy.Subscriber("path", PathMessage, self._on_path, queue_size=1)
        rospy.Subscriber("odom", Odometry, self._drive, queue_size=1)

    def _on_path(self, message):
        try:
            path = Path([(pose.pose.position.x, pose.pose.position.y) for pose in message.poses])
        except ValueError as error:
            rospy.logerr("pure_pursuit: path rejected: %s", error)
            return
        with self._commands.lock:
            self._pursuit = Pursuit(path, **self._limits)

    def _drive(self, message):
        with self._commands.lock:
            if self._pursuit is None:
                return
            position, yaw = message.pose.pose.position, yaw_of(message.pose.pose.orientation)
            if not all(map(math.isfinite, (position.x, position.y, yaw))):
                rospy.logerr_throttle(1.0, "pure_pursuit: odometry is not finite; the car stops")
                speed, curvature = 0.0, 0.0
            else:
                speed, curvature = self._pursuit.command(
                    position.x + self._rear_axle * math.cos(yaw),
                    position.y + self._rear_axle * math.sin(yaw),
                    yaw,
                )
            self._commands.send(speed, curvature)


def main():
    """Runs the node until ROS shuts down."""
    run("pure_pursuit", PurePursuit)
