"""Shared by the Cyber Truck's integration tests."""

import math

import rospy
from nav_msgs.msg import Odometry
from sim_client import (
    START_LIMIT,
    Recorder,
    sleep_sim,
    turned,
    wait_connected,
    yaw_of,
)

from cybertruck.msg import CyberDriveStamped

TRUTH = "/ground_truth/odom"


def wait_for_truck():
    """Waits until the truck is in the world and its drive node publishes odometry."""
    odometry = Recorder("/odom", Odometry)
    odometry.next(START_LIMIT)
    odometry.close()
    sleep_sim(1.0)


def pose_of(message):
    """Returns (x [m], y [m], yaw [rad]) of an odometry message."""
    position = message.pose.pose.position
    return position.x, position.y, yaw_of(message.pose.pose.orientation)


def way(messages):
    """Returns the distance [m] driven and the sum of all turning [rad] along odometry messages."""
    poses = [pose_of(message) for message in messages]
    pairs = list(zip(poses, poses[1:]))
    return (
        sum(math.dist(a[:2], b[:2]) for a, b in pairs),
        sum(abs(turned(a[2], b[2])) for a, b in pairs),
    )


class Driver:
    """Publishes drive commands 25 times a second of simulated time."""

    def __init__(self):
        self._publisher = rospy.Publisher("/cmd_cyberdrive", CyberDriveStamped, queue_size=1)
        wait_connected(self._publisher, "drive node")

    def give(self, steering, speed, stamp=None):
        """Publishes one command.

        Args:
            steering: Bicycle's angle [rad].
            speed: [m/s].
            stamp: rospy.Time; left out: none, so that the drive node's time counts.
        """
        message = CyberDriveStamped()
        message.header.stamp = rospy.Time() if stamp is None else stamp
        message.drive.steering_angle, message.drive.speed = steering, speed
        self._publisher.publish(message)

    def hold(self, steering, speed, seconds):
        """Repeats a command for a simulated time [s]."""
        end = rospy.get_time() + seconds
        while rospy.get_time() < end:
            self.give(steering, speed)
            sleep_sim(0.04)
