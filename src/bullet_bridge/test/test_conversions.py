"""Arrays and poses <-> messages."""

import io
import math

import numpy as np
import pytest
from bullet_bridge.transport import conversions
from bullet_sim.plugins.cameras import CameraSpec
from bullet_sim.pose import Pose
from bullet_sim.sensors import camera
from bullet_sim.sensors.camera import camera_info_arrays
from geometry_msgs.msg import Pose as PoseMsg


def packs(message):
    message.serialize(io.BytesIO())
    return True


@pytest.mark.parametrize(
    "time, secs, nsecs",
    [
        (0.0, 0, 0),
        (0.001, 0, 1000000),
        (0.9999999999, 1, 0),
        (0.9999999994, 0, 999999999),
        (1.9999999999, 2, 0),
        (123.457, 123, 457000000),
        (4567 * 0.001, 4, 567000000),
    ],
)
def test_stamp_is_rounded_to_nanoseconds(time, secs, nsecs):
    stamp = conversions.stamp(time)
    assert (stamp.secs, stamp.nsecs) == (secs, nsecs)


def test_stamps_of_steps_are_valid_and_exact():
    for step in range(0, 100000, 7):
        stamp = conversions.stamp(step * 0.001)
        assert 0 <= stamp.nsecs < 10**9
        assert stamp.to_nsec() == step * 10**6


def test_pose_there_and_back():
    pose = Pose.from_xyz_rpy((1.0, -2.0, 0.5), (0.1, -0.2, 2.5))
    assert conversions.pose_from_msg(conversions.pose_to_msg(pose)) == pose


def test_zero_quaternion_means_no_rotation():
    message = PoseMsg()
    message.position.x = 3.0
    assert conversions.pose_from_msg(message) == Pose((3.0, 0.0, 0.0))


def test_fields_of_a_cloud_are_where_its_points_have_them():
    kind, fields = conversions.point_layout(20, ("intensity", 16, "<f4"))
    (point,) = np.array([((1.0, 2.0, 3.0), 4.0)], kind)
    values = {field.name: np.frombuffer(point, "<f4", 1, field.offset)[0] for field in fields}
    assert values == {"x": 1.0, "y": 2.0, "z": 3.0, "intensity": 4.0}


def test_twist():
    twist = conversions.twist_to_msg(np.array([1, 2, 3]), np.array([4, 5, 6]))
    assert (twist.linear.x, twist.linear.y, twist.linear.z) == (1.0, 2.0, 3.0)
    assert (twist.angular.x, twist.angular.y, twist.angular.z) == (4.0, 5.0, 6.0)
    assert packs(twist)


def test_pixels_of_a_view_are_in_row_order():
    rgb = np.arange(4 * 6 * 3, dtype=np.uint8).reshape(4, 6, 3)[::-1, ::-1]
    for encoding, expected in (("rgb8", rgb), ("bgr8", rgb[:, :, ::-1])):
        data = camera.pixels(rgb, encoding).tobytes()
        assert np.array_equal(np.frombuffer(data, np.uint8).reshape(4, 6, 3), expected)


def test_camera_info_sizes():
    spec = CameraSpec("c", "l", width=160, height=120, horizontal_fov=1.0, frame_id="f")
    message = conversions.camera_info(spec, camera_info_arrays(160, 120, 1.0))
    assert [len(a) for a in (message.D, message.K, message.R, message.P)] == [5, 9, 9, 12]
    assert (message.width, message.height, message.header.frame_id) == (160, 120, "f")
    assert message.distortion_model == "plumb_bob"
    assert message.K[0] == pytest.approx(80 / math.tan(0.5)) and message.P[0] == message.K[0]
    assert packs(message)
