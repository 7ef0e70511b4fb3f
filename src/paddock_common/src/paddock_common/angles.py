"""Headings of quaternions."""

import math


def yaw_of(quaternion):
    """Gives the heading [rad] of a quaternion with fields x, y, z, w (Z of Z-Y-X Euler angles)."""
    q = quaternion
    return math.atan2(2.0 * (q.w * q.z + q.x * q.y), 1.0 - 2.0 * (q.y * q.y + q.z * q.z))
