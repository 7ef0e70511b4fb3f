"""Frames of messages: transforms from TF, rotations."""

import math
from typing import NamedTuple

import numpy as np
import rospy
import tf2_ros
from geometry_msgs.msg import Quaternion, TransformStamped, Vector3


def wrap(angle):
    """An angle within -pi..pi [rad]."""
    return math.remainder(angle, 2.0 * math.pi)


def matrix(roll, pitch, yaw):
    """(3, 3) rotation of three angles [rad]."""
    sr, cr = math.sin(roll), math.cos(roll)
    sp, cp = math.sin(pitch), math.cos(pitch)
    sy, cy = math.sin(yaw), math.cos(yaw)
    return np.array(
        (
            (cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr),
            (sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr),
            (-sp, cp * sr, cp * cr),
        )
    )


def angles(rotation):
    """Roll, pitch, yaw [rad] of a (3, 3) rotation; roll is 0 where only yaw - roll is defined."""
    sine = min(1.0, max(-1.0, -rotation[2, 0]))
    if abs(sine) > 1.0 - 1e-12:
        yaw = math.atan2(-rotation[0, 1], rotation[1, 1])
        return np.array((0.0, math.copysign(math.pi / 2.0, sine), yaw))
    return np.array(
        (
            math.atan2(rotation[2, 1], rotation[2, 2]),
            math.asin(sine),
            math.atan2(rotation[1, 0], rotation[0, 0]),
        )
    )


def from_quaternion(x, y, z, w):
    """(3, 3) rotation of a quaternion of any length; of none for a quaternion of zeros."""
    length = math.sqrt(x * x + y * y + z * z + w * w)
    if not length > 0.0:
        return np.eye(3)
    x, y, z, w = x / length, y / length, z / length, w / length
    return np.array(
        (
            (1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)),
            (2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)),
            (2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)),
        )
    )


def to_quaternion(rotation):
    """Quaternion (x, y, z, w) of a (3, 3) rotation."""
    return quaternion_from_angles(*angles(rotation).tolist())


def quaternion_from_angles(roll, pitch, yaw):
    """Quaternion (x, y, z, w) of three angles [rad]."""
    roll, pitch, yaw = 0.5 * roll, 0.5 * pitch, 0.5 * yaw
    sr, cr = math.sin(roll), math.cos(roll)
    sp, cp = math.sin(pitch), math.cos(pitch)
    sy, cy = math.sin(yaw), math.cos(yaw)
    return (
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
        cr * cp * cy + sr * sp * sy,
    )


class Transform(NamedTuple):
    """A rigid transform: the pose of a frame in another.

    Attributes:
        rotation: (3, 3).
        translation: (3,) [m].
    """

    rotation: np.ndarray
    translation: np.ndarray

    def of(self, other):
        """Pose in the parent of a pose `other` in this frame."""
        return Transform(
            self.rotation @ other.rotation, self.rotation @ other.translation + self.translation
        )

    def inverse(self):
        """The transform back."""
        back = self.rotation.T
        return Transform(back, -(back @ self.translation))


IDENTITY = Transform(np.eye(3), np.zeros(3))


def cross(a, b):
    """(3,) cross product; numpy's is slow for one pair."""
    return np.array(
        (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])
    )


def twice(rotation):
    """(6, 6) block matrix that rotates two vectors."""
    both = np.zeros((6, 6))
    both[:3, :3] = both[3:, 3:] = rotation
    return both


WARN_PERIOD = 5.0  # between two warnings about a frame [s]


def rotation_of(message):
    """(3, 3) rotation of a geometry_msgs/Quaternion."""
    return from_quaternion(message.x, message.y, message.z, message.w)


def vector(message):
    """(3,) array of a geometry_msgs/Point or Vector3."""
    return np.array((message.x, message.y, message.z))


def to_transform(position, orientation):
    """Transform of a geometry_msgs position (Point or Vector3) and Quaternion."""
    return Transform(rotation_of(orientation), vector(position))


def to_message(transform, parent, child, stamp):
    """geometry_msgs/TransformStamped of a Transform."""
    message = TransformStamped()
    message.header.frame_id, message.header.stamp = parent, stamp
    message.child_frame_id = child
    message.transform.translation = Vector3(*transform.translation)
    message.transform.rotation = Quaternion(*to_quaternion(transform.rotation))
    return message


class StaticFrames(tf2_ros.Buffer):
    """A buffer of frames that notices changes of the static ones.

    Attributes:
        on_change: Called when what was a static frame may be another from now on.
    """

    def __init__(self, on_change):
        super().__init__()
        self.on_change, self._children = on_change, set()

    def set_transform_static(self, transform, authority):
        super().set_transform_static(transform, authority)
        self._children.add(transform.child_frame_id.lstrip("/"))
        self.on_change()

    def set_transform(self, transform, authority):
        super().set_transform(transform, authority)
        if transform.child_frame_id.lstrip("/") in self._children:
            self.on_change()

    def clear(self):
        super().clear()
        self.on_change()


class Frames:
    """Looks up frames; those with static transforms alone only once.

    Args:
        timeout: Maximum wait for a frame [s].
    """

    def __init__(self, timeout=0.0):
        self._timeout = rospy.Duration(timeout)
        self._known = {}  # (target, source) -> Transform, of static transforms
        self._buffer = StaticFrames(self._forget)
        self._listener = tf2_ros.TransformListener(self._buffer)
        self._suppressed = bool(rospy.get_param("/silent_tf_failure", False))

    def clear(self):
        self._buffer.clear()

    def _forget(self):
        self._known = {}  # a new one: find() may be about to write to the old one

    def find(self, target, source, stamp):
        """The pose of a frame in another.

        Args:
            target: Name of the reference frame; a leading slash is ignored.
            source: Name of the frame; empty: the same.
            stamp: rospy.Time; if that time is unknown, the latest is used.

        Returns:
            Transform, or None with a warning. Of static transforms it is the same object each time.
        """
        target, source = target.lstrip("/"), source.lstrip("/")
        if target == source or not source:
            return IDENTITY
        known = self._known
        if (target, source) in known:
            return known[target, source]
        for time, timeout in ((stamp, self._timeout), (rospy.Time(), rospy.Duration())):
            try:
                transform = self._buffer.lookup_transform(target, source, time, timeout).transform
                latest = self._buffer.get_latest_common_time(target, source)
            except tf2_ros.TransformException as error:
                reason = str(error)
            else:
                found = to_transform(transform.translation, transform.rotation)
                if latest.is_zero():  # all transforms between the two are static
                    known[target, source] = found
                return found
        if not self._suppressed:
            rospy.logwarn_throttle(
                WARN_PERIOD, f"no transform from '{source}' to '{target}': {reason}"
            )
        return None
