"""The motion model against closed forms, and its derivatives against differences."""

import math

import numpy as np
import pytest
from robot_localization.ekf import ACCELERATION, ANGLES, POSITION, RATES, VELOCITY, advance
from robot_localization.frames import angles, from_quaternion, matrix, to_quaternion, wrap


def run(state, step, count):
    for _ in range(count):
        state, _ = advance(state, step)
    return state


@pytest.fixture(name="state")
def _state():
    return np.zeros(15)


def test_constant_velocity_in_a_tilted_frame(state):
    state[ANGLES] = 0.3, -0.4, 2.0
    state[VELOCITY] = 1.5, -0.5, 0.25
    end = run(state, 0.01, 200)
    assert end[POSITION] == pytest.approx(2.0 * matrix(0.3, -0.4, 2.0) @ (1.5, -0.5, 0.25))


def test_constant_acceleration(state):
    state[VELOCITY], state[ACCELERATION] = (1.0, 0.0, 0.0), (0.5, -0.25, 0.0)
    end = run(state, 0.02, 100)
    assert end[POSITION] == pytest.approx((1.0 * 2 + 0.25 * 4, -0.125 * 4, 0.0))
    assert end[VELOCITY] == pytest.approx((2.0, -0.5, 0.0))


@pytest.mark.parametrize("speed, rate", [(1.0, 0.5), (0.3, -2.0), (5.0, 1.0)])
def test_constant_turn(state, speed, rate):
    state[6], state[11], state[5] = speed, rate, 0.7
    end, time = run(state, 0.02, 150), 3.0
    radius = speed / rate
    expected = (
        radius * (math.sin(0.7 + rate * time) - math.sin(0.7)),
        radius * (math.cos(0.7) - math.cos(0.7 + rate * time)),
    )
    # Chords instead of arcs: (rate step)^2 / 24 of the way.
    assert end[:2] == pytest.approx(expected, abs=speed * time * (rate * 0.02) ** 2 / 12)
    assert end[5] == pytest.approx(wrap(0.7 + rate * time))


def test_rates_turn_the_body_about_its_own_axes(state):
    state[ANGLES], state[RATES] = (0.2, 0.3, -1.0), (0.4, -0.3, 0.5)
    end = run(state, 0.001, 1000)
    axis = np.array((0.4, -0.3, 0.5))
    angle = np.linalg.norm(axis)
    half = np.append(axis / angle * math.sin(angle / 2), math.cos(angle / 2))
    expected = matrix(0.2, 0.3, -1.0) @ from_quaternion(*half)
    assert matrix(*end[ANGLES]) == pytest.approx(expected, abs=1e-6)


def test_angles_stay_within_half_a_turn(state):
    state[11] = 3.0
    assert abs(run(state, 0.05, 100)[5]) <= math.pi


@pytest.mark.parametrize("seed", range(5))
def test_derivatives(seed):
    state = np.random.default_rng(seed).uniform(-1.0, 1.0, 15)
    step, small = 0.05, 1e-6
    _, jacobian = advance(state, step)
    for column in range(15):
        change = np.zeros(15)
        change[column] = small
        slope = (advance(state + change, step)[0] - advance(state - change, step)[0]) / (2 * small)
        assert jacobian[:, column] == pytest.approx(slope, abs=1e-8)


def test_upright_pitch_gives_finite_numbers(state):
    state[4], state[RATES] = math.pi / 2, (0.1, 0.2, 0.3)
    after, jacobian = advance(state, 0.01)
    assert np.isfinite(after).all() and np.isfinite(jacobian).all()


@pytest.mark.parametrize("triple", [(0, 0, 0), (0.3, -1.2, 2.9), (-3.0, 0.5, -0.1)])
def test_rotations_there_and_back(triple):
    rotation = matrix(*triple)
    assert angles(rotation) == pytest.approx(triple)
    assert from_quaternion(*to_quaternion(rotation)) == pytest.approx(rotation)


@pytest.mark.parametrize("pitch", [math.pi / 2, -math.pi / 2])
def test_rotation_of_an_upright_pitch(pitch):
    rotation = matrix(0.4, pitch, 1.0)
    assert matrix(*angles(rotation)) == pytest.approx(rotation, abs=1e-6)


def test_a_quaternion_of_zeros_is_no_rotation():
    assert (from_quaternion(0, 0, 0, 0) == np.eye(3)).all()
    assert from_quaternion(0, 0, 3, 4) == pytest.approx(from_quaternion(0, 0, 0.6, 0.8))
