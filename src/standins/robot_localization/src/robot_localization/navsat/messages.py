"""Messages of navsat_transform_node, made from an Alignment that is complete."""

import numpy as np
from geometry_msgs.msg import Point
from nav_msgs.msg import Odometry
from sensor_msgs.msg import NavSatFix, NavSatStatus


def fix_as_odometry(alignment, fix, world, position):
    """A fix in the world's frame.

    Args:
        alignment: Alignment.
        fix: NavSatFix, for its stamp and covariance.
        world: name of the frame.
        position: (3,) in it [m].
    """
    message = Odometry()
    message.header.stamp, message.header.frame_id = fix.header.stamp, world
    message.pose.pose.position = Point(*position.tolist())
    message.pose.pose.orientation.w = 1.0
    turn = alignment.grid_in_world.rotation
    covariance = np.zeros((6, 6))
    covariance[:3, :3] = turn @ np.array(fix.position_covariance, float).reshape(3, 3) @ turn.T
    message.pose.covariance = covariance.ravel().tolist()
    return message


def odometry_as_fix(alignment, odometry, robot, pose):
    """The robot's place on the earth.

    Args:
        alignment: Alignment.
        odometry: Odometry, for its stamp and covariance.
        robot: name of the robot's frame.
        pose: of the odometry, see to_transform.

    Raises:
        ValueError: it is beyond what the grid covers.
    """
    message = NavSatFix()
    message.header.stamp, message.header.frame_id = odometry.header.stamp, robot
    message.latitude, message.longitude, message.altitude = alignment.to_place(pose.translation)
    turn = alignment.grid_in_world.rotation.T
    covariance = np.array(odometry.pose.covariance, float).reshape(6, 6)[:3, :3]
    message.position_covariance = (turn @ covariance @ turn.T).ravel().tolist()
    message.position_covariance_type = NavSatFix.COVARIANCE_TYPE_KNOWN
    message.status.status = NavSatStatus.STATUS_GBAS_FIX
    return message
