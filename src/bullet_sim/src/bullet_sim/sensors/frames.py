"""Rotations and poses for the sensors.

A pose is (position (3,) [m], orientation quaternion (x, y, z, w)). `R` of frame B in frame A
turns a vector written in B into the same vector written in A.
"""
import numpy as np


def matrix_from_quaternion(quaternion):
    """Rotation matrix of a quaternion.

    Args:
        quaternion: (x, y, z, w), any positive length.

    Returns:
        (3, 3) float64.

    Raises:
        ValueError: the quaternion has length zero or is not finite.
    """
    q = np.asarray(quaternion, dtype=float)
    length = np.sqrt(q @ q)
    if not np.isfinite(length) or length < 1e-12:
        raise ValueError(f'orientation {tuple(quaternion)} is no rotation: '
                         'a quaternion (x, y, z, w) of length 1 is expected')
    x, y, z, w = q / length
    return np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])


def matrix_from_rpy(rpy):
    """Rotation matrix of URDF's fixed-axis roll, pitch, yaw: Rz(yaw) Ry(pitch) Rx(roll).

    Args:
        rpy: (roll, pitch, yaw) [rad].

    Returns:
        (3, 3) float64.
    """
    (cr, cp, cy), (sr, sp, sy) = np.cos(rpy), np.sin(rpy)
    return np.array([
        [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
        [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
        [-sp, cp * sr, cp * cr]])


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
