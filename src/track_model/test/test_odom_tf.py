"""Odometry to transform, without a master."""

import pytest

rospy = pytest.importorskip("rospy")
pytest.importorskip("tf2_ros")
from nav_msgs.msg import Odometry  # noqa: E402
from track_model.odom_tf import to_transform  # noqa: E402


def message(frame="odom", child="base_link"):
    odometry = Odometry()
    odometry.header.frame_id, odometry.child_frame_id = frame, child
    odometry.header.stamp = rospy.Time(12, 34)
    odometry.pose.pose.position.x, odometry.pose.pose.position.y = 1.5, -2.5
    odometry.pose.pose.position.z = 0.25
    odometry.pose.pose.orientation.z, odometry.pose.pose.orientation.w = 0.6, 0.8
    return odometry


@pytest.mark.parametrize(
    "frames, arguments, expected",
    [
        (("odom", "base_link"), {}, ("odom", "base_link")),
        (("odom", ""), {"child": "base_link"}, ("odom", "base_link")),
        (("odom", "car"), {"parent": "map", "child": "base_link"}, ("map", "base_link")),
    ],
)
def test_frames_and_pose(frames, arguments, expected):
    result = to_transform(message(*frames), **arguments)
    translation, rotation = result.transform.translation, result.transform.rotation
    assert (result.header.frame_id, result.child_frame_id) == expected
    assert result.header.stamp == rospy.Time(12, 34)
    assert (translation.x, translation.y, translation.z) == (1.5, -2.5, 0.25)
    assert (rotation.x, rotation.y, rotation.z, rotation.w) == (0.0, 0.0, 0.6, 0.8)


def test_missing_frame_is_named():
    with pytest.raises(ValueError, match="child_frame_id"):
        to_transform(message(child=""))
