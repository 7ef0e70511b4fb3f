"""Data of sensors in the filter's frames, as measurements of its state.

A sensor's `used` truth values are about the sensor's axes. They are rotated like its data: a
value of the state counts as measured when a used axis has a component in it.
"""

import numpy as np

from robot_localization.ekf import (
    ACCELERATION,
    OUT_OF_PLANE,
    POSE,
    SIZE,
    TWIST,
    Measurement,
    usable_covariance,
)
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
            covariance = spread(base.rotation.T, covariance)
        return StateValues().set(
            POSE,
            rotated(frame.rotation, used),
            self.place(pose, frame, base),
            spread(frame.rotation, covariance),
        )

    def place(self, pose, frame=IDENTITY, base=IDENTITY):
        """The values alone of process(), of a sensor that is not differential: six numbers."""
        if base is not IDENTITY:
            pose = pose.of(base)
        if self._relative:
            self._first = pose if self._first is None else self._first
            pose = self._first.inverse().of(pose)
        if frame is not IDENTITY:
            pose = frame.of(pose)
        return (*pose.translation.tolist(), *angles(pose.rotation).tolist())

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
        pose = attitude_of(rotation, mount)
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


def attitude_of(rotation, mount):
    """Transform of a robot from the (3, 3) attitude of an IMU that is mounted on it, at 0."""
    if mount is not IDENTITY:
        rotation = rotation @ mount.rotation.T
    return Transform(rotation, IDENTITY.translation)


def twist(linear, angular, covariance, used, mount=IDENTITY, rates=None):
    """Velocities of the robot.

    Args:
        linear: (3,) of the sensor, about its axes [m/s].
        angular: (3,) [rad/s].
        covariance: (6, 6).
        used: Six truth values.
        mount: Transform: the sensor in the robot.
        rates: (3,) angular rates of the robot, for a sensor off its center [rad/s];
            None: `angular`.
    """
    return StateValues().set(
        TWIST,
        rotated(mount.rotation, used),
        velocities(linear, angular, mount, rates),
        spread(mount.rotation, covariance),
    )


def velocities(linear, angular, mount=IDENTITY, rates=None):
    """The values alone of twist(): six numbers."""
    if mount is IDENTITY:
        return (*linear, *angular)
    angular = mount.rotation @ angular
    rates = angular if rates is None else rates
    linear = mount.rotation @ linear + cross(mount.translation, rates)
    return (*linear.tolist(), *angular.tolist())


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
    rotation = mount.rotation
    return StateValues().set(
        ACCELERATION,
        rotated(rotation, used),
        at_center(measured, mount, rates, rates_change),
        rotation @ np.asarray(covariance, float) @ rotation.T,
    )


def at_center(measured, mount, rates, rates_change):
    """The values alone of acceleration(): three numbers."""
    if mount is IDENTITY:
        return tuple(measured)
    arm, value = mount.translation, mount.rotation @ measured
    if arm.any():
        value = value - cross(rates_change, arm) - cross(rates, cross(rates, arm))
    return tuple(value.tolist())


def gravity_of(attitude, strength):
    """What an accelerometer at rest reads.

    Args:
        attitude: (3, 3) of the sensor in the world.
        strength: Of gravity [m/s^2].

    Returns:
        (3,) about the sensor's axes [m/s^2].
    """
    return attitude.T @ (0.0, 0.0, strength)


LARGEST_SQUARE = 1e290  # of values whose Mahalanobis distance is a number, with MIN_VARIANCE


class Selection:
    """Which values a sensor measures and how sure it is, for all messages that agree in that.

    Args:
        part: POSE, TWIST or ACCELERATION.
        values: StateValues of one of the messages.
        planar: Whether they are flattened.

    Attributes:
        index: (n,) indices of the state.
        covariance: (n, n).
    """

    def __init__(self, part, values, planar):
        self.index, _, self.covariance = values.select()
        self._usable = bool(np.isfinite(self.covariance.diagonal()).all())
        if self._usable:
            self.covariance = usable_covariance(self.covariance)
        zero = part.stop - part.start
        self._places = [
            zero
            if not part.start <= index < part.stop or (planar and index in OUT_OF_PLANE)
            else index - part.start
            for index in self.index.tolist()
        ]

    def measurement(self, source, time, numbers, threshold):
        """Measurement of a message: the numbers of the part in its order."""
        numbers = (*numbers, 0.0)
        value = np.array([numbers[place] for place in self._places])
        checked = self._usable and value.dot(value) < LARGEST_SQUARE
        return Measurement(source, time, self.index, value, self.covariance, threshold, checked)


NO_CORRELATION = 1e-12  # of two values that count as independent


class Joint:
    """Measurements of one time as one, for all messages that agree in index and covariance.

    One correction by several independent measurements gives the same as one after the other, and
    costs hardly more than one. A value that several measure is measured by their weighted mean.

    Args:
        measurements: Of the first message, without thresholds, all of them checked.
    """

    def __init__(self, measurements):
        self._covariances = [item.covariance for item in measurements]
        index = np.concatenate([item.index for item in measurements])
        ends = np.cumsum([0] + [item.index.size for item in measurements])
        noise = np.zeros((index.size, index.size))
        for start, end, covariance in zip(ends, ends[1:], self._covariances):
            noise[start:end, start:end] = covariance
        self.possible, self._weights = True, None
        self.index, self.covariance = index, noise
        unique = np.unique(index)
        if unique.size < index.size:
            variance = noise.diagonal()
            bound = NO_CORRELATION * np.sqrt(np.outer(variance, variance)) + np.diag(variance)
            self.possible = bool((np.abs(noise) <= bound).all())
            information = (unique[:, None] == index) / variance
            total = information.sum(axis=1)
            self.index, self.covariance = unique, np.diag(1.0 / total)
            self._weights = information / total[:, None]

    def fits(self, measurements):
        """Whether it is for these measurements."""
        covariances = self._covariances
        return len(covariances) == len(measurements) and all(
            item.covariance is covariance for item, covariance in zip(measurements, covariances)
        )

    def measurement(self, measurements):
        """One Measurement for all."""
        value = np.concatenate([item.value for item in measurements])
        if self._weights is not None:
            value = self._weights.dot(value)
        first = measurements[0]
        return first._replace(index=self.index, value=value, covariance=self.covariance)
