"""The extended Kalman filter: state, motion model, fusion of measurements.

The motion model: constant acceleration and constant angular rates in the robot's frame. Position
moves with velocity v and acceleration a, rotated into the world by the angles q, which move with
the rates w:

    p' = p + R(q_m) (v dt + a dt^2 / 2),  q' = q + T(q_m) w dt,  v' = v + a dt,
    q_m = q + T(q) w dt / 2

T maps rates to the angles' derivatives. R and T at the midpoint make the error of a rotation of
third order in the step.
"""

import heapq
import itertools
import math
from collections import deque
from dataclasses import dataclass

import numpy as np

from robot_localization.frames import matrix, wrap

NAMES = (
    "x",
    "y",
    "z",
    "roll",
    "pitch",
    "yaw",
    "x_velocity",
    "y_velocity",
    "z_velocity",
    "roll_velocity",
    "pitch_velocity",
    "yaw_velocity",
    "x_acceleration",
    "y_acceleration",
    "z_acceleration",
)
SIZE = len(NAMES)
POSITION = slice(0, 3)  # in the world frame [m]
ANGLES = slice(3, 6)  # roll, pitch, yaw in the world frame [rad]
POSE = slice(0, 6)
VELOCITY = slice(6, 9)  # in the robot's frame [m/s]
RATES = slice(9, 12)  # in the robot's frame [rad/s]
TWIST = slice(6, 12)
ACCELERATION = slice(12, 15)  # in the robot's frame [m/s^2]
OUT_OF_PLANE = (2, 3, 4, 8, 9, 10, 14)  # z, roll, pitch and their rates, z acceleration

# Upstream's default: variances that grow in each second.
PROCESS_NOISE = np.diag(
    (0.05, 0.05, 0.06, 0.03, 0.03, 0.06, 0.025, 0.025, 0.04, 0.01, 0.01, 0.02, 0.01, 0.01, 0.015)
)


@dataclass(frozen=True)
class Measurement:
    """Measured values of the state.

    Attributes:
        source: Name of the input.
        time: When it was measured [s].
        index: (n,) indices of the state.
        value: (n,).
        covariance: (n, n).
        threshold: Mahalanobis distance from which on it counts as an outlier.
    """

    source: str
    time: float
    index: np.ndarray
    value: np.ndarray
    covariance: np.ndarray
    threshold: float = float("inf")


MIN_COSINE = 1e-6  # minimum cosine of the pitch in divisions
UNIT_3 = np.eye(3)


def advance(state, step):
    """Predicts a state.

    Args:
        state: (15,).
        step: Time [s].

    Returns:
        (state (15,), its derivative by the state before (15, 15)).
    """
    rates = state[RATES]
    rate_matrix, rate_matrix_by_angles = _angle_rates(state[ANGLES], rates)
    midpoint = state[ANGLES] + 0.5 * step * (rate_matrix @ rates)
    midpoint_by_angles = UNIT_3 + 0.5 * step * rate_matrix_by_angles
    midpoint_by_rates = 0.5 * step * rate_matrix
    rate_matrix, rate_matrix_by_midpoint = _angle_rates(midpoint, rates)
    displacement = step * state[VELOCITY] + 0.5 * step * step * state[ACCELERATION]
    rotation = matrix(*midpoint)
    displacement_by_midpoint = _rotated_by_angles(midpoint, rotation, displacement)

    after = state.copy()
    after[POSITION] += rotation @ displacement
    after[ANGLES] += step * (rate_matrix @ rates)
    after[ANGLES] = [wrap(angle) for angle in after[ANGLES]]
    after[VELOCITY] += step * state[ACCELERATION]

    jacobian = np.eye(SIZE)
    jacobian[POSITION, ANGLES] = displacement_by_midpoint @ midpoint_by_angles
    jacobian[POSITION, RATES] = displacement_by_midpoint @ midpoint_by_rates
    jacobian[POSITION, VELOCITY] = step * rotation
    jacobian[POSITION, ACCELERATION] = 0.5 * step * step * rotation
    jacobian[ANGLES, ANGLES] += step * (rate_matrix_by_midpoint @ midpoint_by_angles)
    jacobian[ANGLES, RATES] = step * (rate_matrix + rate_matrix_by_midpoint @ midpoint_by_rates)
    jacobian[VELOCITY, ACCELERATION] = step * UNIT_3
    return after, jacobian


