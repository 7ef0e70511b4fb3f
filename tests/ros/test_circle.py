"""A steady circle in ackermann mode: the rear axle's center follows the kinematic bicycle.

More of them without ROS: src/bullet_sim/test/test_drive_physics.py.

Radius R = L / tan(steering) (kinematic bicycle without side slip at the rear axle).
"""

import math
import unittest

import numpy as np
import rospy
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from shared_worlds import CAR as LAUNCH  # noqa: F401
from sim_client import CAR_COMMANDS, Recorder, wait_connected, wait_for_car, yaw_of
from stepping import PHYSICS_STEP, Time

WHEELBASE = 0.164  # [m]
REAR_AXLE = -0.081663  # x in base_link [m]
SPEED = 0.5  # [m/s]
DEGREES = -20  # of steering, left is positive
SETTLE = 1.0  # left out at the start, simulated time [s]
LAPS = 2
RADIUS_TOLERANCE = 0.03  # part of the radius
DRIFT_TOLERANCE = 0.01  # part of the radius, per lap


def fit_circle(points):
    """Fits a circle to points (N, 2) by linear least squares (Kasa 1976).

    Returns:
        (center (2,), radius), both [m].
    """
    matrix = np.column_stack([2.0 * points, np.ones(len(points))])
    solution = np.linalg.lstsq(matrix, (points**2).sum(axis=1), rcond=None)[0]
    center = solution[:2]
    return center, math.sqrt(solution[2] + center @ center)


def rear_axle_track(messages):
    """Returns the rear axle's places (N, 2) [m] and unwrapped headings (N,) [rad]."""
    yaw = np.unwrap([yaw_of(item.pose.pose.orientation) for item in messages])
    base = np.array([[item.pose.pose.position.x, item.pose.pose.position.y] for item in messages])
    return base + REAR_AXLE * np.column_stack([np.cos(yaw), np.sin(yaw)]), yaw


class Circle(unittest.TestCase):
    """Drives two laps."""

    @classmethod
    def setUpClass(cls):
        wait_for_car()
        cls.publisher = rospy.Publisher("/cmd_vel", Twist, queue_size=10)
        wait_connected(cls.publisher, "control")
        cls.odometry = Recorder("/racecar/odom", Odometry)
        cls.time = Time(CAR_COMMANDS, [cls.odometry.topic])

    @classmethod
    def tearDownClass(cls):
        cls.publisher.publish(Twist())
        cls.time.go(PHYSICS_STEP, commands=1)
        cls.time.close()

    def laps(self, steering):
        """Drives LAPS laps at a steering angle [rad] and returns the fits, one a lap."""
        command = Twist()
        curvature = math.tan(steering) / WHEELBASE
        command.linear.x = SPEED
        command.angular.z = command.linear.x * curvature
        self.publisher.publish(command)
        self.time.go(SETTLE, commands=1)
        begin = self.time.now
        self.odometry.clear()
        self.time.go(1.05 * LAPS * 2.0 * math.pi / abs(command.angular.z))
        self.time.latest(self.odometry)
        steady = [item for item in self.odometry.messages if item.header.stamp.to_sec() > begin]
        points, yaw = rear_axle_track(steady)
        progress = (yaw - yaw[0]) * math.copysign(1.0, steering) / (2.0 * math.pi)
        fits = []
        for lap in range(LAPS):
            part = points[(progress >= lap) & (progress < lap + 1)]
            self.assertGreater(progress.max(), lap + 1, f"lap {lap} was not finished")
            fits.append(fit_circle(part))
        return fits

    def test_laps_have_the_radius_of_the_bicycle(self):
        steering = math.radians(DEGREES)
        expected = WHEELBASE / math.tan(abs(steering))
        fits = self.laps(steering)
        drift = np.linalg.norm(fits[1][0] - fits[0][0]) / expected
        for _center, radius in fits:
            print(
                f"{DEGREES:+d} deg: radius {radius:.4f} m, expected {expected:.4f} m "
                f"({100 * (radius / expected - 1):+.2f} %), drift {100 * drift:.3f} % a lap"
            )
            self.assertAlmostEqual(radius / expected, 1.0, delta=RADIUS_TOLERANCE)
        self.assertLess(drift, DRIFT_TOLERANCE)
