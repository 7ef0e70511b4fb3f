"""The estimate as messages."""

import numpy as np
from geometry_msgs.msg import AccelWithCovarianceStamped, Point, Quaternion, Vector3
from nav_msgs.msg import Odometry

from robot_localization.estimate.state import ACCELERATION, ANGLES, POSE, POSITION, RATES, TWIST
from robot_localization.rotation import Transform, matrix, to_quaternion


def pose(ekf):
    """Transform: the robot in the world."""
    return Transform(matrix(*ekf.state[ANGLES]), ekf.state[POSITION].copy())


def odometry(ekf, world, robot, stamp):
    """nav_msgs/Odometry of an Ekf."""
    message = Odometry()
    message.header.frame_id, message.header.stamp = world, stamp
    message.child_frame_id = robot
    here, speeds = pose(ekf), ekf.state[TWIST].tolist()
    message.pose.pose.position = Point(*here.translation.tolist())
    message.pose.pose.orientation = Quaternion(*to_quaternion(here.rotation))
    message.pose.covariance = ekf.covariance[POSE, POSE].ravel().tolist()
    message.twist.twist.linear, message.twist.twist.angular = (
        Vector3(*speeds[:3]),
        Vector3(*speeds[3:]),
    )
    message.twist.covariance = ekf.covariance[TWIST, TWIST].ravel().tolist()
    return message


def acceleration(ekf, robot, stamp, rates_change, step):
    """geometry_msgs/AccelWithCovarianceStamped of an Ekf.

    Args:
        ekf: Ekf.
        robot: Name of its frame.
        stamp: rospy.Time.
        rates_change: (3,) change of the turn rates [rad/s^2].
        step: Time between the two rates that it is made of [s].
    """
    message = AccelWithCovarianceStamped()
    message.header.frame_id, message.header.stamp = robot, stamp
    message.accel.accel.linear = Vector3(*ekf.state[ACCELERATION].tolist())
    message.accel.accel.angular = Vector3(*rates_change.tolist())
    covariance = np.zeros((6, 6))
    covariance[:3, :3] = ekf.covariance[ACCELERATION, ACCELERATION]
    covariance[3:, 3:] = 2.0 * ekf.covariance[RATES, RATES] / step**2
    message.accel.covariance = covariance.ravel().tolist()
    return message
