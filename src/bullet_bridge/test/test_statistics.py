"""The loop's figures as a service."""

import json
import threading

import pytest
from bullet_bridge.loop import clock
from bullet_bridge.loop.clock import Pace, Shares
from bullet_bridge.loop.jobs import JobQueue
from bullet_bridge.services import simulation as module


class Server:
    """Hands out a pace's figures."""

    def __init__(self):
        self.times = iter([0.0, 0.0015, 0.004, 2.0])
        self.pace = Pace(1.0, lambda: next(self.times))
        for step in range(2):
            assert self.pace.delay(0.001 * step) == 0
        self.pace.delay(1.0)

    def statistics(self):
        return self.pace.statistics()


@pytest.fixture
def handlers(monkeypatch):
    """The handlers of the advertised services."""
    made = []
    monkeypatch.setattr(module.rospy, "Service", lambda _name, _type, handle: made.append(handle))
    return made


def test_figures_come_as_json(handlers):
    jobs, responses = JobQueue(), []
    module.advertise_json("~statistics", jobs, Server().statistics)
    asker = threading.Thread(target=lambda: responses.append(handlers[0](None)))
    asker.start()
    while asker.is_alive():
        jobs.run_pending(wait=0.01)
    values = json.loads(responses[0].message)
    assert responses[0].success and values["batches"] == 3
    assert abs(values["lateness_p50"] - 0.003) < 1e-9 and abs(values["lateness_max"] - 1.0) < 1e-9
    assert abs(values["real_time_factor"] - 0.5) < 1e-9


def test_when_the_simulation_has_ended_it_says_so(handlers):
    jobs = JobQueue()
    jobs.close()
    module.advertise_json("~statistics", jobs, Server().statistics)
    response = handlers[0](None)
    assert not response.success and "has ended" in response.message


def test_shares_are_of_the_time_between_two_measurements(monkeypatch):
    now = [10.0]
    monkeypatch.setattr(clock.wall, "perf_counter", lambda: now[0])
    shares = Shares()
    for passed in (0.5, 0.1):
        begin, now[0] = now[0], now[0] + passed
        stepped = shares.add("steps", begin)
        now[0] += passed / 2
        shares.add("messages", stepped)
        now[0] += 0.2
    assert shares.last == dict.fromkeys(clock.PARTS, 0.0), "nothing was measured yet"
    shares.measured()
    assert shares.last == pytest.approx({"steps": 0.6 / 1.3, "messages": 0.3 / 1.3, "sockets": 0.0})
    now[0] += 1.0
    shares.measured()
    assert shares.last == dict.fromkeys(clock.PARTS, 0.0)
