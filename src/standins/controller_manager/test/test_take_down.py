"""Warnings of the spawner at its shutdown, without ROS."""

import time

import pytest
from controller_manager import spawner as node
from controller_manager.client import ManagerError, Spawner


class Manager:
    """A manager that disappears some time after the node's shutdown has begun."""

    def __init__(self, leaves_after, works):
        self._leaves, self._works = time.monotonic() + leaves_after, works

    def load(self, _name):
        return True

    def unload(self, _name):
        if self._works is None:
            raise ManagerError("service gone")
        return self._works

    def switch(self, start=(), stop=(), strict=True):
        return bool(self._works)

    def is_there(self):
        return time.monotonic() < self._leaves


@pytest.mark.parametrize(
    "leaves_after, works, count",
    [
        (0.0, None, 0),  # gone already: no warning
        (0.3, False, 0),  # shutting down: it refuses, then it is disconnected
        (1e9, None, 1),  # it stays and the request fails
        (1e9, False, 1),
        (1e9, True, 0),
    ],
)
def test_warnings_only_about_a_manager_that_stays(monkeypatch, leaves_after, works, count):
    warnings = []
    monkeypatch.setattr(node.rospy, "logwarn", warnings.append)
    manager = Manager(leaves_after, works)
    spawner = Spawner(manager, lambda text: None, warnings.append)
    spawner.loaded = ["a"]
    node.take_down_quietly(spawner, manager, 2.0)
    assert len(warnings) == count
