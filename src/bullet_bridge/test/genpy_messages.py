"""Messages as genpy builds them: the measure of the packed ones."""

from bullet_bridge.transport import conversions
from bullet_sim.sensors import camera
from geometry_msgs.msg import Quaternion, Vector3
from nav_msgs.msg import Odometry
from sensor_msgs.msg import Image, Imu, JointState, LaserScan


def joint_state(time, names, positions, velocities, efforts):
    """sensor_msgs/JointState from names and three (n,) arrays."""
    message = JointState(
        name=list(names),
        position=positions.tolist(),
        velocity=velocities.tolist(),
        effort=efforts.tolist(),
    )
    message.header.stamp = conversions.stamp(time)
    return message


def odometry(time, spec, pose, linear, angular):
    """nav_msgs/Odometry of a GroundTruthSpec; covariances hold the square of its noise."""
    message = Odometry(child_frame_id=spec.child_frame_id)
    message.header.stamp, message.header.frame_id = conversions.stamp(time), spec.frame_id
    message.pose.pose = conversions.pose_to_msg(pose)
    message.twist.twist = conversions.twist_to_msg(linear, angular)
    for covariance in (message.pose.covariance, message.twist.covariance):
        covariance[::7] = [spec.noise_stddev**2] * 6
    return message


def imu(time, spec, orientation, rate, force):
    """sensor_msgs/Imu of an ImuSpec; orientation (x, y, z, w), [rad/s], [m/s^2]."""
    message = Imu(header=conversions.header(time, spec.frame_id))
    message.orientation = Quaternion(*orientation)
    message.angular_velocity, message.linear_acceleration = Vector3(*rate), Vector3(*force)
    for covariance in (
        message.orientation_covariance,
        message.angular_velocity_covariance,
        message.linear_acceleration_covariance,
    ):
        covariance[::4] = [spec.variance] * 3
    return message


def image(time, frame_id, rgb, encoding="rgb8"):
    """sensor_msgs/Image of an (H, W, 3) uint8 array, as rgb8, bgr8 or mono8 (Rec. 601 luma)."""
    height, width = rgb.shape[:2]
    rgb = camera.pixels(rgb, encoding)
    message = Image(
        height=height,
        width=width,
        encoding=encoding,
        step=width * (1 if encoding == "mono8" else 3),
        data=rgb.tobytes(),
    )
    message.header.stamp, message.header.frame_id = conversions.stamp(time), frame_id
    return message


def laser_scan(time, spec, increment, ranges):
    """sensor_msgs/LaserScan of a RaySpec and ranges (n,) [m]; all rays at one time."""
    message = LaserScan(
        angle_min=spec.min_angle,
        angle_max=spec.max_angle,
        angle_increment=increment,
        range_min=spec.range_min,
        range_max=spec.range_max,
        ranges=ranges.tolist(),
        intensities=[0.0] * len(ranges),
    )
    message.header.stamp, message.header.frame_id = conversions.stamp(time), spec.frame_id
    return message
