"""Arrays and poses of the core <-> ROS messages."""

from __future__ import annotations

from typing import Any

import numpy as np
import rospy
from bullet_sim.pose import Array, Pose, Vector
from geometry_msgs.msg import Pose as PoseMsg
from geometry_msgs.msg import TransformStamped, Twist
from sensor_msgs.msg import CameraInfo, PointCloud2, PointField
from std_msgs.msg import Header

from bullet_bridge.transport.packed import to_sec_nsec


def stamp(time: float) -> rospy.Time:
    """rospy.Time of a simulated time [s], rounded to nanoseconds."""
    made = rospy.Time.__new__(rospy.Time)  # __init__ takes 1.5 us to look at what it is given
    made.secs, made.nsecs = to_sec_nsec(time)
    return made


def header(time: float, frame: str = "") -> Header:
    """std_msgs/Header of a simulated time [s]."""
    return Header(stamp=stamp(time), frame_id=frame)


def pose_from_msg(message: PoseMsg) -> Pose:
    """core Pose of a geometry_msgs/Pose; an all-zero quaternion means no rotation."""
    p, q = message.position, message.orientation
    orientation = (q.x, q.y, q.z, q.w)
    return Pose((p.x, p.y, p.z), orientation if any(orientation) else (0.0, 0.0, 0.0, 1.0))


def pose_to_msg(pose: Pose) -> PoseMsg:
    """geometry_msgs/Pose of a core Pose."""
    message = PoseMsg()
    message.position.x, message.position.y, message.position.z = pose.position
    q = message.orientation
    q.x, q.y, q.z, q.w = pose.orientation
    return message


def transform_to_msg(time: float, frame: str, child: str, pose: Pose) -> TransformStamped:
    """geometry_msgs/TransformStamped at a time [s] of a child frame's core Pose in a frame."""
    message = TransformStamped(header=header(time, frame), child_frame_id=child)
    translation, rotation = message.transform.translation, message.transform.rotation
    translation.x, translation.y, translation.z = pose.position
    rotation.x, rotation.y, rotation.z, rotation.w = pose.orientation
    return message


def vector(message: Any) -> Array:
    """(3,) array of a geometry_msgs/Vector3 or Point."""
    return np.array((message.x, message.y, message.z))


def twist_to_msg(linear: Vector, angular: Vector) -> Twist:
    """geometry_msgs/Twist of two (3,) arrays [m/s, rad/s]."""
    message = Twist()
    message.linear.x, message.linear.y, message.linear.z = (float(v) for v in linear)
    message.angular.x, message.angular.y, message.angular.z = (float(v) for v in angular)
    return message


def camera_info(spec: Any, arrays: tuple[Array, Array, Array, Array]) -> CameraInfo:
    """sensor_msgs/CameraInfo (without stamp) from D (5,), K (9,), R (9,), P (12,)."""
    d, k, r, p = arrays
    message = CameraInfo(
        height=spec.height,
        width=spec.width,
        distortion_model="plumb_bob",
        D=list(d),
        K=list(k),
        R=list(r),
        P=list(p),
    )
    message.P[3] = -message.P[0] * spec.baseline  # of a stereo pair's right camera
    if spec.bare_info:
        message.D, message.R = [], [0.0] * 9
    message.header.frame_id = spec.frame_id
    return message


_DATATYPES = {
    "<f4": PointField.FLOAT32,
    "<u2": PointField.UINT16,
    "u1": PointField.UINT8,
    "(3,)u1": PointField.FLOAT32,  # PCL's color
}


def point_layout(size: int, *fields: tuple[str, int, str]) -> tuple[Any, list[PointField]]:
    """NumPy's type of a point of a PointCloud2, whose x, y, z it has as 'xyz', and its fields.

    Args:
        size: of a point [bytes].
        fields: name, offset [bytes] and NumPy's type of what follows x, y, z.
    """
    names, offsets, formats = zip(("xyz", 0, "(3,)<f4"), *fields)
    kind = np.dtype({"names": names, "formats": formats, "offsets": offsets, "itemsize": size})
    rows = [("x", 0, "<f4"), ("y", 4, "<f4"), ("z", 8, "<f4"), *fields]
    return kind, [
        PointField(name=name, offset=offset, datatype=_DATATYPES[of], count=1)
        for name, offset, of in rows
    ]


def cloud(header: Header, data: Array, fields: list[Any], is_dense: bool) -> PointCloud2:
    """sensor_msgs/PointCloud2 of an (H, W) structured array.

    Args:
        fields: PointFields of its type.
        is_dense: whether all points are numbers.
    """
    height, width = data.shape
    return PointCloud2(
        header=header,
        height=height,
        width=width,
        fields=fields,
        is_bigendian=False,
        point_step=data.dtype.itemsize,
        row_step=data.dtype.itemsize * width,
        data=np.ascontiguousarray(data).tobytes(),
        is_dense=is_dense,
    )
