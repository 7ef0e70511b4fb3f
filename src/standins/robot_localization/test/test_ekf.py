"""The filter against closed forms, outliers, wrong data, and its own idea of how sure it is."""

import math

import numpy as np
import pytest
from robot_localization.ekf import PROCESS_NOISE, Ekf, Measurement, advance

QUIET = np.zeros((15, 15))
X, Y, YAW, VX, VY, VYAW, AX, AY = 0, 1, 5, 6, 7, 11, 12, 13
PLANE = [X, Y, YAW, VX, VY, VYAW, AX, AY]


def measured(time, values, variance=1e-4, threshold=math.inf):
    """Measurement of a dict place -> value; variance one number, or one each."""
    index = np.array(sorted(values))
    covariance = np.diag(np.broadcast_to(np.asarray(variance, float), len(index)))
    values = np.array([values[i] for i in index], float)
    return Measurement("test", time, index, values, covariance, threshold)


def test_the_first_measurement_sets_what_it_measures():
    ekf = Ekf()
    assert not ekf.initialized
    ekf.process(measured(5.0, {X: 2.0, YAW: 0.5}, (0.04, 0.09)))
    assert ekf.initialized and ekf.time == 5.0
    assert ekf.state[[X, YAW, VX]].tolist() == [2.0, 0.5, 0.0]
    assert np.diagonal(ekf.covariance)[[X, YAW, VX]].tolist() == [0.04, 0.09, 1e-9]


def test_constant_velocity_is_found_from_positions():
    """Without process noise the filter is the least-squares line through the points."""
    covariance = np.zeros((15, 15))
    covariance[X, X] = covariance[VX, VX] = 1e6
    ekf, rng = Ekf(QUIET, covariance=covariance), np.random.default_rng(7)
    ekf.initialized = True
    times = 0.1 * np.arange(40)
    points = 3.0 + 1.25 * times + rng.normal(0.0, 0.05, 40)
    for time, point in zip(times, points):
        ekf.process(measured(time, {X: point}, 0.05**2))
    slope, start = np.polyfit(times, points, 1)
    assert ekf.state[VX] == pytest.approx(slope, rel=1e-6)
    assert ekf.state[X] == pytest.approx(start + slope * times[-1], rel=1e-6)
    spread = np.sum((times - times.mean()) ** 2)
    assert ekf.covariance[VX, VX] == pytest.approx(0.05**2 / spread, rel=1e-5)


def test_constant_turn_from_twists_alone():
    ekf, speed, rate = Ekf(), 0.8, 0.4
    for count in range(251):
        ekf.process(measured(0.02 * count, {VX: speed, VY: 0.0, VYAW: rate}, 1e-8))
    time, radius = 5.0, speed / rate
    assert ekf.state[YAW] == pytest.approx(rate * time, rel=1e-4)
    assert ekf.state[:2] == pytest.approx(
        (radius * math.sin(rate * time), radius * (1 - math.cos(rate * time))), rel=1e-3
    )


def test_steady_state_of_a_random_walk():
    """One number with process noise q per second, measured each dt with variance r: Riccati."""
    noise, q, r, dt = np.zeros((15, 15)), 0.3, 0.02, 0.1
    noise[Y, Y] = q
    ekf = Ekf(noise, covariance=np.zeros((15, 15)))
    ekf.process(measured(0.0, {Y: 1.0}, 5.0))
    for count in range(1, 200):
        ekf.process(measured(count * dt, {Y: 1.0}, r))
    step = q * dt
    before = (step + math.sqrt(step * step + 4 * step * r)) / 2
    assert ekf.covariance[Y, Y] == pytest.approx(before * r / (before + r), rel=1e-9)


def test_two_sensors_are_weighed_by_their_variances():
    ekf = Ekf(QUIET)
    ekf.process(measured(0.0, {X: 1.0}, 0.1))
    ekf.process(measured(0.0, {X: 2.0}, 0.3))
    assert ekf.state[X] == pytest.approx((1.0 / 0.1 + 2.0 / 0.3) / (1 / 0.1 + 1 / 0.3))
    assert ekf.covariance[X, X] == pytest.approx(1 / (1 / 0.1 + 1 / 0.3))


def test_angles_are_compared_the_short_way():
    ekf = Ekf()
    ekf.process(measured(0.0, {YAW: 3.1}, 0.01))
    ekf.process(measured(0.0, {YAW: -3.1}, 0.01))
    assert abs(ekf.state[YAW]) == pytest.approx(math.pi)


@pytest.mark.parametrize("distance, taken", [(2.9, True), (3.1, False)])
def test_outliers_by_mahalanobis_distance(distance, taken):
    ekf = Ekf(QUIET)
    ekf.process(measured(0.0, {X: 0.0}, 0.09))
    before = ekf.state.copy(), ekf.covariance.copy()
    value = distance * math.sqrt(0.09 + 0.16)
    assert ekf.process(measured(0.0, {X: value}, 0.16, threshold=3.0)) == taken
    if not taken:
        assert (ekf.state == before[0]).all() and (ekf.covariance == before[1]).all()


