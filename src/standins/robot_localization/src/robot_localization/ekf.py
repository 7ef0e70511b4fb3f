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
import struct
from collections import deque
from typing import NamedTuple

import numpy as np

from robot_localization.frames import wrap

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


class Measurement(NamedTuple):
    """Measured values of the state.

    Attributes:
        source: Name of the input.
        time: When it was measured [s].
        index: (n,) indices of the state.
        value: (n,).
        covariance: (n, n).
        threshold: Mahalanobis distance from which on it counts as an outlier.
        checked: Whether all numbers are finite and no variance is below MIN_VARIANCE.
    """

    source: str
    time: float
    index: np.ndarray
    value: np.ndarray
    covariance: np.ndarray
    threshold: float = float("inf")
    checked: bool = False


MIN_COSINE = 1e-6  # minimum cosine of the pitch in divisions
UNIT = np.eye(SIZE)
UPPER_ROWS = struct.Struct(f"={6 * SIZE}d")  # of a Jacobian: those of the pose
# In a flat Jacobian: the derivatives of the velocities by the accelerations.
VELOCITY_BY_ACCELERATION = slice(6 * SIZE + 12, 9 * SIZE, SIZE + 1)


def advance(state, step):
    """Predicts a state.

    Plain numbers: for matrices of 3 by 3 numpy's calls take several times as long.

    Args:
        state: (15,).
        step: Time [s].

    Returns:
        (state (15,), its derivative by the state before (15, 15)).
    """
    x, y, z, roll, pitch, yaw, u, v, w, p, q, r, ax, ay, az = state.tolist()
    half = 0.5 * step
    sr, cr = math.sin(roll), math.cos(roll)
    sp, cp = math.sin(pitch), math.cos(pitch)
    cp = math.copysign(max(abs(cp), MIN_COSINE), cp)
    tp = sp / cp
    # T = ((1, sr tp, cr tp), (0, cr, -sr), (0, sr / cp, cr / cp)); T w and its derivative:
    by_roll, by_pitch = cr * q - sr * r, sr * q + cr * r
    roll_m = roll + half * (p + tp * by_pitch)
    pitch_m = pitch + half * by_roll
    yaw_m = yaw + half * (by_pitch / cp)
    # Derivatives of the midpoint, m by the angles (its last column is that of the yaw: 0, 0, 1), n
    # by the rates (its first column is half, 0, 0).
    m00, m01 = 1.0 + half * (by_roll * tp), half * (by_pitch / (cp * cp))
    m10, m20 = -half * by_pitch, half * (by_roll / cp)
    m21 = half * (by_pitch * tp / cp)
    n01, n02, n11, n12 = half * (sr * tp), half * (cr * tp), half * cr, -half * sr
    n21, n22 = half * (sr / cp), half * (cr / cp)

    sr, cr = math.sin(roll_m), math.cos(roll_m)
    sp, cp = math.sin(pitch_m), math.cos(pitch_m)
    sy, cy = math.sin(yaw_m), math.cos(yaw_m)
    r00, r01, r02 = cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr
    r10, r11, r12 = sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr
    r20, r21, r22 = -sp, cp * sr, cp * cr
    late = half * step
    i, j, k = step * u + late * ax, step * v + late * ay, step * w + late * az
    dx = r00 * i + r01 * j + r02 * k
    dy = r10 * i + r11 * j + r12 * k
    dz = r20 * i + r21 * j + r22 * k
    # Derivative of the displacement by the midpoint's angles, (a, b, c) by rows; c = (-dy, dx, 0).
    a0, a1, a2 = r02 * j - r01 * k, r12 * j - r11 * k, r22 * j - r21 * k
    forward = -sp * i + cp * (sr * j + cr * k)  # of Ry Rx displacement, by the pitch
    b0, b1, b2 = cy * forward, sy * forward, -cp * i - sp * (sr * j + cr * k)

    cp = math.copysign(max(abs(cp), MIN_COSINE), cp)
    tp = sp / cp
    by_roll, by_pitch = cr * q - sr * r, sr * q + cr * r
    # Derivative e of T w by the midpoint's angles; its last column is 0.
    e00, e01 = by_roll * tp, by_pitch / (cp * cp)
    e20, e21 = by_roll / cp, by_pitch * tp / cp
    after = np.array(
        (
            x + dx,
            y + dy,
            z + dz,
            wrap(roll + step * (p + tp * by_pitch)),
            wrap(pitch + step * by_roll),
            wrap(yaw + step * (by_pitch / cp)),
            u + step * ax,
            v + step * ay,
            w + step * az,
            p,
            q,
            r,
            ax,
            ay,
            az,
        )
    )
    # The rows by columns: position, angles, velocity, rates, acceleration.
    jacobian = UNIT.copy()
    UPPER_ROWS.pack_into(
        jacobian,
        0,
        *(1.0, 0.0, 0.0),
        *(a0 * m00 + b0 * m10 - dy * m20, a0 * m01 + b0 - dy * m21, -dy),
        *(step * r00, step * r01, step * r02),
        *(a0 * half, a0 * n01 + b0 * n11 - dy * n21, a0 * n02 + b0 * n12 - dy * n22),
        *(late * r00, late * r01, late * r02),
        *(0.0, 1.0, 0.0),
        *(a1 * m00 + b1 * m10 + dx * m20, a1 * m01 + b1 + dx * m21, dx),
        *(step * r10, step * r11, step * r12),
        *(a1 * half, a1 * n01 + b1 * n11 + dx * n21, a1 * n02 + b1 * n12 + dx * n22),
        *(late * r10, late * r11, late * r12),
        *(0.0, 0.0, 1.0),
        *(a2 * m00 + b2 * m10, a2 * m01 + b2, 0.0),
        *(step * r20, step * r21, step * r22),
        *(a2 * half, a2 * n01 + b2 * n11, a2 * n02 + b2 * n12),
        *(late * r20, late * r21, late * r22),
        *(0.0, 0.0, 0.0),
        *(1.0 + step * (e00 * m00 + e01 * m10), step * (e00 * m01 + e01), 0.0),
        *(0.0, 0.0, 0.0),
        *(step * (1.0 + e00 * half), step * (sr * tp + e00 * n01 + e01 * n11)),
        *(step * (cr * tp + e00 * n02 + e01 * n12), 0.0, 0.0, 0.0),
        *(0.0, 0.0, 0.0),
        *(-step * by_pitch * m00, 1.0 - step * by_pitch * m01, 0.0),
        *(0.0, 0.0, 0.0),
        *(-step * by_pitch * half, step * (cr - by_pitch * n01), -step * (sr + by_pitch * n02)),
        *(0.0, 0.0, 0.0),
        *(0.0, 0.0, 0.0),
        *(step * (e20 * m00 + e21 * m10), step * (e20 * m01 + e21), 1.0),
        *(0.0, 0.0, 0.0),
        *(step * (e20 * half), step * (sr / cp + e20 * n01 + e21 * n11)),
        *(step * (cr / cp + e20 * n02 + e21 * n12), 0.0, 0.0, 0.0),
    )
    jacobian.reshape(-1)[VELOCITY_BY_ACCELERATION] = step
    return after, jacobian


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
        index, value, covariance = usable(measurement)
        self.state[index] = value
        self.covariance[np.ix_(index, index)] = covariance
        self.initialized, self.time = True, measurement.time

    def noise(self):
        """Process noise (15, 15) of a second."""
        if not self._scaled:
            return self._noise
        noise = self._noise.copy()
        noise[POSE, POSE] *= self.state[TWIST] @ self.state[TWIST]
        return noise

    def predict(self, step):
        """Predicts state and covariance after a step [s]; the filter's time stays."""
        if step > LONGEST_STEP:
            step = STEP_INSTEAD
        noise = self.noise()
        self.state, jacobian = advance(self.state, step)
        covariance = jacobian.dot(self.covariance).dot(jacobian.T)
        covariance += step * noise
        self.covariance = covariance

    def correct(self, measurement):
        """Corrects the state by a measurement of the same time; False for an outlier."""
        index, value, noise = usable(measurement)
        if not index.size:
            return False
        innovation = value - self.state.take(index)
        gaps = innovation.tolist()
        if max(gaps) > math.pi or min(gaps) < -math.pi:
            for entry, position in enumerate(index.tolist()):
                if ANGLES.start <= position < ANGLES.stop:
                    innovation[entry] = wrap(gaps[entry])
        covariance = self.covariance
        cross = covariance.take(index, 1)
        expected = cross.take(index, 0)
        expected += noise
        try:
            inverse = np.linalg.inv(expected)
        except np.linalg.LinAlgError:
            return False
        weighted = inverse.dot(innovation)
        if math.sqrt(max(0.0, innovation.dot(weighted))) >= measurement.threshold:
            return False
        gain = cross.dot(inverse)
        state = cross.dot(weighted)
        state += self.state
        angles = state[ANGLES].tolist()
        if max(angles) > math.pi or min(angles) < -math.pi:
            state[ANGLES] = [wrap(angle) for angle in angles]
        self.state = state
        # Joseph's form keeps the covariance symmetric and positive.
        complement = UNIT - gain.dot(UNIT.take(index, 0))
        after = complement.dot(covariance).dot(complement.T)
        after += gain.dot(noise).dot(gain.T)
        self.covariance = after
        return True


def usable(measurement):
    """Index, value and covariance of the finite values, with variances that can be inverted."""
    index, value, covariance = measurement.index, measurement.value, measurement.covariance
    if measurement.checked:
        return index, value, covariance
    finite = np.isfinite(value) & np.isfinite(covariance.diagonal())
    if not finite.all():
        index, value = index[finite], value[finite]
        covariance = covariance[np.ix_(finite, finite)]
    return index, value, usable_covariance(covariance)


def usable_covariance(covariance):
    """An (n, n) covariance with finite variances as one that can be inverted, a copy."""
    variance = covariance.diagonal()
    covariance = np.where(np.isfinite(covariance), covariance, 0.0)
    covariance[np.diag_indices(len(variance))] = np.maximum(np.abs(variance), MIN_VARIANCE)
    return covariance
