"""The PID against closed forms, and angles on the circle."""

import math

import pytest
from bullet_sim.controllers.pid import (
    Pid,
    PidGains,
    position_error,
    shortest_distance,
)
from bullet_sim.description.model import Joint

STEP = 0.001  # [s]


def test_proportional_and_derivative_parts():
    pid = Pid(PidGains(3.0, d=0.5))
    assert pid.update(2.0, STEP) == 6.0  # no kick at the start
    assert pid.update(2.1, STEP) == pytest.approx(3.0 * 2.1 + 0.5 * 0.1 / STEP)
    assert pid.update(1.0, STEP, -4.0) == pytest.approx(3.0 - 2.0)
    assert (pid.error, pid.error_rate, pid.terms) == (1.0, -4.0, (3.0, 0.0, -2.0))


def test_integral_grows_to_its_clamp():
    pid = Pid(PidGains(0.0, i=2.0, i_clamp_min=-0.4, i_clamp_max=0.5))
    outputs = [pid.update(1.0, STEP) for _ in range(1000)]
    assert outputs[99] == pytest.approx(2.0 * 0.1)
    assert outputs[-1] == 0.5
    assert [pid.update(-1.0, STEP) for _ in range(3000)][-1] == -0.4


def test_without_clamp_the_integral_has_no_say():
    pid = Pid(PidGains(1.0, i=100.0))
    assert [pid.update(0.5, STEP) for _ in range(100)][-1] == 0.5


@pytest.mark.parametrize("antiwindup, steps", [(True, 1), (False, 1501)])
def test_antiwindup_leaves_the_clamp_at_once(antiwindup, steps):
    """2 s at error 1 wind i * integral up to 2; the clamp is 0.5, which takes 1.5 s to reach."""
    pid = Pid(PidGains(0.0, i=1.0, i_clamp_min=-0.5, i_clamp_max=0.5, antiwindup=antiwindup))
    for _ in range(2000):
        pid.update(1.0, STEP)
    count = 1
    while pid.update(-1.0, STEP) > 0.5 - STEP / 2:
        count += 1
    assert count == pytest.approx(steps, abs=1)


def test_negative_gain_of_the_integral_is_bounded_too():
    pid = Pid(PidGains(0.0, i=-1.0, i_clamp_min=-0.2, i_clamp_max=0.5, antiwindup=True))
    assert [pid.update(1.0, STEP) for _ in range(2000)][-1] == pytest.approx(-0.2)


@pytest.mark.parametrize("error, period", [(math.nan, STEP), (math.inf, STEP), (1.0, 0.0)])
def test_unusable_input_gives_0_and_is_not_remembered(error, period):
    pid = Pid(PidGains(1.0, i=1.0, i_clamp_min=-9, i_clamp_max=9, d=1.0))
    pid.update(1.0, STEP)
    integral = pid.integral
    assert pid.update(error, period) == 0.0
    assert pid.integral == integral
    assert pid.update(1.0, STEP) == pytest.approx(1.0 + 2 * STEP)


def test_reset_forgets_and_new_gains_do_not():
    pid = Pid(PidGains(0.0, i=1.0, i_clamp_min=-9, i_clamp_max=9))
    pid.update(1.0, 1.0)
    pid.gains = PidGains(0.0, i=3.0, i_clamp_min=-9, i_clamp_max=9)
    assert pid.update(0.0, 1.0) == 3.0
    pid.reset()
    assert pid.update(0.0, 1.0) == 0.0


@pytest.mark.parametrize(
    "start, end, turn",
    [
        (0.0, 1.0, 1.0),
        (3.0, -3.0, 2 * math.pi - 6.0),
        (-3.0, 3.0, 6.0 - 2 * math.pi),
        (20.0, 0.0, 6 * math.pi - 20.0),
        (0.0, math.pi, math.pi),
    ],
)
def test_shortest_distance(start, end, turn):
    assert shortest_distance(start, end) == pytest.approx(turn)


@pytest.mark.parametrize(
    "start, end, lower, upper, turn",
    [
        (0.0, 1.0, -1.5, 1.5, 1.0),
        (-3.0, 3.0, -3.1, 3.1, 6.0),  # the short way leads through the stop
        (0.0, 1.5 * math.pi, -2 * math.pi, 2 * math.pi, -0.5 * math.pi),
        (1.8, -1.0, -1.5, 1.5, -2.8),  # pushed beyond its stop: back
    ],
)
def test_distance_within_limits(start, end, lower, upper, turn):
    joint = Joint("j", "revolute", "a", "b", lower=lower, upper=upper)
    assert position_error(joint, start, end) == pytest.approx(turn)


@pytest.mark.parametrize(
    "kind, lower, upper, position, target, error",
    [
        ("prismatic", -1.0, 1.0, 0.25, 7.0, 0.75),
        ("prismatic", None, None, 0.0, 7.0, 7.0),
        ("continuous", None, None, 0.0, 7.0, 7.0 - 2 * math.pi),
        ("revolute", -1.0, 1.0, 0.5, -3.0, -1.5),
    ],
)
def test_position_error(kind, lower, upper, position, target, error):
    joint = Joint("j", kind, "a", "b", lower=lower, upper=upper)
    assert position_error(joint, position, target) == pytest.approx(error)
