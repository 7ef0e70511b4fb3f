"""The warning that the simulation is slow names the reason, once."""

import time

import pytest
from bullet_bridge.loop.clock import Pace
from bullet_bridge.loop.rtf_monitor import (
    CROWD,
    CROWDED_TIME,
    MIN_COUNT,
    MIN_GAP,
    CallMonitor,
    RealTimeFactorMonitor,
    thread_times,
)

STEP = 0.001  # [s]


class Rig:
    """A clock, a processor that is used in part, and what was logged."""

    def __init__(self):
        self.time = self.processor = self.ready = 0.0
        self.warned, self.logged = [], []
        self.monitor = RealTimeFactorMonitor(
            self.warned.append,
            self.logged.append,
            lambda: self.time,
            lambda: (self.processor, self.ready),
        )

    def seconds(self, count, factor, used=1.0, target=1.0, waited=0.0):
        for _ in range(count):
            self.time += 1.0
            self.processor += used
            self.ready += waited
            self.monitor.measured(factor, target, STEP)


@pytest.fixture(name="rig")
def _rig():
    return Rig()


def test_a_busy_simulation_thread_is_the_reason(rig):
    rig.seconds(3, 1.0)
    rig.seconds(MIN_COUNT + 1, 0.4)
    (text,) = rig.warned
    assert text.startswith("real-time factor 0.40 instead of 1: physics and sensors need ")
    assert "2.5 ms of a processor for each step of 1 ms" in text


def test_other_processes_are_the_reason(rig):
    rig.seconds(3, 1.0, 0.5)
    rig.seconds(MIN_COUNT + 1, 0.6, 0.3, waited=0.5)
    (text,) = rig.warned
    assert "other processes leave the simulation" in text and "% of a processor" in text


def test_waiting_for_images_is_the_reason(rig):
    rig.seconds(MIN_COUNT + 1, 0.6, 0.3, waited=0.1)
    assert "the simulation thread waits 70% of the time for something else" in rig.warned[0]


def test_times_of_this_thread():
    used, waited = thread_times()
    assert 0.0 < used < 1e5 and waited >= 0.0
    # the kernel counts at its ticks, some milliseconds apart
    deadline = time.monotonic() + 60.0
    while thread_times()[0] <= used:
        assert time.monotonic() < deadline


def test_it_is_logged_once_and_its_end_too(rig):
    rig.seconds(60, 0.5)
    rig.seconds(20, 1.0)
    rig.seconds(60, 0.5)
    assert len(rig.warned) == 1 and len(rig.logged) == 1
    assert rig.logged[0] == "real-time factor 1.00: back at the requested speed"
    rig.seconds(20, 1.0)
    rig.time += MIN_GAP
    rig.seconds(60, 0.5)
    assert len(rig.warned) == 2


@pytest.mark.parametrize(
    "factor, target", [(0.95, 1.0), (0.1, 0.1), (0.3, 0.0), (30.0, 0.0), (1.9, 2.0)]
)
def test_cases_without_a_warning(rig, factor, target):
    rig.seconds(30, factor, target=target)
    assert rig.warned == []


def test_a_hiccup_or_a_pause_is_not_logged(rig):
    for _ in range(10):
        rig.seconds(MIN_COUNT - 1, 0.2)
        rig.seconds(1, 1.0)
    for _ in range(10):
        rig.seconds(MIN_COUNT - 1, 0.2)
        rig.monitor.restart()
    assert rig.warned == []


def test_the_pace_measures_over_full_windows():
    now, measured = [0.0], []
    pace = Pace(1.0, lambda: now[0], measured.append)
    for number in range(1, 41):
        now[0] = 0.1 * number
        pace.delay(0.05 * number)  # half of real time
    assert len(measured) >= 3 and measured == pytest.approx([0.5] * len(measured), abs=0.06)


def test_many_calls_that_wait_are_told_once_with_their_number():
    warned, time = [], [0.0]
    monitor = CallMonitor(warned.append, lambda: time[0])
    for second in range(int(CROWDED_TIME) + 3):
        monitor.measured(0 if second == 1 else 64, 2000 * second)
        time[0] += 1.0
    (text,) = warned
    assert text.startswith("64 calls of services wait for their answers, of which the simulation")
    assert "gives 2000 a second" in text
    monitor.measured(CROWD - 1, 0)
    assert len(warned) == 1
