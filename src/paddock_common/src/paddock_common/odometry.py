"""The transform of an odometry message."""

from geometry_msgs.msg import TransformStamped


def transform_of(message):
    """Returns the geometry_msgs/TransformStamped that a nav_msgs/Odometry states."""
    made = TransformStamped(header=message.header, child_frame_id=message.child_frame_id)
    position = message.pose.pose.position
    made.transform.translation.x = position.x
    made.transform.translation.y = position.y
    made.transform.translation.z = position.z
    made.transform.rotation = message.pose.pose.orientation
    return made
