"""Follows the centreline: steers towards its point half a meter ahead (pure pursuit)."""

import math

import numpy as np
import rospy
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry, Path

SPEED, AHEAD = 0.8, 0.5  # [m/s], [m]

rospy.init_node("anna")
commands = rospy.Publisher("/cmd_vel", Twist, queue_size=1)
poses = rospy.wait_for_message("/referee/centreline", Path).poses
line = np.array([(item.pose.position.x, item.pose.position.y) for item in poses])


def drive(message):
    place, turn = message.pose.pose.position, message.pose.pose.orientation
    heading = 2.0 * math.atan2(turn.z, turn.w)
    way = line - (place.x, place.y)
    forward = way @ (math.cos(heading), math.sin(heading))
    left = way @ (-math.sin(heading), math.cos(heading))
    far = np.where(forward > 0.0, np.hypot(forward, left), 0.0)
    goal = np.argmin(np.abs(far - AHEAD))
    command = Twist()
    command.linear.x = SPEED
    command.angular.z = SPEED * 2.0 * left[goal] / far[goal] ** 2
    commands.publish(command)


rospy.Subscriber("/racecar/odom", Odometry, drive, queue_size=10)
rospy.spin()
