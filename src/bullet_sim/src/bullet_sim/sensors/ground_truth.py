"""True velocity of a link, as odometry wants it."""
import math


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
        (linear (3,) [m/s], angular (3,) [rad/s]), plain numbers.

    Raises:
        ValueError: the orientation has length zero or is not finite.
    """
    if not in_child:
        return tuple(map(float, linear_in_world)), tuple(map(float, angular_in_world))
    x, y, z, w = orientation
    square = x * x + y * y + z * z + w * w
    if not 1e-24 < square < math.inf:
        raise ValueError(f'orientation {tuple(orientation)} is no rotation: '
                         'a quaternion (x, y, z, w) of length 1 is expected')
    s = 2.0 / square
    # the rotation's transpose; plain numbers: numpy takes several times as long
    a, b, c = 1 - s * (y * y + z * z), s * (x * y + z * w), s * (x * z - y * w)
    d, e, f = s * (x * y - z * w), 1 - s * (x * x + z * z), s * (y * z + x * w)
    g, h, i = s * (x * z + y * w), s * (y * z - x * w), 1 - s * (x * x + y * y)
    (u, v, w), (p, q, r) = linear_in_world, angular_in_world
    return ((a * u + b * v + c * w, d * u + e * v + f * w, g * u + h * v + i * w),
            (a * p + b * q + c * r, d * p + e * q + f * r, g * p + h * q + i * r))

