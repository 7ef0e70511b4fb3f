"""The unscented Kalman filter: the same state and motion model, carried by 31 points.

The points lie around the state by the columns of a square root of the covariance. Where upstream's
filter differs from the textbook, this one does, too, because people tuned their noises with it:
after a correction the covariance loses K P_zz K' with the P_zz of the points alone, without the
measurement's noise. The filter stays less sure of itself than the extended one, and follows
faster.
"""

import math

import numpy as np

from robot_localization.ekf import ANGLES, LONGEST_STEP, MIN_COSINE, SIZE, STEP_INSTEAD, Ekf, usable

IS_ANGLE = np.zeros(SIZE, bool)
IS_ANGLE[ANGLES] = True


class Ukf(Ekf):
    """An Ekf whose steps are those of the unscented transform.

    Args:
        alpha: How far from the state the points lie, relative to the standard deviations.
        kappa: Added to the number of states, in that distance.
        beta: Weight of the middle point; 2 suits normal distributions.
        others: Of an Ekf.

    Raises:
        ValueError: alpha or SIZE + kappa is not positive.
    """

    def __init__(self, *others, alpha=0.001, kappa=0.0, beta=2.0, **more):
        self._scale = alpha * alpha * (SIZE + kappa)
        if not (alpha > 0.0 and self._scale > 0.0):
            raise ValueError(f"alpha is {alpha:g} and kappa {kappa:g}, must be above 0 and {-SIZE}")
        # The mean is taken from the middle point, which so has no weight in it.
        self._weight = 0.5 / self._scale
        self._middle = 2.0 - SIZE / self._scale - alpha * alpha + beta
        super().__init__(*others, **more)

    def predict(self, step):
        """Predicts state and covariance after a step [s]; the filter's time stays."""
        if step > LONGEST_STEP:
            step = STEP_INSTEAD
        noise = self.noise()
        points = moved(self._points(), step)
        self.state, gaps = self._mean(points, IS_ANGLE)
        self.covariance = self._product(gaps, gaps) + step * noise

    def correct(self, measurement):
        """Corrects the state by a measurement of the same time; False for an outlier."""
        index, value, noise = usable(measurement)
        if not index.size:
            return False
        angular = IS_ANGLE[index]
        points = self._points()
        expected, gaps = self._mean(points[:, index], angular)
        spread = self._product(gaps, gaps)
        innovation = value - expected
        innovation[angular] = wrapped(innovation[angular])
        try:
            inverse = np.linalg.inv(spread + noise)
        except np.linalg.LinAlgError:
            return False
        if math.sqrt(max(0.0, innovation @ inverse @ innovation)) >= measurement.threshold:
            return False
        gain = self._product(points - self.state, gaps) @ inverse
        state = self.state + gain @ innovation
        state[ANGLES] = wrapped(state[ANGLES])
        self.state = state
        self.covariance = self.covariance - gain @ spread @ gain.T
        return True

    def _points(self):
        """Points (31, 15): the state, and it with each column of the root added and subtracted."""
        covariance = 0.5 * (self.covariance + self.covariance.T)
        try:
            root = np.linalg.cholesky(covariance)
        except np.linalg.LinAlgError:  # variances of 0, or just below by rounding
            variances, axes = np.linalg.eigh(covariance)
            root = axes * np.sqrt(np.maximum(variances, 0.0))
        steps = math.sqrt(self._scale) * root.T
        return np.vstack([self.state, self.state + steps, self.state - steps])

    def _mean(self, points, angular):
        """(mean (n,), differences (31, n) from it) of points, of which some values are angles."""
        gaps = points - points[0]
        gaps[:, angular] = wrapped(gaps[:, angular])
        shift = self._weight * gaps[1:].sum(axis=0)
        mean = points[0] + shift
        mean[angular] = wrapped(mean[angular])
        return mean, gaps - shift

    def _product(self, left, right):
        """Weighted sum of the products of differences, each (31, n)."""
        return self._weight * left[1:].T @ right[1:] + self._middle * np.outer(left[0], right[0])


def wrapped(angles):
    """Angles [rad] from -pi to pi."""
    return (angles + math.pi) % (2.0 * math.pi) - math.pi


def moved(points, step):
    """States (n, 15) after a step [s]; the motion model of ekf.advance."""
    columns = points.T
    position, angles, velocity = columns[0:3], columns[3:6], columns[6:9]
    rates, acceleration = columns[9:12], columns[12:15]
    halfway = angles + 0.5 * step * _by_rates(angles, rates)
    (sr, sp, sy), (cr, cp, cy) = np.sin(halfway), np.cos(halfway)
    i, j, k = step * velocity + 0.5 * step * step * acceleration
    level = cp * i + sp * (sr * j + cr * k)
    aside = cr * j - sr * k
    after = np.array(points)
    after[:, 0:3] = np.column_stack(
        [
            position[0] + cy * level - sy * aside,
            position[1] + sy * level + cy * aside,
            position[2] - sp * i + cp * (sr * j + cr * k),
        ]
    )
    after[:, 3:6] = (angles + step * _by_rates(halfway, rates)).T
    after[:, 6:9] += step * acceleration.T
    return after


def _by_rates(angles, rates):
    """Derivatives (3, n) of roll, pitch, yaw by angular rates about the robot's axes."""
    roll, pitch, _ = angles
    by_roll = np.sin(roll) * rates[1] + np.cos(roll) * rates[2]
    cosine = np.cos(pitch)
    cosine = np.copysign(np.maximum(np.abs(cosine), MIN_COSINE), cosine)
    by_pitch = np.cos(roll) * rates[1] - np.sin(roll) * rates[2]
    return np.array([rates[0] + np.sin(pitch) / cosine * by_roll, by_pitch, by_roll / cosine])
