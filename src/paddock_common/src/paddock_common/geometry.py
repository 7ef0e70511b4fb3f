"""Yaw angles and quaternions, transforms of odometry messages."""

from __future__ import annotations

import math
from typing import Any

from geometry_msgs.msg import Point, Pose, Quaternion, TransformStamped


def yaw_of(quaternion: Any) -> float:
    """Returns the yaw [rad] of a quaternion with fields x, y, z, w (Z of Z-Y-X Euler angles)."""
    q = quaternion
    return math.atan2(2.0 * (q.w * q.z + q.x * q.y), 1.0 - 2.0 * (q.y * q.y + q.z * q.z))


def quaternion_of(yaw: float) -> Quaternion:
    """Returns the geometry_msgs/Quaternion of a yaw angle [rad]."""
    return Quaternion(0.0, 0.0, math.sin(yaw / 2.0), math.cos(yaw / 2.0))


def planar_of(pose: Any) -> tuple[float, float, float]:
    """Returns x, y [m] and yaw [rad] of a geometry_msgs/Pose."""
    return pose.position.x, pose.position.y, yaw_of(pose.orientation)


def pose_of(x: float, y: float, yaw: float = 0.0, z: float = 0.0) -> Pose:
    """Returns the geometry_msgs/Pose of a place [m] and a yaw angle [rad]."""
    return Pose(Point(float(x), float(y), float(z)), quaternion_of(yaw))


def transform_of(message: Any) -> TransformStamped:
    """Returns the geometry_msgs/TransformStamped that a nav_msgs/Odometry contains."""
    transform = TransformStamped(header=message.header, child_frame_id=message.child_frame_id)
    position = message.pose.pose.position
    transform.transform.translation.x = position.x
    transform.transform.translation.y = position.y
    transform.transform.translation.z = position.z
    transform.transform.rotation = message.pose.pose.orientation
    return transform
