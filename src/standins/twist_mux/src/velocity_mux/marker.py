"""The node twist_marker: a velocity command as an arrow above the robot."""

import rospy
from geometry_msgs.msg import Point, Twist
from visualization_msgs.msg import Marker

from paddock_common import nodes

FRAME = "base_footprint"
HEIGHT = 2.0  # of the arrow above the frame [m]
SHAFT, HEAD = 0.05, 0.1  # diameters of the arrow [m]


def tip(twist):
    """Where the arrow ends: forward speed, and sideways the larger of drift and turn.

    Returns:
        (x, y) [m for m/s, and for rad/s].
    """
    sideways = max(twist.linear.y, twist.angular.z, key=abs)
    return twist.linear.x, sideways


def arrow(twist):
    """visualization_msgs/Marker of a geometry_msgs/Twist."""
    marker = Marker(type=Marker.ARROW, action=Marker.ADD)
    marker.header.frame_id = FRAME
    marker.pose.position.z = HEIGHT
    marker.pose.orientation.w = 1.0
    marker.scale.x, marker.scale.y = SHAFT, HEAD
    marker.color.g = marker.color.a = 1.0
    marker.points = [Point(), Point(*tip(twist), 0.0)]
    return marker


def main():
    """Runs the node."""
    nodes.init_interruptible("twist_marker")
    publisher = rospy.Publisher("marker", Marker, queue_size=1, latch=True)
    rospy.Subscriber("twist", Twist, lambda twist: publisher.publish(arrow(twist)), queue_size=1)
    rospy.spin()
    return 0
