"""Arrays and poses <-> messages."""
import io
import math

import numpy as np
import pytest
from geometry_msgs.msg import Pose as PoseMsg

from bullet_bridge import conversions
from bullet_sim.pose import Pose
from bullet_sim.sensors.camera import camera_info_arrays
from bullet_sim.specs import CameraSpec, GroundTruthSpec, ImuSpec, RaySpec


def packs(message):
    """Whether a message can be sent."""
    message.serialize(io.BytesIO())
    return True


@pytest.mark.parametrize('time, secs, nsecs', [
    (0.0, 0, 0), (0.001, 0, 1000000), (0.9999999999, 1, 0), (0.9999999994, 0, 999999999),
    (1.9999999999, 2, 0), (123.457, 123, 457000000), (4567 * 0.001, 4, 567000000)])
def test_stamp_is_rounded_to_nanoseconds(time, secs, nsecs):
    stamp = conversions.stamp(time)
    assert (stamp.secs, stamp.nsecs) == (secs, nsecs)


def test_stamps_of_steps_are_valid_and_exact():
    for step in range(0, 100000, 7):
        stamp = conversions.stamp(step * 0.001)
        assert 0 <= stamp.nsecs < 10 ** 9
        assert stamp.to_nsec() == step * 10 ** 6


def test_pose_there_and_back():
    pose = Pose.from_xyz_rpy((1.0, -2.0, 0.5), (0.1, -0.2, 2.5))
    assert conversions.pose_from_msg(conversions.pose_to_msg(pose)) == pose


def test_zero_quaternion_means_no_rotation():
    message = PoseMsg()
    message.position.x = 3.0
    assert conversions.pose_from_msg(message) == Pose((3.0, 0.0, 0.0))


def test_twist():
    twist = conversions.twist_to_msg(np.array([1, 2, 3]), np.array([4, 5, 6]))
    assert (twist.linear.x, twist.linear.y, twist.linear.z) == (1.0, 2.0, 3.0)
    assert (twist.angular.x, twist.angular.y, twist.angular.z) == (4.0, 5.0, 6.0)
    assert packs(twist)


def test_joint_state():
    message = conversions.joint_state(1.5, ('a', 'b'), *np.arange(6.0).reshape(3, 2))
    assert (message.name, message.position) == (['a', 'b'], [0.0, 1.0])
    assert (message.velocity, message.effort) == ([2.0, 3.0], [4.0, 5.0])
    assert message.header.stamp.to_sec() == 1.5 and packs(message)


def test_odometry():
    spec = GroundTruthSpec('base', '/odom', frame_id='map', child_frame_id='base')
    message = conversions.odometry(2.0, spec, Pose((1.0, 2.0, 3.0)), np.ones(3), np.zeros(3))
    assert (message.header.frame_id, message.child_frame_id) == ('map', 'base')
    assert message.pose.pose.position.z == 3.0 and message.twist.twist.linear.y == 1.0
    assert packs(message)


def test_image_has_rows_of_width_times_three():
    rgb = np.arange(4 * 6 * 3, dtype=np.uint8).reshape(4, 6, 3)
    message = conversions.image(0.25, 'camera', rgb)
    assert (message.height, message.width, message.step) == (4, 6, 18)
    assert message.encoding == 'rgb8' and message.header.frame_id == 'camera'
    assert len(message.data) == message.step * message.height
    assert np.array_equal(np.frombuffer(message.data, np.uint8).reshape(rgb.shape), rgb)
    assert packs(message)


def test_image_of_a_view_is_in_row_order():
    rgb = np.arange(4 * 6 * 3, dtype=np.uint8).reshape(4, 6, 3)[::-1, ::-1]
    data = conversions.image(0.0, 'camera', rgb).data
    assert np.array_equal(np.frombuffer(data, np.uint8).reshape(4, 6, 3), rgb)


def test_camera_info_sizes():
    spec = CameraSpec('c', 'l', width=160, height=120, horizontal_fov=1.0, frame_id='f')
    message = conversions.camera_info(spec, camera_info_arrays(160, 120, 1.0))
    assert [len(a) for a in (message.D, message.K, message.R, message.P)] == [5, 9, 9, 12]
    assert (message.width, message.height, message.header.frame_id) == (160, 120, 'f')
    assert message.distortion_model == 'plumb_bob'
    assert message.K[0] == pytest.approx(80 / math.tan(0.5)) and message.P[0] == message.K[0]
    assert packs(message)


def test_laser_scan_fields():
    spec = RaySpec('s', 'l', samples=3, min_angle=-1.0, max_angle=1.0, range_min=0.2,
                   range_max=8.0, rate=20.0, frame_id='laser')
    message = conversions.laser_scan(3.0, spec, 1.0, np.array([1.0, math.inf, 2.0]))
    assert (message.angle_min, message.angle_max, message.angle_increment) == (-1.0, 1.0, 1.0)
    assert (message.range_min, message.range_max) == (0.2, 8.0)
    assert (message.scan_time, message.time_increment) == (0.05, 0.0)
    assert message.ranges == [1.0, math.inf, 2.0] and list(message.intensities) == [0] * 3
    assert message.header.frame_id == 'laser' and packs(message)


def test_imu_message():
    message = conversions.imu_message(1.0, ImuSpec('i', 'l', frame_id='imu'),
                                      (0.0, 0.0, 0.0, 1.0), np.ones(3), np.array([0, 0, 9.81]))
    assert message.orientation.w == 1.0 and message.linear_acceleration.z == 9.81
    assert message.angular_velocity.y == 1.0 and message.header.frame_id == 'imu'
    assert packs(message)
