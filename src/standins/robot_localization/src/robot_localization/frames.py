"""Frames of tf: looked up, or not there."""

import numpy as np
import rospy
import tf2_ros
from geometry_msgs.msg import Quaternion, TransformStamped, Vector3

from robot_localization.rotation import IDENTITY, Transform, from_quaternion, to_quaternion

WARN_PERIOD = 5.0  # between two warnings about a frame [s]


def to_transform(position, orientation):
    """Transform of a geometry_msgs position (Point or Vector3) and Quaternion."""
    return Transform(
        from_quaternion(orientation.x, orientation.y, orientation.z, orientation.w),
        np.array((position.x, position.y, position.z)),
    )


def to_message(transform, parent, child, stamp):
    """geometry_msgs/TransformStamped of a Transform."""
    message = TransformStamped()
    message.header.frame_id, message.header.stamp = parent, stamp
    message.child_frame_id = child
    message.transform.translation = Vector3(*transform.translation)
    message.transform.rotation = Quaternion(*to_quaternion(transform.rotation))
    return message


class Frames:
    """Looks frames up.

    Args:
        timeout: Longest wait for a frame [s].
    """

    def __init__(self, timeout=0.0):
        self._timeout = rospy.Duration(timeout)
        self._buffer = tf2_ros.Buffer()
        self._listener = tf2_ros.TransformListener(self._buffer)
        self._silent = bool(rospy.get_param("/silent_tf_failure", False))

    def clear(self):
        """Forgets all frames."""
        self._buffer.clear()

    def find(self, target, source, stamp):
        """The pose of a frame in another.

        Args:
            target: Name of the frame that it is given in; a leading slash counts for nothing.
            source: Name of the frame; empty: the same.
            stamp: rospy.Time; where nothing is known of that time, the latest is taken.

        Returns:
            Transform, or None with a warning.
        """
        target, source = target.lstrip("/"), source.lstrip("/")
        if target == source or not source:
            return IDENTITY
        for time, timeout in ((stamp, self._timeout), (rospy.Time(), rospy.Duration())):
            try:
                found = self._buffer.lookup_transform(target, source, time, timeout).transform
            except tf2_ros.TransformException as error:
                reason = str(error)
            else:
                return to_transform(found.translation, found.rotation)
        if not self._silent:
            rospy.logwarn_throttle(
                WARN_PERIOD, f"no transform from '{source}' to '{target}': {reason}"
            )
        return None
