"""The node `policy_driver`: drives the car by a policy that was trained in the gym."""

import math

import numpy as np
import rospy
from cv_bridge import CvBridge, CvBridgeError
from deepracer_control.ackermann import Geometry
from deepracer_control.drivers.commands import CommandPublisher
from nav_msgs.msg import Odometry
from paddock_common.geometry import planar_of
from paddock_common.nodes import run
from sensor_msgs.msg import Image, LaserScan
from track_model.referee.course import Course
from track_model.track import load_track

from deepracer_control import topics
from paddock_gym.course import Motion
from paddock_gym.observations import Assembler, select_rays
from paddock_gym.policy.onnx_policy import OnnxPolicy

EARLY = 0.1  # fraction of the control period by which a message may be early


class PolicyNode:
    """Subscribes to the policy's observations, publishes /cmd_vel at the rate of its training.

    Images trigger the actions if the policy needs them, else odometry, else scans.

    Raises:
        ValueError: A parameter, the policy or the track is not valid.
    """

    def __init__(self):
        self._policy = OnnxPolicy(str(rospy.get_param("~policy")))
        self._about = self._policy.description
        names = self._about.observations
        if self._about.race != "time_trial":
            raise ValueError(
                f"the policy was trained for {self._about.race}; the car has no sensor for the "
                "objects that it expects, it must be time_trial"
            )
        course = None
        if "state" in names:
            track = load_track(str(rospy.get_param("~track", "default")))
            course = Course(track.lane)
        self._assembler = Assembler(names, self._about.colour, course)
        self._commands, self._bridge = CommandPublisher(), CvBridge()
        self._wheelbase, self._last, self._due = Geometry().wheelbase, (0.0, 0.0), None
        self._rays = self._scan_shape = None
        trigger = next(name for name in ("camera", "state", "lidar") if name in names)
        for name, topic, message_type, receive in (
            ("state", "odom", Odometry, self._on_odometry),
            ("lidar", "scan", LaserScan, self._on_scan),
            ("camera", topics.CAMERA_TOPIC, Image, self._on_image),
        ):
            if name in names:
                rospy.Subscriber(
                    topic, message_type, self._receiver(receive, name == trigger), queue_size=1,
                    buff_size=2**24,
                )  # fmt: skip

    def _receiver(self, receive, acts):
        def callback(message):
            with self._commands.lock:
                if receive(message) and acts:
                    self._act(message.header.stamp.to_sec())

        return callback

    def _on_odometry(self, message):
        pose, twist = message.pose.pose, message.twist.twist
        motion = Motion(*planar_of(pose), twist.linear.x, twist.linear.y, twist.angular.z)
        if not all(map(math.isfinite, motion)):
            rospy.logerr_throttle(1.0, "policy_driver: odometry is not finite; it is skipped")
            return False
        self._assembler.set_motion(motion)
        return True

    def _on_scan(self, message):
        shape = (message.angle_min, message.angle_increment, len(message.ranges))
        if shape != self._scan_shape:
            try:
                self._rays, self._scan_shape = select_rays(*shape), shape
            except ValueError as error:
                rospy.logerr_throttle(5.0, f"policy_driver: scan refused: {error}")
                return False
        self._assembler.set_ranges(np.asarray(message.ranges)[self._rays])
        return True

    def _on_image(self, message):
        try:
            self._assembler.set_image(self._bridge.imgmsg_to_cv2(message, "rgb8"))
        except CvBridgeError as error:
            rospy.logerr_throttle(5.0, f"policy_driver: image refused: {error}")
            return False
        return True

    def _act(self, stamp):
        """Acts if a control period has passed.

        Args:
            stamp: of the newest message [s].
        """
        period = 1.0 / self._about.control_rate
        if self._due is not None and self._due - 2.0 * period < stamp < self._due - EARLY * period:
            return
        observation = self._assembler.observe(self._last)
        if observation is None:
            return
        late = self._due is None or not -period < stamp - self._due < period
        self._due = (stamp if late else self._due) + period
        self._last = self._policy.command(observation)
        speed, steering = self._last
        self._commands.send(speed, math.tan(steering) / self._wheelbase)


def main():
    """Runs the node until ROS shuts down."""
    run("policy_driver", PolicyNode)
