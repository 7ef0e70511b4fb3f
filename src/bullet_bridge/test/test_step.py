"""The step service: what it asks for, waits for and refuses."""

import re
import threading

import pytest
from bullet_bridge.loop import received as received_module
from bullet_bridge.loop.jobs import JobQueue
from bullet_bridge.loop.received import ReceivedCounts
from bullet_bridge.loop.server import Steps
from bullet_bridge.services import simulation as module
from bullet_sim.errors import WorldError

from bullet_bridge.srv import StepRequest


class Server:
    """Makes steps at once, with a given error."""

    def __init__(self):
        self.paused, self.error, self.made = True, "", []

    def begin_steps(self, count):
        if self.made and self.made[-1] == "busy":
            raise WorldError("busy")
        self.made.append(count)
        steps = Steps(0)
        steps.error = self.error
        steps.done.set()
        return steps


class Rig:
    """The service with an owner thread behind it."""

    def __init__(self, monkeypatch):
        monkeypatch.setattr(module.rospy, "Service", lambda *_: None)
        monkeypatch.setattr(module.rospy, "logerr", lambda *_: None)
        monkeypatch.setattr(received_module.rospy, "is_shutdown", lambda: False)
        self.server, self.received, self.jobs = Server(), ReceivedCounts(), JobQueue()
        self.received.add("/car/command")
        self.received.add("/cmd_vel")
        self.service = module.StepService(self.jobs, self.server, self.received, 0.05)
        self.end = threading.Event()
        self.owner = threading.Thread(target=self.own)
        self.owner.start()

    def own(self):
        while not self.end.is_set():
            self.jobs.run_pending(wait=0.01)

    def ask(self, n=1, topics=(), counts=()):
        return self.service.handle(StepRequest(n, list(topics), list(counts)))


@pytest.fixture(name="rig")
def _rig(monkeypatch):
    rig = Rig(monkeypatch)
    yield rig
    rig.end.set()
    rig.owner.join()


def test_steps_without_topics(rig):
    response = rig.ask(5)
    assert (response.success, response.status_message, rig.server.made) == (True, "", [5])


def test_steps_after_the_messages_came(rig):
    for _ in range(2):
        rig.received.count("/car/command")
    assert rig.ask(3, ["/car/command", "cmd_vel"], [2, 0]).success
    response = rig.ask(3, ["/car/command"], [1])
    assert not response.success and rig.server.made == [3]
    assert response.status_message == ("not all commands came within 0.05 s: /car/command: 0 of 1")


@pytest.mark.parametrize(
    "request_, text",
    [
        ({"n": 0}, "n is 0, must be at least 1"),
        ({"topics": ["/cmd_vel"], "counts": []}, "1 topics and 0 counts"),
        ({"topics": ["/cmd_vel", "cmd_vel"], "counts": [1, 1]}, "'/cmd_vel' is given twice"),
        ({"topics": [""], "counts": [1]}, "without a name"),
        (
            {"topics": ["/wrong"], "counts": [1]},
            "'/wrong' is not subscribed .*/car/command, /cmd_vel",
        ),
    ],
)
def test_wrong_requests_are_refused_with_the_reason(rig, request_, text):
    response = rig.ask(**request_)
    assert not response.success and rig.server.made == []
    assert re.search(text, response.status_message)


def test_a_running_simulation_is_not_stepped_and_takes_no_messages(rig):
    rig.server.paused = False
    rig.received.count("/cmd_vel")
    assert "pause it" in rig.ask(1, ["/cmd_vel"], [1]).status_message
    rig.server.paused = True
    assert rig.ask(1, ["/cmd_vel"], [1]).success


def test_errors_of_the_steps_are_returned(rig):
    rig.server.error = "no image"
    response = rig.ask()
    assert not response.success and response.status_message == "no image"
    rig.server.made.append("busy")
    assert rig.ask().status_message == "busy"


def test_messages_of_a_step_that_did_not_begin_count_for_the_next(rig):
    rig.received.count("/cmd_vel")
    rig.server.made.append("busy")
    assert rig.ask(1, ["/cmd_vel"], [1]).status_message == "busy"
    rig.server.made.clear()
    assert rig.ask(1, ["/cmd_vel"], [1]).success
    assert not rig.ask(1, ["/cmd_vel"], [1]).success
