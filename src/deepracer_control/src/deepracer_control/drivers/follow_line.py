"""The node `follow_line`: follows the dashed center line with the camera alone."""

import math

import rospy
from cv_bridge import CvBridge, CvBridgeError
from paddock_common.nodes import run
from paddock_common.settings import Number
from sensor_msgs.msg import CameraInfo, Image

from deepracer_control import topics
from deepracer_control.drivers.commands import CommandPublisher
from deepracer_control.drivers.line_vision import vision_from
from deepracer_control.drivers.pursuit import arc_curvature


class LineFollower:
    """Line follower: images -> commands. No ROS.

    Args:
        speed: Speed on straights [m/s].
        grip: Lateral acceleration [m/s^2] that lowers the speed in bends.
        timeout: Time [s] for which the last curvature is used when the line is not visible.
    """

    def __init__(self, vision, speed=0.6, grip=0.8, timeout=1.0):
        for name, value in (("speed", speed), ("grip", grip), ("patience", timeout)):
            Number(above=0.0).check(name, value)
        self.vision, self.speed, self.grip, self.timeout = vision, speed, grip, timeout
        self._curvature, self._last_detection = 0.0, None

    def command(self, time, image, matrix):
        """Returns (speed [m/s], curvature [1/m]) for an image taken at a time [s]."""
        if self._last_detection is not None and time < self._last_detection:
            self._last_detection = None  # the simulation was reset
            self.vision.restart()
        goal = self.vision.find_goal(image, matrix)
        if goal is not None:
            self._last_detection, self._curvature = time, arc_curvature(*goal)
        elif self._last_detection is None or time - self._last_detection > self.timeout:
            return 0.0, 0.0
        limit = math.sqrt(self.grip / max(abs(self._curvature), 1e-6))
        return min(self.speed, limit), self._curvature


class FollowLine:
    """Subscribes camera and camera_info, publishes /cmd_vel once per image.

    Raises:
        ValueError: A parameter is not valid.
    """

    def __init__(self):
        get = rospy.get_param
        self._follower = LineFollower(
            vision_from(get, lookahead=0.55),
            get("~speed", 0.6),
            get("~grip", 0.8),
            get("~patience", 1.0),
        )
        self._commands, self._bridge = CommandPublisher(), CvBridge()
        self._matrix = None
        rospy.Subscriber("camera_info", CameraInfo, self._on_camera_info, queue_size=1)
        rospy.Subscriber(topics.CAMERA_TOPIC, Image, self._drive, queue_size=1, buff_size=2**24)

    def _on_camera_info(self, message):
        if message.K[0] <= 0.0 or message.K[4] <= 0.0:
            rospy.logerr_throttle(
                5.0,
                "follow_line: camera_info has focal lengths "
                f"{message.K[0]}, {message.K[4]}; they must be above 0",
            )
            return
        self._matrix = tuple(message.K)

    def _drive(self, message):
        if self._matrix is None:
            return
        try:
            image = self._bridge.imgmsg_to_cv2(message, "bgr8")
        except CvBridgeError as error:
            rospy.logerr_throttle(5.0, f"follow_line: image rejected: {error}")
            return
        with self._commands.lock:
            self._commands.send(
                *self._follower.command(message.header.stamp.to_sec(), image, self._matrix)
            )


def main():
    """Runs the node until ROS shuts down."""
    run("follow_line", FollowLine)
