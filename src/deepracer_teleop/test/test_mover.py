"""Timed moves, repetitions and stops on a clock set by the test."""

import pytest
from deepracer_teleop.window.layout import Mover


class Bench:
    def __init__(self):
        self.now, self.sent = 50.0, []
        self.mover = Mover(
            lambda v, w: self.sent.append((round(self.now, 3), v, w)),
            lambda: self.now,
            repeat_rate=10.0,
        )

    def run(self, seconds, step=0.01):
        for _ in range(round(seconds / step)):
            self.now = round(self.now + step, 6)
            self.mover.tick()


@pytest.fixture
def bench():
    return Bench()


def test_a_timed_move_repeats_and_stops_with_one_zero(bench):
    bench.mover.move(10.0, 0.0, 1.0)
    bench.run(5.0)
    assert bench.sent == [(pytest.approx(50.0 + 0.1 * i), 10.0, 0.0) for i in range(10)] + [
        (51.0, 0.0, 0.0)
    ]
    assert not bench.mover.active


def test_stop_during_a_move_is_immediate_and_sent_once(bench):
    bench.mover.move(10.0, -5.0, 0.8)
    bench.run(0.35)
    bench.sent.clear()
    bench.mover.stop()
    bench.run(2.0)
    assert bench.sent == [(50.35, 0.0, 0.0)]


def test_steering_at_rest_is_sent_once(bench):
    bench.mover.hold(0.0, 2.0)
    bench.run(1.0)
    assert bench.sent == [(50.0, 0.0, 2.0)]


def test_hold_repeats_endlessly(bench):
    bench.mover.hold(10.0, 2.0)
    bench.run(3.0)
    assert len(bench.sent) == 31 and set(row[1:] for row in bench.sent) == {(10.0, 2.0)}


def test_a_new_command_replaces_a_timed_move(bench):
    bench.mover.move(10.0, 0.0, 1.0)
    bench.run(0.5)
    bench.mover.hold(0.0, 1.0)
    bench.sent.clear()
    bench.run(2.0)
    assert bench.sent == []


def test_a_paused_clock_continues_the_move(bench):
    bench.mover.move(10.0, 0.0, 1.0)
    for _ in range(1000):
        bench.mover.tick()
    assert bench.mover.active and len(bench.sent) == 1


def test_a_reset_clock_stops_the_move(bench):
    bench.mover.move(10.0, 0.0, 1.0)
    bench.now = 0.0
    bench.mover.tick()
    assert bench.sent[-1] == (0.0, 0.0, 0.0) and not bench.mover.active
