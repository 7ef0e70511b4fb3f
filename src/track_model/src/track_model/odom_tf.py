"""Odometry messages, broadcast as the transform odom -> base_link."""

import rospy
import tf2_ros
from geometry_msgs.msg import TransformStamped
from nav_msgs.msg import Odometry
from paddock_common.geometry import transform_of
from paddock_common.nodes import run
from std_msgs.msg import Header


def to_transform(odometry: Odometry, parent: str = "", child: str = "") -> TransformStamped:
    """Convert an odometry message to its transform.

    Args:
        odometry: pose of child_frame_id in header.frame_id.
        parent: Frame that replaces the message's frame_id, if not empty.
        child: Frame that replaces the message's child_frame_id, if not empty.

    Raises:
        ValueError: Neither the message nor the argument names a frame.
    """
    transform = transform_of(odometry)
    transform.header = Header(
        stamp=odometry.header.stamp, frame_id=parent or odometry.header.frame_id
    )
    transform.child_frame_id = child or odometry.child_frame_id
    for item, value in (
        ("header.frame_id", transform.header.frame_id),
        ("child_frame_id", transform.child_frame_id),
    ):
        if not value:
            raise ValueError(
                f"odometry {item} is empty; set a frame name in the message or as parameter"
            )
    return transform


class OdomTf:
    """Node: subscribes `odom`, broadcasts each new pose once on /tf."""

    def __init__(self) -> None:
        self._parent = rospy.get_param("~parent_frame", "")
        self._child = rospy.get_param("~child_frame", "base_link")
        self._broadcaster = tf2_ros.TransformBroadcaster()
        self._last_stamp = None
        self._subscriber = rospy.Subscriber("odom", Odometry, self._receive, queue_size=10)

    def _receive(self, odometry: Odometry) -> None:
        # tf2 warns about a transform sent twice with the same stamp.
        if odometry.header.stamp == self._last_stamp:
            return
        self._last_stamp = odometry.header.stamp
        try:
            self._broadcaster.sendTransform(to_transform(odometry, self._parent, self._child))
        except ValueError as error:
            rospy.logerr_once("odom_tf: %s", error)


def main() -> None:
    """Run the node until ROS shuts down."""
    run("odom_tf", OdomTf)