def _angle_rates(angles, rates):
    """T of the angles, and the derivative of T w by the angles; both (3, 3)."""
    roll, pitch = angles[0], angles[1]
    sr, cr, sp, cp = math.sin(roll), math.cos(roll), math.sin(pitch), math.cos(pitch)
    cp = math.copysign(max(abs(cp), MIN_COSINE), cp)
    tp = sp / cp
    _, p, q = rates
    rate_matrix = np.array(((1.0, sr * tp, cr * tp), (0.0, cr, -sr), (0.0, sr / cp, cr / cp)))
    by_roll, by_pitch = cr * p - sr * q, sr * p + cr * q
    return rate_matrix, np.array(
        (
            (by_roll * tp, by_pitch / (cp * cp), 0.0),
            (-by_pitch, 0.0, 0.0),
            (by_roll / cp, by_pitch * tp / cp, 0.0),
        )
    )


def _rotated_by_angles(angles, rotation, vector):
    """Derivative of R(angles) vector by the angles, (3, 3)."""
    x, y, z = vector
    rx, ry, _ = rotation @ vector
    sy, cy = math.sin(angles[2]), math.cos(angles[2])
    sp, cp = math.sin(angles[1]), math.cos(angles[1])
    sr, cr = math.sin(angles[0]), math.cos(angles[0])
    by_roll = rotation @ (0.0, -z, y)
    forward_part = -sp * x + cp * (sr * y + cr * z)  # of Ry Rx vector, by the pitch
    down = -cp * x - sp * (sr * y + cr * z)
    return np.array(
        (
            (by_roll[0], cy * forward_part, -ry),
            (by_roll[1], sy * forward_part, rx),
            (by_roll[2], down, 0.0),
        )
    )


SAME_TIME = 1e-9  # [s]


class Fusion:
    """A queue in front of a filter.

    Args:
        sensor_timeout: Time without a measurement after which the state is predicted [s].
        to_now: Whether to predict up to the present each time.
        history: Maximum age of a late measurement [s]; None: late ones correct the present
            state. With a history the filter goes back and repeats all measurements since then.
    """

    def __init__(self, ekf, sensor_timeout, to_now=False, history=None):
        self.ekf = ekf
        self._timeout, self._to_now, self._length = sensor_timeout, to_now, history
        self._count = itertools.count()
        self._outliers = 0
        self.clear()

    def clear(self):
        """Clears the queue and the history."""
        self._queue = []
        self._states, self._processed = deque(), deque()

    def add(self, measurement):
        """Puts a measurement into the queue."""
        heapq.heappush(self._queue, (measurement.time, next(self._count), measurement))

    def outliers(self):
        """How many measurements were outliers since the last call."""
        count, self._outliers = self._outliers, 0
        return count

    def advance(self, now):
        """Processes all measurements up to now [s], and predicts if that is due."""
        ekf, due = self.ekf, self._to_now
        if self._queue:
            if self._length is not None and self._queue[0][0] < ekf.time and ekf.initialized:
                self._rewind(self._queue[0][0])
            while self._queue and self._queue[0][0] <= now:
                self._process(heapq.heappop(self._queue)[2])
        elif ekf.initialized and now - ekf.time >= self._timeout:
            due = True
        if ekf.initialized and due and now > ekf.time:
            ekf.predict(now - ekf.time)
            ekf.time = now
        if self._length is not None:
            self._drop_before(ekf.time - self._length)

    def _process(self, measurement):
        if not self.ekf.process(measurement):
            self._outliers += 1
        if self._length is None:
            return
        self._processed.append(measurement)
        if not self._queue or abs(self._queue[0][0] - self.ekf.time) > SAME_TIME:
            ekf = self.ekf
            self._states.append((ekf.time, ekf.state.copy(), ekf.covariance.copy()))

    def _rewind(self, time):
        """Restores the last state before a time, or the oldest; queues later measurements again."""
        oldest = None
        while self._states and self._states[-1][0] > time - SAME_TIME:
            oldest = self._states.pop()
        if self._states:
            oldest = self._states[-1]
        elif oldest is not None:
            self._states.append(oldest)
        else:
            return
        ekf = self.ekf
        ekf.time, ekf.state, ekf.covariance = oldest[0], oldest[1].copy(), oldest[2].copy()
        while self._processed and self._processed[-1].time > ekf.time + SAME_TIME:
            self.add(self._processed.pop())

    def _drop_before(self, time):
        while self._processed and self._processed[0].time < time:
            self._processed.popleft()
        while self._states and self._states[0][0] < time:
            self._states.popleft()


