"""Messages <-> input and output of the odometry."""

import math

from geometry_msgs.msg import Quaternion
from nav_msgs.msg import Odometry

from cybertruck.drive.odometry import Measured

WHEELS = ("rear_left_wheel_joint", "rear_right_wheel_joint")
HINGES = ("front_left_steer_joint", "front_right_steer_joint")
ENCODERS = ("front_left_wheel_joint", "front_right_wheel_joint")
PLANAR_VARIANCE = 1e-6  # variance of height, roll and pitch, which are 0 on flat ground


def measured(message):
    """Odometry's input from a sensor_msgs/JointState.

    Returns:
        (Measured, dict of front wheel joint -> angle [rad]).

    Raises:
        ValueError: a joint is missing or a number is not finite.
    """
    index = {name: i for i, name in enumerate(message.name)}
    missing = [name for name in WHEELS + HINGES + ENCODERS if name not in index]
    if missing:
        raise ValueError(
            f"joint '{missing[0]}' is missing; there are {', '.join(message.name) or '(none)'}"
        )
    count = len(message.name)
    if len(message.position) != count or len(message.velocity) != count:
        raise ValueError(
            f"{len(message.position)} positions and {len(message.velocity)} "
            f"velocities for {count} joints, must be as many"
        )
    values = [message.position[index[name]] for name in WHEELS + HINGES]
    values += [message.velocity[index[name]] for name in WHEELS]
    encoders = {name: message.position[index[name]] for name in ENCODERS}
    for value in values + list(encoders.values()):
        if not math.isfinite(value):
            raise ValueError(f"a position or velocity is {value}, must be finite")
    return Measured(*values), encoders


def quaternion(yaw):
    """Heading [rad] as a geometry_msgs/Quaternion."""
    return Quaternion(0.0, 0.0, math.sin(yaw / 2.0), math.cos(yaw / 2.0))


def odometry(stamp, frames, state):
    """nav_msgs/Odometry of a WheelOdometry; the twist is in the child frame (REP-105).

    Args:
        stamp: rospy.Time.
        frames: (odometry frame, base frame).
        state: WheelOdometry.
    """
    message = Odometry()
    message.header.stamp = stamp
    message.header.frame_id, message.child_frame_id = frames
    message.pose.pose.position.x, message.pose.pose.position.y = state.x, state.y
    message.pose.pose.orientation = quaternion(state.yaw)
    pose, twist = [0.0] * 36, [0.0] * 36
    rows = (0, 1, 5)  # x, y, yaw of the 6 by 6 matrix
    for i, row in enumerate(rows):
        for j, column in enumerate(rows):
            pose[6 * row + column] = float(state.covariance[i, j])
    twist[0], twist[35] = state.twist_variances()
    for axis in (2, 3, 4):
        pose[7 * axis] = PLANAR_VARIANCE
    for axis in (1, 2, 3, 4):
        twist[7 * axis] = PLANAR_VARIANCE
    message.pose.covariance, message.twist.covariance = pose, twist
    message.twist.twist.linear.x = state.speed
    message.twist.twist.angular.z = state.yaw_rate
    return message
