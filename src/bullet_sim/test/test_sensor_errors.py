"""Errors of hector's sensors: offset, scale, noise, and a drift that starts, decays and wanders."""

import math

import numpy as np
import pytest
from bullet_sim.sensors.errors import ErrorModel, SensorErrors

THREE = (1.0, 1.0, 1.0)


def test_offset_and_scale():
    errors = SensorErrors(ErrorModel(offset=(1.0, 2.0, 3.0), scale=(2.0, 1.0, 0.0)))
    rng = np.random.default_rng(1)
    before = rng.bit_generator.state
    errors.restart(rng)
    assert errors.measured((5.0, 5.0, 5.0), 0.1, 1, rng) == (11.0, 7.0, 3.0)
    assert rng.bit_generator.state == before, "nothing is drawn without noise and drift"


def test_noise_has_its_deviation():
    errors = SensorErrors(ErrorModel(noise=(0.1, 1.0, 0.0)))
    rng = np.random.default_rng(1)
    found = np.array([errors.measured((0.0, 0.0, 0.0), 0.1, 1, rng) for _ in range(4000)])
    assert np.std(found, axis=0) == pytest.approx((0.1, 1.0, 0.0), rel=0.05)


def test_a_set_drift_decays():
    errors = SensorErrors(ErrorModel(offset=THREE, frequency=(1.0, 2.0, 0.0)))
    errors.drift = THREE
    found = errors.measured((0.0, 0.0, 0.0), 0.5, 1, np.random.default_rng(1))
    assert found == pytest.approx((1.0 + math.exp(-0.5), 1.0 + math.exp(-1.0), 2.0))
    assert errors.bias == pytest.approx(found)


def test_a_drift_starts_at_random_and_wanders_as_its_recursion_has_it():
    spec = ErrorModel(drift=(2.0, 2.0, 2.0), frequency=THREE)
    starts = []
    for seed in range(2000):
        errors = SensorErrors(spec)
        errors.restart(np.random.default_rng(seed))
        starts += errors.drift
    assert np.std(starts) == pytest.approx(2.0, rel=0.03)
    # d' = exp(-f dt) d + dt N(0, sqrt(2 f) s) has the variance 2 f s^2 dt^2 / (1 - exp(-2 f dt))
    rng, step = np.random.default_rng(1), 0.1
    errors = SensorErrors(spec)
    drifts = []
    for _ in range(30000):
        errors.measured((0.0, 0.0, 0.0), step, 1, rng)
        drifts.append(errors.drift)
    wanted = math.sqrt(2.0 * 4.0 * step**2 / (1.0 - math.exp(-2.0 * step)))
    assert np.std(drifts[200:]) == pytest.approx(wanted, rel=0.05)


def test_a_drift_of_many_periods_at_once_is_as_wide_as_of_each_of_them():
    """Nobody subscribes for a minute: the sensor went on, and does not jump by a step of 60 s."""
    spec = ErrorModel(drift=(2.0, 0.5, 1.0), frequency=(1.0, 0.02, 0.0))
    period, times = 0.01, 6000

    def drifts(number, *steps):
        rng = np.random.default_rng(number)
        errors = SensorErrors(spec)
        errors.drift = THREE
        for count in steps:
            errors.measured((0.0, 0.0, 0.0), period, count, rng)
        return errors.drift

    found = np.array([drifts(seed, times) for seed in range(1000)])
    each = np.array([drifts(seed, *[1] * 600) for seed in range(1000, 1200)])
    parts = np.array([drifts(seed, 600) for seed in range(1000)])
    assert found.std(axis=0) == pytest.approx((0.2, 0.05, 0.0), rel=0.15)
    assert each.mean(axis=0) == pytest.approx(parts.mean(axis=0), abs=0.05)
    assert each.std(axis=0) == pytest.approx(parts.std(axis=0), rel=0.15)
