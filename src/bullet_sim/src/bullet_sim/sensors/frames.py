"""Rotations and poses for the sensors.

A pose is (position (3,) [m], orientation quaternion (x, y, z, w)). `R` of frame B in frame A
turns a vector written in B into the same vector written in A.
"""

import math

import numpy as np


def rows_from_quaternion(quaternion):
    """Rotation matrix of a quaternion as three tuples: numpy is several times as slow.

    Args:
        quaternion: (x, y, z, w), any positive length.

    Returns:
        Its rows.

    Raises:
        ValueError: the quaternion has length zero or is not finite.
    """
    x, y, z, w = map(float, quaternion)
    square = x * x + y * y + z * z + w * w
    if not 1e-24 <= square < math.inf:
        raise ValueError(
            f"orientation {tuple(quaternion)} is no rotation: "
            "a quaternion (x, y, z, w) of length 1 is expected"
        )
    s = 2.0 / square
    return (
        (1 - s * (y * y + z * z), s * (x * y - z * w), s * (x * z + y * w)),
        (s * (x * y + z * w), 1 - s * (x * x + z * z), s * (y * z - x * w)),
        (s * (x * z - y * w), s * (y * z + x * w), 1 - s * (x * x + y * y)),
    )


def matrix_from_quaternion(quaternion):
    """As rows_from_quaternion, (3, 3) float64."""
    return np.array(rows_from_quaternion(quaternion))


def matrix_from_rpy(rpy):
    """Rotation matrix of URDF's fixed-axis roll, pitch, yaw: Rz(yaw) Ry(pitch) Rx(roll).

    Args:
        rpy: (roll, pitch, yaw) [rad].

    Returns:
        (3, 3) float64.
    """
    (cr, cp, cy), (sr, sp, sy) = np.cos(rpy), np.sin(rpy)
    return np.array(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
    )


def sensor_in_world(link_position, link_orientation, pose):
    """Pose of a sensor that is fixed to a link.

    Args:
        link_position: (3,) [m], the link frame's origin in the world.
        link_orientation: (x, y, z, w), link frame in the world.
        pose: (xyz (3,) [m], rpy (3,) [rad]), the sensor in the link frame.

    Returns:
        (position (3,) [m] in the world, R (3, 3) sensor frame in the world).
    """
    xyz, rpy = pose
    link = matrix_from_quaternion(link_orientation)
    position = np.asarray(link_position, dtype=float) + link @ np.asarray(xyz, dtype=float)
    return position, link @ matrix_from_rpy(rpy)
