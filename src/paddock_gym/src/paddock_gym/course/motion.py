"""Pose and velocity of a car as numbers of the plane."""

import math
from typing import NamedTuple


class Motion(NamedTuple):
    """Motion of base_link in the track's frame.

    Attributes:
        x, y: [m].
        yaw: [rad].
        forward, leftward: velocity along the car's own axes [m/s].
        yaw_rate: [rad/s].
    """

    x: float
    y: float
    yaw: float
    forward: float
    leftward: float
    yaw_rate: float


def motion_from(position, quaternion, linear, angular):
    """Motion of a link from its state in the world.

    Args:
        position: (3,) [m].
        quaternion: (x, y, z, w).
        linear, angular: (3,) [m/s], [rad/s], along the world's axes.

    Returns:
        Motion, its velocities along the link's axes as in nav_msgs/Odometry.
    """
    x, y, z, w = quaternion
    u, v, up = linear
    return Motion(
        position[0],
        position[1],
        math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z)),
        (1.0 - 2.0 * (y * y + z * z)) * u + 2.0 * (x * y + z * w) * v + 2.0 * (x * z - y * w) * up,
        2.0 * (x * y - z * w) * u + (1.0 - 2.0 * (x * x + z * z)) * v + 2.0 * (y * z + x * w) * up,
        angular[2],
    )
