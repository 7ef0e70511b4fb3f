"""True velocity of a link, as odometry wants it."""
import math

import numpy as np


def twist(orientation, linear_in_world, angular_in_world, in_child=True):
    """Twist of a link in the axes an Odometry message asks for.

    nav_msgs/Odometry: the twist is in the child frame. Gazebo's p3d plugin leaves it in the
    world's axes; that is in_child=False.

    Args:
        orientation: (x, y, z, w), link frame in the world.
        linear_in_world: (3,) [m/s], of the link frame's origin, in world axes.
        angular_in_world: (3,) [rad/s], in world axes.
        in_child: write both in the link's axes.

    Returns:
        (linear (3,) [m/s], angular (3,) [rad/s]) float64.

    Raises:
        ValueError: the orientation has length zero or is not finite.
    """
    if not in_child:
        return np.array(linear_in_world, dtype=float), np.array(angular_in_world, dtype=float)
    x, y, z, w = orientation
    square = x * x + y * y + z * z + w * w
    if not 1e-24 < square < math.inf:
        raise ValueError(f'orientation {tuple(orientation)} is no rotation: '
                         'a quaternion (x, y, z, w) of length 1 is expected')
    s = 2.0 / square
    # rows of the rotation's transpose; plain numbers: numpy takes three times as long
    rows = ((1 - s * (y * y + z * z), s * (x * y + z * w), s * (x * z - y * w)),
            (s * (x * y - z * w), 1 - s * (x * x + z * z), s * (y * z + x * w)),
            (s * (x * z + y * w), s * (y * z - x * w), 1 - s * (x * x + y * y)))
    return tuple(np.array([a * u + b * v + c * t for a, b, c in rows])
                 for u, v, t in (linear_in_world, angular_in_world))

