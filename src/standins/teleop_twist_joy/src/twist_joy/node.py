"""The node teleop_node."""

import rospy
from geometry_msgs.msg import Twist, Vector3
from sensor_msgs.msg import Joy

from paddock_common import nodes
from twist_joy.deadman import Deadman
from twist_joy.mapping import read


def main():
    """Runs the node; returns 1 when a parameter is wrong."""
    nodes.init_interruptible("teleop_twist_joy_node")
    try:
        mapping = read(rospy.get_param("~", {}))
    except ValueError as error:
        rospy.logfatal("teleop_twist_joy: %s", error)
        return 1
    rospy.loginfo("teleop_twist_joy: enable button %d", mapping.enable_button)
    if mapping.turbo_button >= 0:
        rospy.loginfo("teleop_twist_joy: turbo button %d", mapping.turbo_button)
    for name, axis in mapping.axes.items():
        rospy.loginfo(
            "teleop_twist_joy: %s is axis %d times %g, with turbo %g",
            name,
            axis.number,
            axis.scale,
            axis.turbo,
        )
    deadman = Deadman(mapping)
    publisher = rospy.Publisher("cmd_vel", Twist, queue_size=1, latch=True)

    def take(joy):
        command = deadman.command(joy.axes, joy.buttons)
        if command is not None:
            publisher.publish(Twist(Vector3(*command[:3]), Vector3(*command[3:])))

    rospy.Subscriber("joy", Joy, take, queue_size=1)
    rospy.spin()
    return 0
