"""The backing node's wait for standstill, without a master."""

from dataclasses import dataclass
from types import SimpleNamespace

import pytest
import rospy
from cybertruck.backing.server import REST_TIME, BackUpServer


@dataclass
class Source:
    """A truck that rolls on for ever; every state moves the clock by a step [s]."""

    step: float
    speed: float = 1.0
    now: float = 50.0
    waits: int = 0

    @property
    def state(self):
        return SimpleNamespace(stamp=self.now, speed=self.speed)

    def staleness(self, _timeout):
        return ""

    def wait(self, _after, _wall_time):
        self.waits += 1
        if self.waits > 10000:
            raise AssertionError("it waits for ever")
        self.now += self.step
        return self.state


def come_to_rest(monkeypatch, source):
    """Runs the wait; returns how often the truck was commanded to stop."""
    stops = []
    server = BackUpServer.__new__(BackUpServer)  # its constructor needs a master
    server._source, server._driver = source, SimpleNamespace(stop=lambda: stops.append(1))
    server._settings = SimpleNamespace(node=SimpleNamespace(state_timeout=0.5))
    monkeypatch.setattr(rospy, "get_time", lambda: source.now)
    monkeypatch.setattr(rospy, "is_shutdown", lambda: False)
    server._stop_truck()
    return len(stops)


def test_a_truck_that_rolls_on_is_waited_for_no_longer_than_it_may(monkeypatch):
    source = Source(0.008)
    assert come_to_rest(monkeypatch, source) == 2
    assert source.now - 50.0 == pytest.approx(REST_TIME, abs=0.01)


def test_the_wait_stops_when_the_truck_is_at_rest(monkeypatch):
    source = Source(0.008, speed=0.0)
    come_to_rest(monkeypatch, source)
    assert source.now - 50.0 == pytest.approx(0.2, abs=0.02)


def test_the_wait_stops_at_a_reset(monkeypatch):
    source = Source(-49.9)
    assert come_to_rest(monkeypatch, source) == 2
    assert source.waits == 1
