"""Messages in their wire format: the bytes are genpy's."""

import io

import genpy
import numpy as np
import pytest
import rospy
from geometry_msgs.msg import Point, Quaternion, TransformStamped, Vector3
from nav_msgs.msg import Odometry
from robot_localization.messages import ImuReading, OdometryBytes, TransformBytes, covariance
from rospy.msg import deserialize_messages, serialize_message
from sensor_msgs.msg import Imu
from tf2_msgs.msg import TFMessage

STAMP = rospy.Time(12, 345678901)


def sent(message, seq=7):
    """Bytes as rospy sends them."""
    buffer = io.BytesIO()
    serialize_message(buffer, seq, message)
    return buffer.getvalue()


def received(data, kind):
    """The messages that rospy makes of bytes."""
    buffer, messages = io.BytesIO(), []
    buffer.write(data)
    deserialize_messages(buffer, messages, kind)
    return messages


@pytest.mark.parametrize("frame", ["", "imu_link", "imu_länk"])
def test_readings_of_an_imu(frame):
    message = Imu()
    message.header.stamp, message.header.frame_id = STAMP, frame
    message.orientation = Quaternion(0.1, 0.2, 0.3, 0.4)
    message.angular_velocity, message.linear_acceleration = Vector3(1, 2, 3), Vector3(-4, 5e-300, 6)
    message.orientation_covariance = np.arange(9.0).tolist()
    message.angular_velocity_covariance = (10.0 + np.arange(9.0)).tolist()
    message.linear_acceleration_covariance = (-np.arange(9.0)).tolist()
    first, second = received(sent(message) * 2, ImuReading)
    assert first.header == second.header == (STAMP, frame)
    assert first.attitude == (0.1, 0.2, 0.3, 0.4)
    assert (first.rates, first.force) == ((1, 2, 3), (-4, 5e-300, 6))
    assert [covariance(data) for data in first.covariances] == [
        tuple(message.orientation_covariance),
        tuple(message.angular_velocity_covariance),
        tuple(message.linear_acceleration_covariance),
    ]
    first._connection_header = {"callerid": "/imu"}  # rospy sets it
    assert (ImuReading._type, ImuReading._md5sum) == (Imu._type, Imu._md5sum)


def test_a_damaged_reading_is_an_error_of_its_connection():
    with pytest.raises(genpy.DeserializationError):
        received(b"\x05\x00\x00\x00hello", ImuReading)


@pytest.mark.parametrize("frames", [("odom", "base_link"), ("ödom", "")])
def test_odometry(frames):
    rng, expected = np.random.default_rng(3), Odometry()
    whole = rng.normal(size=(15, 15))
    covariances = whole[:6, :6], whole[6:12, 6:12]
    values = [rng.normal(size=size).tolist() for size in (3, 4, 6)]
    packed = OdometryBytes(*frames).fill(STAMP, *values, covariances)
    expected.header.stamp, expected.header.frame_id, expected.child_frame_id = STAMP, *frames
    expected.pose.pose.position = Point(*values[0])
    expected.pose.pose.orientation = Quaternion(*values[1])
    expected.twist.twist.linear = Vector3(*values[2][:3])
    expected.twist.twist.angular = Vector3(*values[2][3:])
    expected.pose.covariance, expected.twist.covariance = (
        item.ravel().tolist() for item in covariances
    )
    assert sent(packed, 41) == sent(expected, 41)


def test_transform():
    item = TransformStamped(child_frame_id="base_link")
    item.header.stamp, item.header.frame_id = STAMP, "odom"
    item.transform.translation, item.transform.rotation = (
        Vector3(1, 2, 3),
        Quaternion(0, 0, 0.6, 0.8),
    )
    packed = TransformBytes("odom", "base_link").fill(STAMP, (1, 2, 3), (0, 0, 0.6, 0.8))
    assert sent(packed) == sent(TFMessage([item]))
