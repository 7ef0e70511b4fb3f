"""Drives straight on."""

import rospy
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry


def drive(_message):
    command = Twist()
    command.linear.x = 1.0
    commands.publish(command)


rospy.init_node("ben")
commands = rospy.Publisher("/cmd_vel", Twist, queue_size=1)
rospy.Subscriber("/racecar/odom", Odometry, drive, queue_size=10)
rospy.spin()
