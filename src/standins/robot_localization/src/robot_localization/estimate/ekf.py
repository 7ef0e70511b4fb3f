"""An extended Kalman filter over the 15 numbers of the state."""

import math

import numpy as np

from robot_localization.estimate.motion import advance
from robot_localization.estimate.state import ANGLES, POSE, PROCESS_NOISE, SIZE, TWIST
from robot_localization.rotation import wrap

FIRST_VARIANCE = 1e-9  # of each number before the first measurement
LEAST_VARIANCE = 1e-9  # of a measured number
UNIT = np.eye(SIZE)
LONGEST_STEP = 1e5  # a longer one is a clock that was not set yet [s]
STEP_INSTEAD = 0.01  # [s]


class Ekf:
    """State, covariance, and the time that they are of.

    Args:
        process_noise: (15, 15) covariance that grows in each second.
        state: (15,) first state; zeros if not given.
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
        """Back to the first state and covariance, without a measurement."""
        self.state = self._first_state.copy()
        self.covariance = self._first_covariance.copy()
        self.initialized = False

    def process(self, measurement):
        """Takes a measurement: predicts up to its time and corrects.

        The first one sets the numbers that it measures. One from before the filter's time corrects
        the present state.

        Returns:
            Whether it was taken; False for an outlier.
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
        """Moves state and covariance on by a step [s]; the filter's time stays as it is."""
        if step > LONGEST_STEP:
            step = STEP_INSTEAD
        noise = self._noise
        if self._scaled:
            noise = noise.copy()
            noise[POSE, POSE] *= self.state[TWIST] @ self.state[TWIST]
        self.state, jacobian = advance(self.state, step)
        self.covariance = jacobian @ self.covariance @ jacobian.T + step * noise

    def correct(self, measurement):
        """Corrects the state by a measurement of its own time; False for an outlier."""
        index, value, noise = _usable(measurement)
        if not index.size:
            return False
        innovation = value - self.state[index]
        for place in np.flatnonzero((index >= ANGLES.start) & (index < ANGLES.stop)):
            innovation[place] = wrap(innovation[place])
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
        rest = UNIT.copy()
        rest[:, index] -= gain
        self.covariance = rest @ self.covariance @ rest.T + gain @ noise @ gain.T
        return True


def _usable(measurement):
    """Index, value and covariance of the finite numbers, with variances that can be inverted."""
    index, value, covariance = measurement.index, measurement.value, measurement.covariance
    variance = covariance.diagonal()
    good = np.isfinite(value) & np.isfinite(variance)
    if not good.all():
        index, value, variance = index[good], value[good], variance[good]
        covariance = covariance[np.ix_(good, good)]
    covariance = np.where(np.isfinite(covariance), covariance, 0.0)
    covariance[np.diag_indices(len(index))] = np.maximum(np.abs(variance), LEAST_VARIANCE)
    return index, value, covariance
