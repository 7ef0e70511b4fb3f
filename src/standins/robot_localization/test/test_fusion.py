"""Measurements in the order of their times, late ones, silence."""

import numpy as np
import pytest
from robot_localization.ekf import Ekf, Fusion, Measurement

X, VX = 0, 6


def measured(time, value, place=X, variance=0.01, threshold=float("inf")):
    return Measurement(
        "test", time, np.array([place]), np.array([value]), np.array([[variance]]), threshold
    )


def fusion(**options):
    return Fusion(Ekf(), 0.1, **options)


def test_the_order_of_arrival_does_not_matter():
    items = [measured(0.01 * k, 0.02 * k, (X, VX)[k % 2]) for k in range(40)]
    states = []
    for seed in range(3):
        item = fusion()
        for place in np.random.default_rng(seed).permutation(len(items)):
            item.add(items[place])
        item.advance(1.0)
        states.append(item.ekf.state)
    assert states[0] == pytest.approx(states[1], abs=1e-12)
    assert states[0] == pytest.approx(states[2], abs=1e-12)


def test_what_is_of_the_future_waits():
    item = fusion()
    item.add(measured(1.0, 5.0))
    item.advance(0.9)
    assert not item.ekf.initialized
    item.advance(1.0)
    assert item.ekf.state[X] == 5.0


def test_silence_is_predicted_over_after_the_timeout():
    item = fusion()
    for place, value in ((X, 0.0), (VX, 2.0)):
        item.add(measured(1.0, value, place))
    item.advance(1.0)
    at_rest = item.ekf.state[X]
    item.advance(1.05)
    assert item.ekf.time == 1.0 and item.ekf.state[X] == at_rest
    item.advance(1.5)
    assert item.ekf.time == 1.5
    assert item.ekf.state[X] == pytest.approx(at_rest + 0.5 * item.ekf.state[VX])


def test_to_the_present_each_time():
    item = fusion(to_now=True)
    item.add(measured(1.0, 0.0))
    item.advance(1.02)
    assert item.ekf.time == 1.02


def test_a_late_measurement_with_a_history_is_as_if_it_had_come_in_time():
    items = [measured(0.1 * k, float(k), X) for k in range(1, 11)]
    late = measured(0.45, 3.0, VX, 0.001)
    in_time, lagged = fusion(history=2.0), fusion(history=2.0)
    for item in [*items[:4], late, *items[4:]]:
        in_time.add(item)
        in_time.advance(item.time)
    for item in items:
        lagged.add(item)
        lagged.advance(item.time)
    before = lagged.ekf.state.copy()
    lagged.add(late)
    lagged.advance(1.0)
    assert lagged.ekf.time == pytest.approx(1.0)
    assert lagged.ekf.state == pytest.approx(in_time.ekf.state, abs=1e-12)
    assert lagged.ekf.covariance == pytest.approx(in_time.ekf.covariance, abs=1e-12)
    assert lagged.ekf.state != pytest.approx(before, abs=1e-3)


def test_a_history_too_short_goes_back_as_far_as_it_can():
    item = fusion(history=0.2)
    for count in range(1, 11):
        item.add(measured(0.1 * count, float(count)))
        item.advance(0.1 * count)
    item.add(measured(0.25, 2.0))
    item.advance(1.0)
    assert item.ekf.time == pytest.approx(1.0)
    assert np.isfinite(item.ekf.state).all()
    item.add(measured(0.85, 8.0))
    item.advance(1.0)
    assert item.ekf.time == pytest.approx(1.0)


def test_outliers_are_counted():
    item = fusion()
    item.add(measured(0.0, 0.0))
    item.add(measured(0.01, 50.0, threshold=3.0))
    item.advance(0.1)
    assert item.outliers() == 1 and item.outliers() == 0


def test_clear_forgets_what_waits():
    item = fusion()
    item.add(measured(0.0, 1.0))
    item.clear()
    item.advance(1.0)
    assert not item.ekf.initialized
