"""True velocity of a link in the axes of an Odometry message."""

from bullet_sim.sensors.frames import rows_from_quaternion


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
    (a, d, g), (b, e, h), (c, f, i) = rows_from_quaternion(orientation)  # its transpose
    (u, v, w), (p, q, r) = linear_in_world, angular_in_world
    return (
        (a * u + b * v + c * w, d * u + e * v + f * w, g * u + h * v + i * w),
        (a * p + b * q + c * r, d * p + e * q + f * r, g * p + h * q + i * r),
    )
