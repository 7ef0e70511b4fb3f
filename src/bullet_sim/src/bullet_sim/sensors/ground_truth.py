"""True velocity of a link, as odometry wants it."""
import numpy as np

from bullet_sim.sensors.frames import matrix_from_quaternion


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
    """
    linear = np.asarray(linear_in_world, dtype=float)
    angular = np.asarray(angular_in_world, dtype=float)
    if not in_child:
        return linear, angular
    to_link = matrix_from_quaternion(orientation).T
    return to_link @ linear, to_link @ angular


def velocity_at(offset_in_world, linear_in_world, angular_in_world):
    """Velocity of another point of the same rigid body: v + w x r.

    Args:
        offset_in_world: (3,) [m], from the point that moves with linear_in_world, world axes.
        linear_in_world: (3,) [m/s].
        angular_in_world: (3,) [rad/s].

    Returns:
        (3,) [m/s] in world axes.
    """
    return np.asarray(linear_in_world, dtype=float) + np.cross(angular_in_world, offset_in_world)