def test_an_outlier_still_moves_time_on():
    ekf = Ekf()
    ekf.process(measured(0.0, {X: 0.0, VX: 1.0}, 0.01))
    assert not ekf.process(measured(2.0, {X: 100.0}, 0.01, threshold=3.0))
    assert ekf.time == 2.0 and ekf.state[X] == pytest.approx(2.0)


def test_what_is_not_finite_is_left_out():
    ekf = Ekf(QUIET)
    ekf.process(measured(0.0, {X: 1.0, Y: 1.0}, 0.1))
    bad = measured(0.0, {X: math.nan, Y: 2.0}, 0.1)
    bad.covariance[0, 1] = bad.covariance[1, 0] = math.inf
    assert ekf.process(bad)
    assert ekf.state[[X, Y]] == pytest.approx((1.0, 1.5))
    assert not ekf.process(measured(0.0, {X: math.inf}, 0.1))
    assert not ekf.process(measured(0.0, {X: 5.0}, math.nan))
    assert ekf.state[X] == 1.0


@pytest.mark.parametrize("variance, used", [(-0.1, 0.1), (0.0, 1e-9)])
def test_variances_that_cannot_be(variance, used):
    ekf, right = Ekf(QUIET), Ekf(QUIET)
    for item, value in ((ekf, variance), (right, used)):
        item.process(measured(0.0, {X: 0.0}, 0.1))
        item.process(measured(0.0, {X: 1.0}, value))
    assert ekf.state[X] == right.state[X]


def test_a_late_measurement_corrects_the_present():
    ekf = Ekf()
    ekf.process(measured(1.0, {X: 0.0}, 0.1))
    ekf.process(measured(0.5, {X: 1.0}, 0.1))
    assert ekf.time == 1.0 and ekf.state[X] == pytest.approx(0.5)


def test_a_clock_that_starts_late_is_no_long_step():
    ekf = Ekf()
    ekf.process(measured(0.0, {VX: 1.0}, 0.1))
    ekf.process(measured(1.6e9, {VX: 1.0}, 0.1))
    assert ekf.time == 1.6e9 and abs(ekf.state[X]) < 0.1


def test_noise_that_grows_with_the_speed():
    slow, fast = (Ekf(scaled_noise=True) for _ in range(2))
    for ekf, speed in ((slow, 0.0), (fast, 2.0)):
        ekf.process(measured(0.0, {VX: speed}, 1e-9))
        ekf.predict(0.1)
    assert slow.covariance[X, X] < 1e-6
    assert fast.covariance[X, X] == pytest.approx(0.1 * 4.0 * PROCESS_NOISE[X, X], rel=1e-3)


def test_reset_is_a_new_start():
    first = np.arange(15.0) / 10
    ekf = Ekf(state=first)
    ekf.process(measured(0.0, {X: 9.0}))
    ekf.reset()
    assert (ekf.state == first).all() and not ekf.initialized


def test_it_knows_how_sure_it_is():
    """NEES: runs of the model itself; the normed squared error is that of chi-square."""
    runs, steps, dt = 30, 60, 0.05
    noise = np.zeros((15, 15))
    noise[PLANE, PLANE] = 1e-3, 1e-3, 1e-4, 0.02, 0.02, 0.01, 0.05, 0.05
    start = np.zeros((15, 15))
    start[PLANE, PLANE] = 0.01, 0.01, 0.002, 0.04, 0.04, 0.01, 0.09, 0.09
    mean = np.zeros(15)
    mean[[VX, VYAW, AX]] = 1.0, 0.4, 0.1
    odometry, fix = np.array((0.05, 0.05, 0.02)), np.array((0.1, 0.1, 0.03))
    errors = np.zeros((steps, runs))
    for run in range(runs):
        rng = np.random.default_rng(run)
        truth = mean + rng.normal(size=15) * np.sqrt(np.diagonal(start))
        ekf = Ekf(noise, mean, start)
        ekf.initialized = True
        for count in range(steps):
            truth, _ = advance(truth, dt)
            truth = truth + rng.normal(size=15) * np.sqrt(dt * np.diagonal(noise))
            time = dt * (count + 1)
            for places, spread in (([VX, VY, VYAW], odometry), ([X, Y, YAW], fix)):
                if places[0] == X and count % 5:
                    continue
                values = truth[places] + rng.normal(size=3) * spread
                ekf.process(measured(time, dict(zip(places, values)), spread**2))
            error = (truth - ekf.state)[PLANE]
            error[2] = math.remainder(error[2], 2 * math.pi)
            errors[count, run] = error @ np.linalg.solve(
                ekf.covariance[np.ix_(PLANE, PLANE)], error
            )
    # The mean over runs is 8 with a spread of sqrt(2 * 8 / runs) = 0.73 at each time.
    means = errors.mean(axis=1)
    assert means.mean() == pytest.approx(8.0, abs=0.73)
    assert np.all(np.abs(means - 8.0) < 5.0 * 0.73)
