"""Odometry from wheel and hinge angles. No ROS."""

import math
from dataclasses import dataclass

import numpy as np
from paddock_common.settings import Checked, number

TICKS_PER_REVOLUTION = 42  # of a front wheel's encoder
SMALL_ROTATION = 1e-6  # [rad] below which an arc counts as a line
JUMP_PERIOD = 0.1  # [s] minimum time between measurements
RATE_FLOOR = 1e-6  # variance of speed and yaw rate at standstill
STILL = (1e-6, 1e-6)  # variances of a truck at its start [m^2], [rad^2]


@dataclass(frozen=True)
class Errors(Checked):
    """Errors of wheel odometry, as standard deviations after the first meter or radian.

    They grow with the square root of the distance, as sums of independent errors do.

    Attributes:
        distance_error: of the distance [m], per root of the meters driven.
        heading_error: of the heading [rad], per root of the radians rotated.
        heading_drift: of the heading [rad], per root of the meters driven.
    """

    distance_error: float = number(0.005, min=0.0)
    heading_error: float = number(0.005, min=0.0)
    heading_drift: float = number(0.001, min=0.0)


@dataclass(frozen=True)
class Measured:
    """Measurements of a truck.

    Attributes:
        rear_left, rear_right: rotation of the rear wheels [rad].
        left_steering, right_steering: hinge angles [rad].
        rear_left_speed, rear_right_speed: [rad/s].
    """

    rear_left: float
    rear_right: float
    left_steering: float
    right_steering: float
    rear_left_speed: float = 0.0
    rear_right_speed: float = 0.0


class WheelOdometry:
    """Dead reckoning of the rear axle's center: distance from wheels, curvature from hinges.

    It works with wheel angles, not speeds, so a dropped measurement loses no distance. The
    covariance grows as that of a unicycle driven by distance and rotation with independent errors.

    Args:
        start: (x [m], y [m], yaw [rad]).

    Attributes:
        x, y, yaw: pose of base_footprint in the frame of the start.
        speed, yaw_rate: in the truck's frame [m/s], [rad/s].
        covariance: (3, 3) of (x, y, yaw).
    """

    def __init__(self, model, start=(0.0, 0.0, 0.0), errors: Errors = Errors()):
        self._model, self._start, self._errors = model, tuple(start), errors
        self.reset()

    def reset(self):
        """Reset to the start pose."""
        self.x, self.y, self.yaw = self._start
        self.speed = self.yaw_rate = 0.0
        self.covariance = np.diag((STILL[0], STILL[0], STILL[1]))
        self._last = None

    def jumped(self, measured: Measured, period):
        """Whether a rear wheel has rotated further than it can: the simulator was reset.

        Args:
            period: since the last update [s].
        """
        if self._last is None:
            return False
        shape, last = self._model.geometry, self._last[0]
        limit = 2.0 * shape.max_speed / shape.wheel_radius * max(period, JUMP_PERIOD)
        left, right = measured.rear_left - last.rear_left, measured.rear_right - last.rear_right
        return max(abs(left), abs(right)) > limit

    def update(self, measured: Measured):
        """Update with a new measurement."""
        radius = self._model.geometry.wheel_radius
        curvature = self._model.curvature_of_hinges(measured.left_steering, measured.right_steering)
        if self._last is not None:
            last, last_curvature = self._last
            distance = (
                radius
                * 0.5
                * (measured.rear_left - last.rear_left + measured.rear_right - last.rear_right)
            )
            self._move(distance, 0.5 * (curvature + last_curvature) * distance)
        self._last = measured, curvature
        self.speed = radius * 0.5 * (measured.rear_left_speed + measured.rear_right_speed)
        self.yaw_rate = curvature * self.speed

    def _move(self, distance, rotation):
        """Advance along an arc: distance [m], rotation [rad]."""
        chord = (
            distance
            if abs(rotation) < SMALL_ROTATION
            else distance * math.sin(rotation / 2.0) / (rotation / 2.0)
        )
        direction = self.yaw + rotation / 2.0
        cos, sin = math.cos(direction), math.sin(direction)
        self.x += chord * cos
        self.y += chord * sin
        self.yaw = math.remainder(self.yaw + rotation, 2.0 * math.pi)
        if distance == 0.0 and rotation == 0.0:
            return
        # P <- F P F' + G Q G', F and G the derivatives by pose and by (distance, turn).
        pose = np.array([[1.0, 0.0, -chord * sin], [0.0, 1.0, chord * cos], [0.0, 0.0, 1.0]])
        drive = np.array([[cos, -0.5 * chord * sin], [sin, 0.5 * chord * cos], [0.0, 1.0]])
        errors = self._errors
        noise = np.diag(
            (
                errors.distance_error**2 * abs(distance),
                errors.heading_error**2 * abs(rotation) + errors.heading_drift**2 * abs(distance),
            )
        )
        self.covariance = pose @ self.covariance @ pose.T + drive @ noise @ drive.T

    def twist_variances(self):
        """Variances of speed [m^2/s^2] and yaw rate [rad^2/s^2], with a floor at standstill.

        A speed has the relative error of the distance driven in one second.
        """
        errors = self._errors
        return (
            errors.distance_error**2 * abs(self.speed) + RATE_FLOOR,
            errors.heading_error**2 * abs(self.yaw_rate)
            + errors.heading_drift**2 * abs(self.speed)
            + RATE_FLOOR,
        )


def ticks(angle):
    """Encoder count of a wheel angle [rad]: 42 per revolution, decreasing backwards."""
    return math.floor(angle * TICKS_PER_REVOLUTION / (2.0 * math.pi))
