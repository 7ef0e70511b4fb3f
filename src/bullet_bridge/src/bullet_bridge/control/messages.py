"""States of controllers -> ROS messages."""

import math

import rospy
from control_msgs.msg import JointControllerState, PidState
from four_wheel_steering_msgs.msg import FourWheelSteeringStamped
from geometry_msgs.msg import TwistStamped
from nav_msgs.msg import Odometry

from bullet_bridge.transport.conversions import stamp


def controller_state(time, sample, gains):
    """control_msgs/JointControllerState of a Sample and PidGains; `time` [s] of the sample."""
    message = JointControllerState(
        set_point=sample.set_point,
        process_value=sample.process_value,
        process_value_dot=sample.process_value_dot,
        error=sample.error,
        time_step=sample.period,
        command=sample.command,
        p=gains.p,
        i=gains.i,
        d=gains.d,
        i_clamp=gains.i_clamp_max,
        antiwindup=gains.antiwindup,
    )
    message.header.stamp = stamp(time)
    return message


def pid_state(time, period, pid):
    """control_msgs/PidState of a Pid; `time` and `period` [s] of its last computation."""
    message = PidState(
        timestep=rospy.Duration.from_sec(period),
        error=pid.error,
        error_dot=pid.error_rate,
        p_error=pid.error,
        i_error=pid.integral,
        d_error=pid.error_rate,
        p_term=pid.terms[0],
        i_term=pid.terms[1],
        d_term=pid.terms[2],
        i_max=pid.gains.i_clamp_max,
        i_min=pid.gains.i_clamp_min,
        output=pid.output,
    )
    message.header.stamp = stamp(time)
    return message


def drive_odometry(time, drive, odometry):
    """nav_msgs/Odometry of a DriveConfig and an Odometry; the twist is in the base's frame."""
    message = Odometry(child_frame_id=drive.base_frame)
    message.header.stamp, message.header.frame_id = stamp(time), drive.odom_frame
    position, orientation = message.pose.pose.position, message.pose.pose.orientation
    position.x, position.y = odometry.x, odometry.y
    orientation.z, orientation.w = math.sin(odometry.heading / 2), math.cos(odometry.heading / 2)
    message.twist.twist.linear.x = odometry.linear
    message.twist.twist.linear.y = odometry.lateral
    message.twist.twist.angular.z = odometry.angular
    message.pose.covariance = _diagonal(drive.pose_covariance)
    message.twist.covariance = _diagonal(drive.twist_covariance)
    return message


def four_wheel_state(time, frame, odometry):
    """four_wheel_steering_msgs/FourWheelSteeringStamped of a FourWheelOdometry."""
    message = FourWheelSteeringStamped()
    message.header.stamp, message.header.frame_id = stamp(time), frame
    data = message.data
    data.speed, data.acceleration, data.jerk = (
        odometry.speed,
        odometry.acceleration,
        odometry.jerk,
    )
    data.front_steering_angle, data.rear_steering_angle = odometry.angles
    data.front_steering_angle_velocity, data.rear_steering_angle_velocity = odometry.rates
    return message


def _diagonal(values):
    matrix = [0.0] * 36
    matrix[::7] = values
    return matrix


def limited_twist(time, linear, angular):
    """geometry_msgs/TwistStamped of a limited command."""
    message = TwistStamped()
    message.header.stamp = stamp(time)
    message.twist.linear.x, message.twist.angular.z = linear, angular
    return message
