"""What the spawner says at its end; no ROS needed."""

import time

import pytest
from controller_manager import spawner as node
from controller_manager.bring_up import Spawner
from controller_manager.client import ManagerError


class Manager:
    """A manager that loses its connection at some time after the node's end began."""

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
    "leaves_after, works, said",
    [
        (0.0, None, 0),  # gone already: silence
        (0.3, False, 0),  # going: it refuses, then it is gone
        (1e9, None, 1),  # it stays and does not do as asked
        (1e9, False, 1),
        (1e9, True, 0),
    ],
)
def test_warnings_only_about_a_manager_that_stays(monkeypatch, leaves_after, works, said):
    warnings = []
    monkeypatch.setattr(node.rospy, "logwarn", warnings.append)
    manager = Manager(leaves_after, works)
    spawner = Spawner(manager, lambda text: None, warnings.append)
    spawner.loaded = ["a"]
    node.end_quietly(spawner, manager, 2.0)
    assert len(warnings) == said
