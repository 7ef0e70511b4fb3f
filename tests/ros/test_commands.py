"""Float64 commands reach wheels and hinges; NaN and infinity are refused."""

import math
import unittest

from sensor_msgs.msg import JointState
from shared_worlds import CAR as LAUNCH  # noqa: F401
from sim_client import (
    HINGES,
    WHEELS,
    Recorder,
    command_publishers,
    joint,
    sleep_sim,
    wait_for_car,
    wait_until,
)

WHEEL_SPEED = 5.0  # [rad/s]
WHEEL_TOLERANCE = 0.05  # 1 % [rad/s]
HINGE_ANGLE = 0.2  # [rad]
HINGE_TOLERANCE = 0.01  # [rad]


class Commands(unittest.TestCase):
    """Publishes on the controllers' own topics and reads joint_states."""

    @classmethod
    def setUpClass(cls):
        wait_for_car()
        cls.publishers = command_publishers()
        cls.joints = Recorder("/racecar/joint_states", JointState)
        cls.joints.wait_count(1)

    def tearDown(self):
        for publisher in self.publishers.values():
            publisher.publish(0.0)
        self.wait_speed(0.0)

    def wait_speed(self, speed):
        for wheel in WHEELS:
            wait_until(
                lambda: abs(joint(self.joints.last, wheel + "_joint")[1] - speed) < WHEEL_TOLERANCE,
                f"{wheel} at {speed} rad/s",
            )

    def drive(self, speed):
        for wheel in WHEELS:
            self.publishers[wheel].publish(speed)
        self.wait_speed(speed)

    def test_hinges_go_where_they_are_told_each_on_its_own(self):
        for left, right in ((-HINGE_ANGLE, HINGE_ANGLE), (0.0, 0.0)):
            for hinge, angle in zip(HINGES, (left, right)):
                self.publishers[hinge].publish(angle)
            for hinge, angle in zip(HINGES, (left, right)):
                wait_until(
                    lambda: (
                        abs(joint(self.joints.last, hinge + "_joint")[0] - angle) < HINGE_TOLERANCE
                    ),
                    f"{hinge} at {angle} rad",
                )

    def test_commands_that_are_no_numbers_change_nothing(self):
        self.drive(WHEEL_SPEED)
        for bad in (math.nan, math.inf, -math.inf):
            for publisher in self.publishers.values():
                publisher.publish(bad)
            sleep_sim(0.3)  # fails if /clock stops
            message = self.joints.next()
            for wheel in WHEELS:
                self.assertAlmostEqual(
                    joint(message, wheel + "_joint")[1],
                    WHEEL_SPEED,
                    delta=WHEEL_TOLERANCE,
                    msg=f"{wheel} after {bad}",
                )
            for hinge in HINGES:
                self.assertAlmostEqual(
                    joint(message, hinge + "_joint")[0],
                    0.0,
                    delta=HINGE_TOLERANCE,
                    msg=f"{hinge} after {bad}",
                )

    def test_a_stopped_car_wakes_up_again(self):
        sleep_sim(3.0)  # long enough for a body to fall asleep
        self.drive(WHEEL_SPEED)
