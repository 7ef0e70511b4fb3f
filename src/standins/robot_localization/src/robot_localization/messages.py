"""Frequent messages in their wire format: readings of IMUs in, estimates and transforms out.

genpy makes an object for each field of a message and packs or unpacks field by field, which takes
longer than the filter's arithmetic. The bytes are the same.

Wire format: http://wiki.ros.org/msg#Fields (little endian; strings and lists lead with a uint32).
"""

import struct
from typing import NamedTuple

import rospy
from nav_msgs.msg import Odometry
from sensor_msgs.msg import Imu
from tf2_msgs.msg import TFMessage

HEADER = struct.Struct("<III")  # seq, stamp: seconds, nanoseconds
LENGTH = struct.Struct("<I")
IMU = struct.Struct("<4d72s3d72s3d72s")
SQUARE_3 = struct.Struct("<9d")
POSE = struct.Struct("<7d")
TWIST = struct.Struct("<6d")


class Header(NamedTuple):
    """What is used of a std_msgs/Header."""

    stamp: rospy.Time
    frame_id: str


class ImuReading(Imu):
    """A sensor_msgs/Imu for rospy.Subscriber.

    Attributes:
        header: Header.
        attitude: (x, y, z, w).
        rates: [rad/s].
        force: Linear acceleration [m/s^2].
        covariances: 72 bytes each: of attitude, rates and force, see covariance().
    """

    def __init__(self):  # rospy fills it by deserialize()
        pass

    def deserialize(self, buffer):
        """Reads the wire format; rospy reports an exception as a wrong message."""
        _, seconds, nanoseconds = HEADER.unpack_from(buffer)
        start = HEADER.size + LENGTH.size
        end = start + LENGTH.unpack_from(buffer, HEADER.size)[0]
        self.header = Header(rospy.Time(seconds, nanoseconds), buffer[start:end].decode())
        x, y, z, w, attitude, p, q, r, rates, ax, ay, az, force = IMU.unpack_from(buffer, end)
        self.attitude, self.rates, self.force = (x, y, z, w), (p, q, r), (ax, ay, az)
        self.covariances = attitude, rates, force
        return self


def covariance(data):
    """Nine numbers of the bytes of a covariance."""
    return SQUARE_3.unpack(data)


def pack_string(text):
    """Bytes of a string field."""
    data = text.encode()
    return LENGTH.pack(len(data)) + data


class OdometryBytes:
    """A nav_msgs/Odometry for rospy's publish(), which sets `header.seq`.

    Args:
        world, robot: Names of frames.
    """

    _md5sum, _type, _has_header = Odometry._md5sum, Odometry._type, True

    def __init__(self, world, robot):
        self.header = Odometry().header
        self._frames = pack_string(world) + pack_string(robot)

    def fill(self, stamp, position, orientation, twist, covariances):
        """Sets the fields.

        Args:
            position, orientation, twist: Three, four (x, y, z, w) and six numbers.
            covariances: (6, 6) arrays of pose and twist.
        """
        pose_covariance, twist_covariance = covariances
        self._stamp = stamp
        self._rest = (
            POSE.pack(*position, *orientation),
            pose_covariance.astype("<f8", copy=False).tobytes(),
            TWIST.pack(*twist),
            twist_covariance.astype("<f8", copy=False).tobytes(),
        )
        return self

    def serialize(self, buffer):
        """Writes the wire format."""
        stamp = self._stamp
        buffer.write(HEADER.pack(self.header.seq, stamp.secs, stamp.nsecs))
        buffer.write(self._frames)
        buffer.writelines(self._rest)


class TransformBytes:
    """A tf2_msgs/TFMessage of one transform for rospy's publish().

    Args:
        parent, child: Names of frames.
    """

    _md5sum, _type, _has_header = TFMessage._md5sum, TFMessage._type, False

    def __init__(self, parent, child):
        self._frames = pack_string(parent) + pack_string(child)

    def fill(self, stamp, translation, rotation):
        """Sets the fields: three numbers, and four (x, y, z, w)."""
        head = LENGTH.pack(1) + HEADER.pack(0, stamp.secs, stamp.nsecs)
        self._data = head + self._frames + POSE.pack(*translation, *rotation)
        return self

    def serialize(self, buffer):
        """Writes the wire format."""
        buffer.write(self._data)
