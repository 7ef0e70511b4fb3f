"""The unscented filter: its motion, beside the extended filter, and what only it does."""

import math

import numpy as np
import pytest
from robot_localization.ekf import Ekf, Measurement, advance
from robot_localization.options import read_unscented
from robot_localization.ukf import Ukf, moved, wrapped

X, ROLL, YAW, VX, VYAW = 0, 3, 5, 6, 11


def measured(time, index, value, variance):
    return Measurement("test", time, np.array([index]), np.array([value]), np.array([[variance]]))


def started(kind, **more):
    """A filter at rest that knows all but the forward velocity well."""
    estimate = kind(covariance=np.diag([1e-4] * 6 + [0.25] + [1e-4] * 8), **more)
    estimate.initialized = True
    return estimate


def test_points_move_as_states_do():
    states = np.random.default_rng(3).uniform(-1.2, 1.2, (40, 15))
    after = moved(states, 0.05)
    for state, end in zip(states, after):
        expected, _ = advance(state, 0.05)
        assert end[:3] == pytest.approx(expected[:3], abs=1e-12)
        assert wrapped(end[3:6]) == pytest.approx(expected[3:6], abs=1e-12)
        assert end[6:] == pytest.approx(expected[6:], abs=1e-12)


def test_a_prediction_is_that_of_the_extended_filter_where_that_is_exact():
    ekf, ukf = started(Ekf), started(Ukf)
    for each in (ekf, ukf):
        each.state[VX] = 2.0
        each.predict(0.1)
    assert ukf.state[X] == pytest.approx(0.2, abs=1e-4)
    assert ukf.covariance[X, X] == pytest.approx(ekf.covariance[X, X], rel=1e-3)
    assert ukf.covariance[X, VX] == pytest.approx(ekf.covariance[X, VX], rel=1e-3)


def test_a_correction_does_not_count_the_noise_in_what_is_known():
    """A variance of 1, measured with a variance of 1: half the way; 1 - 1/4, textbook: 1 - 1/2."""
    ukf = Ukf(covariance=np.eye(15))
    assert ukf.correct(measured(0.0, X, 2.0, 1.0))
    assert ukf.state[X] == pytest.approx(1.0, rel=1e-6)
    assert ukf.covariance[X, X] == pytest.approx(0.75, rel=1e-6)


def test_an_angle_is_corrected_over_half_a_turn():
    ukf = Ukf(covariance=0.01 * np.eye(15))
    ukf.state[YAW] = 3.1
    ukf.correct(measured(0.0, YAW, -3.1, 0.01))
    assert abs(ukf.state[YAW]) == pytest.approx(math.pi, abs=1e-3)
    assert not ukf.correct(measured(0.0, YAW, 0.0, 0.01)._replace(threshold=2.0))


def test_it_follows_faster_than_the_extended_filter():
    """Ten measurements as sure as the state: a mean of all, 1/11 of the way left; less here."""
    left = []
    for kind in (Ekf, Ukf):
        estimate = kind(covariance=0.02 * np.eye(15))
        for _ in range(10):
            estimate.correct(measured(0.0, ROLL, 1.0, 0.02))
        left.append(abs(estimate.state[ROLL] - 1.0))
    assert left[0] == pytest.approx(1.0 / 11.0, rel=1e-6)
    variance, expected = 0.02, 1.0
    for _ in range(10):
        gain = variance / (variance + 0.02)
        variance, expected = variance * (1.0 - gain * gain), expected * (1.0 - gain)
    assert left[1] == pytest.approx(expected, rel=1e-4) and expected < 0.25 * left[0]


@pytest.mark.parametrize("alpha, kappa", [(0.0, 0.0), (0.1, -15.0), (-1.0, 0.0)])
def test_wrong_distances_of_the_points_are_named(alpha, kappa):
    with pytest.raises(ValueError, match="alpha is .*kappa"):
        Ukf(alpha=alpha, kappa=kappa)


def test_its_parameters():
    arguments, notes = read_unscented({"alpha": 0.1, "beta": "two", "frequency": 30})
    assert arguments == {"alpha": 0.1} and len(notes) == 1 and "beta is 'two'" in notes[0]
