"""Data of sensors in the filter's frames, as measurements of its state.

A sensor's `used` truth values are about the sensor's axes. They are rotated like its data: a
value of the state counts as measured when a used axis has a component in it.
"""

import numpy as np

from robot_localization.ekf import ACCELERATION, OUT_OF_PLANE, POSE, SIZE, TWIST
from robot_localization.frames import IDENTITY, Transform, angles, cross, matrix, twice

FLAT = np.array(OUT_OF_PLANE)
MIN_COMPONENT = 1e-6  # of a used axis in a value of the state
PLANE_VARIANCE = 1e-6  # of values that are 0 in the plane


class StateValues:
    """Measured values of the state.

    Attributes:
        used: (15,) bool.
        value: (15,).
        covariance: (15, 15).
    """

    def __init__(self):
        self.used = np.zeros(SIZE, bool)
        self.value = np.zeros(SIZE)
        self.covariance = np.zeros((SIZE, SIZE))

    def set(self, part, used, value, covariance):
        """Sets POSE, TWIST or ACCELERATION."""
        self.used[part], self.value[part], self.covariance[part, part] = used, value, covariance
        return self

    def flatten(self):
        """Makes them those of a robot in the plane."""
        self.used[FLAT], self.value[FLAT] = True, 0.0
        self.covariance[FLAT, FLAT] = PLANE_VARIANCE
        return self

    def select(self):
        """(index, value, covariance) of the used ones."""
        index = np.flatnonzero(self.used)
        return index, self.value[index], self.covariance[np.ix_(index, index)]


def rotated(rotation, used):
    """Which values the used axes of a rotated sensor contribute to; for three or six axes."""
    if rotation is IDENTITY.rotation:
        return np.array(used, bool)
    parts = np.abs(rotation) >= MIN_COMPONENT
    used = np.asarray(used, bool).reshape(-1, 3)
    return (parts & used[:, None, :]).any(axis=2).ravel()


def spread(rotation, covariance):
    """(6, 6) covariance of two rotated vectors."""
    covariance = np.asarray(covariance, float)
    if rotation is IDENTITY.rotation:
        return covariance
    both = twice(rotation)
    return both @ covariance @ both.T


class PoseInput:
    """Poses of one sensor; stores the first and the last one.

    Args:
        used: Six truth values.
        differential: Whether to make velocities of them.
        relative: Whether they are relative to the first one.
    """

    def __init__(self, used, differential=False, relative=False):
        self._used = tuple(used)
        self.differential, self._relative = differential, relative
        self._first = self._last = None

    def process(self, time, pose, covariance, frame=IDENTITY, base=IDENTITY, used=None):
        """Poses of the robot.

        Args:
            time: [s].
            pose: Transform: the sensor's pose in its frame.
            covariance: (6, 6) of position and angles, about the frame's axes.
            frame: Transform: the frame in the world; a differential sensor needs none.
            base: Transform: the robot in what the pose is of.
            used: Six truth values instead of the sensor's.

        Returns:
            StateValues, or None: the first pose of a differential sensor.
        """
        used = self._used if used is None else used
        covariance = np.array(covariance, float)
        if self.differential:
            return self._velocity(time, pose, covariance, base, used)
        if base is not IDENTITY:
            pose = pose.of(base)
            covariance = spread(base.rotation.T, covariance)
        if self._relative:
            self._first = pose if self._first is None else self._first
            pose = self._first.inverse().of(pose)
        pose = frame.of(pose)
        return StateValues().set(
            POSE,
            rotated(frame.rotation, used),
            np.concatenate((pose.translation, angles(pose.rotation))),
            spread(frame.rotation, covariance),
        )

    def process_attitude(self, time, rotation, covariance, mount=IDENTITY):
        """Attitudes of an IMU.

        Its frame is its mounting, and not the reference of its attitude: the mounting is removed,
        and used axes and covariance rotate with the mounting's yaw alone.

        Args:
            time: [s].
            rotation: (3, 3) attitude of the IMU in the world.
            covariance: (3, 3) of its angles.
            mount: Transform: the IMU in the robot.

        Returns:
            StateValues, or None: the first attitude of a differential sensor.
        """
        pose = Transform(rotation @ mount.rotation.T, np.zeros(3))
        yaw = matrix(0.0, 0.0, angles(mount.rotation)[2])
        full = np.zeros((6, 6))
        full[3:, 3:] = yaw @ covariance @ yaw.T
        return self.process(time, pose, full, used=rotated(yaw, self._used))

    def _velocity(self, time, pose, covariance, base, used):
        last, self._last = self._last, (time, pose, covariance)
        if last is None or not time > last[0]:
            return None
        step = time - last[0]
        change = last[1].inverse().of(pose)
        # Upstream's rule: with the variances of two poses apart by 1 s the velocity is as sure as
        # they are, and surer the closer they are.
        return twist(
            change.translation / step,
            angles(change.rotation) / step,
            (covariance + last[2]) * step,
            used,
            base.inverse() if base is not IDENTITY else IDENTITY,
        )


def twist(linear, angular, covariance, used, mount=IDENTITY, rates=None):
    """Velocities of the robot.

    Args:
        linear: (3,) of the sensor, about its axes [m/s].
        angular: (3,) [rad/s].
        covariance: (6, 6).
        used: Six truth values.
        mount: Transform: the sensor in the robot.
        rates: (3,) angular rates of the robot, for a sensor off its centre [rad/s];
            None: `angular`.
    """
    angular = mount.rotation @ angular
    rates = angular if rates is None else rates
    linear = mount.rotation @ linear + cross(mount.translation, rates)
    return StateValues().set(
        TWIST,
        rotated(mount.rotation, used),
        np.concatenate((linear, angular)),
        spread(mount.rotation, covariance),
    )


def acceleration(measured, covariance, used, mount, rates, rates_change):
    """Acceleration of the robot.

    Args:
        measured: (3,) of the sensor, about its axes, without gravity [m/s^2].
        covariance: (3, 3).
        used: Three truth values.
        mount: Transform: the sensor in the robot.
        rates: (3,) angular rates of the robot [rad/s].
        rates_change: (3,) their change [rad/s^2].
    """
    arm, rotation = mount.translation, mount.rotation
    value = rotation @ measured
    if arm.any():
        value = value - cross(rates_change, arm) - cross(rates, cross(rates, arm))
    return StateValues().set(
        ACCELERATION,
        rotated(rotation, used),
        value,
        rotation @ np.asarray(covariance, float) @ rotation.T,
    )


def gravity_of(attitude, strength):
    """What an accelerometer at rest reads.

    Args:
        attitude: (3, 3) of the sensor in the world.
        strength: Of gravity [m/s^2].

    Returns:
        (3,) about the sensor's axes [m/s^2].
    """
    return attitude.T @ (0.0, 0.0, strength)