FIRST_VARIANCE = 1e-9  # of each value before the first measurement
MIN_VARIANCE = 1e-9  # of a measured value
UNIT = np.eye(SIZE)
LONGEST_STEP = 1e5  # a longer one is a clock that was not set yet [s]
STEP_INSTEAD = 0.01  # [s]


class Ekf:
    """State, covariance and their time.

    Args:
        process_noise: (15, 15) covariance that grows in each second.
        state: (15,) first state; None: zeros.
        covariance: (15, 15) first covariance.
        scaled_noise: Whether the pose's process noise grows with the square of the speed.

    Attributes:
        state: (15,).
        covariance: (15, 15).
        time: Of the last measurement, or prediction [s].
        initialized: Whether there was a measurement.
    """

    def __init__(
        self, process_noise=PROCESS_NOISE, state=None, covariance=None, scaled_noise=False
    ):
        self._noise, self._scaled = np.array(process_noise, float), scaled_noise
        self._first_state = np.zeros(SIZE) if state is None else np.array(state, float)
        self._first_covariance = (
            FIRST_VARIANCE * np.eye(SIZE) if covariance is None else np.array(covariance, float)
        )
        self.time = 0.0
        self.reset()

    def reset(self):
        """Resets to the first state and covariance, without a measurement."""
        self.state = self._first_state.copy()
        self.covariance = self._first_covariance.copy()
        self.initialized = False

    def process(self, measurement):
        """Processes a measurement: predicts up to its time and corrects.

        The first one sets the values that it measures. One from before the filter's time corrects
        the present state.

        Returns:
            Whether it was used; False for an outlier.
        """
        if not self.initialized:
            self._start(measurement)
            return True
        step = measurement.time - self.time
        if step > 0.0:
            self.predict(step)
            self.time = measurement.time
        return self.correct(measurement)

    def _start(self, measurement):
        index, value, covariance = _usable(measurement)
        self.state[index] = value
        self.covariance[np.ix_(index, index)] = covariance
        self.initialized, self.time = True, measurement.time

    def predict(self, step):
        """Predicts state and covariance after a step [s]; the filter's time stays."""
        if step > LONGEST_STEP:
            step = STEP_INSTEAD
        noise = self._noise
        if self._scaled:
            noise = noise.copy()
            noise[POSE, POSE] *= self.state[TWIST] @ self.state[TWIST]
        self.state, jacobian = advance(self.state, step)
        self.covariance = jacobian @ self.covariance @ jacobian.T + step * noise

    def correct(self, measurement):
        """Corrects the state by a measurement of the same time; False for an outlier."""
        index, value, noise = _usable(measurement)
        if not index.size:
            return False
        innovation = value - self.state[index]
        for entry in np.flatnonzero((index >= ANGLES.start) & (index < ANGLES.stop)):
            innovation[entry] = wrap(innovation[entry])
        cross = self.covariance[:, index]
        expected = cross[index] + noise
        try:
            inverse = np.linalg.inv(expected)
        except np.linalg.LinAlgError:
            return False
        if math.sqrt(max(0.0, innovation @ inverse @ innovation)) >= measurement.threshold:
            return False
        gain = cross @ inverse
        self.state = self.state + gain @ innovation
        self.state[ANGLES] = [wrap(angle) for angle in self.state[ANGLES]]
        # Joseph's form keeps the covariance symmetric and positive.
        complement = UNIT.copy()
        complement[:, index] -= gain
        self.covariance = complement @ self.covariance @ complement.T + gain @ noise @ gain.T
        return True


def _usable(measurement):
    """Index, value and covariance of the finite values, with variances that can be inverted."""
    index, value, covariance = measurement.index, measurement.value, measurement.covariance
    variance = covariance.diagonal()
    finite = np.isfinite(value) & np.isfinite(variance)
    if not finite.all():
        index, value, variance = index[finite], value[finite], variance[finite]
        covariance = covariance[np.ix_(finite, finite)]
    covariance = np.where(np.isfinite(covariance), covariance, 0.0)
    covariance[np.diag_indices(len(index))] = np.maximum(np.abs(variance), MIN_VARIANCE)
    return index, value, covariance
