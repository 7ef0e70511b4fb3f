"""Due steps: exact mean rate, no drift."""

import math
import operator

import numpy as np
import pytest
from bullet_bridge.loop.clock import SimClock
from bullet_sim.parts.schedule import Schedule, passed_rate, whole_rate


def due_steps(schedule, first, last):
    """Due steps of first .. last - 1."""
    return [step for step in range(first, last) if schedule.due(step)]


def test_30_hz_at_1_ms_gives_30_in_every_second():
    steps = due_steps(Schedule(30.0, 0.001), 0, 60001)
    per_second = np.bincount((np.array(steps) - 1) // 1000)
    assert per_second.tolist() == [30] * 60
    assert set(np.diff(steps)) == {33, 34}


@pytest.mark.parametrize("rate, period", [(1000.0, 1), (50.0, 20), (200.0, 5), (1.0, 1000)])
def test_a_rate_that_divides_has_one_period(rate, period):
    assert due_steps(Schedule(rate, 0.001), 0, 5000) == list(range(period, 5000, period))


def test_restart_counts_from_zero_again():
    schedule = Schedule(30.0, 0.001)
    first = due_steps(schedule, 0, 5017)
    schedule.restart(0)
    assert due_steps(schedule, 0, 5017) == first


def test_restart_and_start_in_the_middle_stay_on_the_grid():
    whole = due_steps(Schedule(30.0, 0.001), 0, 3000)
    late = due_steps(Schedule(30.0, 0.001, start=1234), 1234, 3000)
    assert late == [step for step in whole if step > 1234]


def test_a_missed_step_is_made_up_for_once():
    schedule = Schedule(100.0, 0.001)
    assert due_steps(schedule, 57, 85) == [57, 60, 70, 80]


@pytest.mark.parametrize("rate", [1001.0, 0.0, -5.0, math.nan, math.inf])
def test_an_impossible_rate_is_an_error_with_the_value(rate):
    with pytest.raises(ValueError, match=f"rate is {rate} Hz.*at most 1000 Hz"):
        Schedule(rate, 0.001)


@pytest.mark.parametrize("rate", [1e-12, 1e-310, 5e-324])
@pytest.mark.parametrize("step", [1e-6, 0.001, 0.5])
def test_a_rate_may_be_as_low_as_numbers_are(rate, step):
    """Its period is infinite: an OverflowError, or a search without an end."""
    for each in (rate, whole_rate(rate, step), whole_rate(rate, step, operator.gt)):
        assert not due_steps(Schedule(each, step, start=10**9), 10**9 + 1, 10**9 + 1000)
    assert passed_rate(rate, 30.0, step) >= 0.0


@pytest.mark.parametrize("steps, expected", [(0, 110), (1, 110), (10, 110), (11, 120), (35, 140)])
def test_skip_leaves_out_what_is_too_soon(steps, expected):
    schedule = Schedule(100.0, 0.001)
    assert schedule.due(100)
    schedule.skip(steps)
    assert schedule.next == expected
    assert due_steps(schedule, 101, 200) == list(range(expected, 200, 10))


def test_the_clock_publishes_at_most_once_per_step():
    published = []
    clock = SimClock(200.0, 0.01, published.append)
    assert clock.next == 1
    clock.set_time_step(0.001, 30)
    assert clock.next == 35


@pytest.mark.parametrize(
    "rate, step, passed, expected",
    [
        (30.0, 0.001, operator.ge, 1000 / 34),  # 29.39 Hz in Gazebo (libgazebo_ros_p3d.so)
        (50.0, 0.001, operator.ge, 50.0),
        (125.0, 0.001, operator.ge, 125.0),
        (1000.0, 0.001, operator.ge, 1000.0),
        (0.3, 0.001, operator.ge, 1000 / 3334),
        (100.0, 0.001, operator.gt, 1000 / 11),  # 90.8 Hz there (libgazebo_ros_planar_move.so)
        (20.0, 0.004, operator.gt, 250 / 13),
        (15.0, 0.004, operator.gt, 250 / 17),
    ],
)
def test_whole_periods_count_from_the_message_before(rate, step, passed, expected):
    found = whole_rate(rate, step, passed)
    assert found == pytest.approx(expected, rel=1e-9)
    Schedule(found, step)


@pytest.mark.parametrize(
    "rate, limit, expected",  # measured in Gazebo 11.1: 18.8, 15.1, 8.4
    [(30.0, 30.0, 20.0), (30.0, 20.0, 15.0), (30.0, 10.0, 10.0), (20.0, 20.0, 20.0)],
)
def test_a_limit_leaves_out_what_comes_too_soon(rate, limit, expected):
    assert passed_rate(rate, limit, 0.001) == pytest.approx(expected, rel=0.01)
