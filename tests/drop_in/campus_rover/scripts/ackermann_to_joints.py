#!/usr/bin/env python
"""Turns ackermann_msgs/AckermannDriveStamped into commands for the rover's joint controllers."""

from math import atan, tan

import rospy
from ackermann_msgs.msg import AckermannDrive, AckermannDriveStamped
from campus_rover.msg import RoverStatus
from control_msgs.msg import JointControllerState
from gazebo_msgs.msg import ModelStates
from std_msgs.msg import Float64

WHEELBASE = 0.36
TRACK = 0.34
WHEEL_RADIUS = 0.08


class AckermannToJoints:
    def __init__(self):
        self.status = RoverStatus()
        self.publishers = dict(
            (name, rospy.Publisher(name + "_controller/command", Float64, queue_size=1))
            for name in (
                "rear_left_wheel",
                "rear_right_wheel",
                "front_left_steering",
                "front_right_steering",
            )
        )
        self.status_publisher = rospy.Publisher("status", RoverStatus, queue_size=1)
        rospy.Subscriber("ackermann_cmd", AckermannDriveStamped, self.on_command, queue_size=1)
        rospy.Subscriber(
            "front_left_steering_controller/state",
            JointControllerState,
            self.on_steering,
            queue_size=1,
        )
        rospy.Subscriber("/gazebo/model_states", ModelStates, self.on_models, queue_size=1)
        rospy.Timer(rospy.Duration(0.05), self.on_timer)

    def on_command(self, message):
        self.status.drive = message.drive

    def on_steering(self, message):
        self.status.steering = message

    def on_models(self, message):
        if "campus_rover" in message.name:
            index = message.name.index("campus_rover")
            self.status.model.model_name = "campus_rover"
            self.status.model.pose = message.pose[index]
            self.status.model.twist = message.twist[index]

    def on_timer(self, _):
        drive = self.status.drive or AckermannDrive()
        curvature = tan(drive.steering_angle) / WHEELBASE
        for side, sign in (("left", -1.0), ("right", 1.0)):
            scale = 1.0 + sign * curvature * TRACK / 2.0
            self.publishers[f"rear_{side}_wheel"].publish(drive.speed * scale / WHEEL_RADIUS)
            self.publishers[f"front_{side}_steering"].publish(atan(WHEELBASE * curvature / scale))
        self.status.header.stamp = rospy.Time.now()
        self.status_publisher.publish(self.status)


if __name__ == "__main__":
    rospy.init_node("ackermann_to_joints")
    AckermannToJoints()
    rospy.spin()
