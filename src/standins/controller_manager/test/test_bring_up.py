"""Bringing controllers up and down, with a fake manager."""

import threading

import pytest
from controller_manager.client import Spawner


class FakeManager:
    """Records the requests; controllers named bad* do not load."""

    def __init__(self):
        self.asked = []

    def load(self, name):
        self.asked.append(("load", name))
        return not name.startswith("bad")

    def unload(self, name):
        self.asked.append(("unload", name))
        return True

    def switch(self, start=(), stop=(), strict=True):
        self.asked.append(("switch", list(start), list(stop), strict))
        return not strict or not any(name.startswith("rival") for name in start)


@pytest.fixture(name="manager")
def _manager():
    return FakeManager()


@pytest.fixture(name="warnings")
def _warnings():
    return []


@pytest.fixture(name="lines")
def _lines():
    return []


@pytest.fixture(name="spawner")
def _spawner(manager, warnings, lines):
    return Spawner(manager, lines.append, warnings.append)


def test_loads_all_then_starts_all_at_once(spawner, manager, warnings, lines):
    assert spawner.bring_up(["a", "b"], start=True) == ["a", "b"]
    assert manager.asked == [("load", "a"), ("load", "b"), ("switch", ["a", "b"], [], True)]
    assert not warnings
    assert lines == [  # which programs look for
        "Loading controller: a",
        "Loading controller: b",
        "Controller Spawner: Loaded controllers: a, b",
        "Started controllers: a, b",
    ]


def test_stopped_only_loads(spawner, manager):
    assert spawner.bring_up(["a"], start=False) == ["a"]
    assert manager.asked == [("load", "a")]


def test_one_that_does_not_load_is_named_and_the_rest_starts(spawner, manager, warnings):
    assert spawner.bring_up(["bad_one", "b"], start=True) == ["b"]
    assert manager.asked[-1] == ("switch", ["b"], [], True)
    assert spawner.loaded == ["b"] and warnings == ["Failed to load bad_one"]


def test_where_one_cannot_start_none_does_as_upstream(spawner, manager, warnings):
    assert spawner.bring_up(["a", "rival", "b"], start=True) == ["a", "rival", "b"]
    assert manager.asked[-1] == ("switch", ["a", "rival", "b"], [], True)
    assert spawner.loaded == ["a", "rival", "b"]
    assert warnings == ["Failed to start controllers: a, rival, b"]


def test_take_down_stops_all_then_unloads_backwards(spawner, manager, lines):
    spawner.bring_up(["a", "b"], start=True)
    del manager.asked[:]
    spawner.take_down()
    assert manager.asked == [("switch", [], ["a", "b"], True), ("unload", "b"), ("unload", "a")]
    spawner.take_down()
    assert len(manager.asked) == 3
    assert lines[-7:] == [
        "Shutting down spawner. Stopping and unloading controllers...",
        "Stopping all controllers...",
        "Unloading all loaded controllers...",
        "Trying to unload b",
        "Succeeded in unloading b",
        "Trying to unload a",
        "Succeeded in unloading a",
    ]


def test_nothing_loaded_asks_nothing(spawner, manager):
    spawner.take_down()
    assert manager.asked == []


class SlowManager(FakeManager):
    """Stops and unloads in another thread while the response to the start is on its way."""

    def __init__(self):
        super().__init__()
        self.started, self.proceed = threading.Event(), threading.Event()

    def switch(self, start=(), stop=(), strict=True):
        done = super().switch(start, stop, strict)
        if start:
            self.started.set()
            assert self.proceed.wait(LIMIT)
        return done


LIMIT = 60.0  # [s]


def test_taken_down_while_it_starts_all_that_loaded_is_told_and_unloaded():
    """`rosnode kill` runs the shutdown in another thread than the start."""
    manager, loaded, ended = SlowManager(), [], []
    spawner = Spawner(manager, lambda text: None, ended.append)
    up = threading.Thread(target=lambda: loaded.extend(spawner.bring_up(["a"], start=True)))
    downs = [threading.Thread(target=spawner.take_down) for _ in range(2)]
    up.start()
    assert manager.started.wait(LIMIT)
    for down in downs:
        down.start()
    downs[0].join(0.1)
    assert manager.asked[-1] == ("switch", ["a"], [], True)  # not yet stopped
    manager.proceed.set()
    for thread in (up, *downs):
        thread.join(LIMIT)
    assert loaded == ["a"] and spawner.loaded == [] and not ended
    assert manager.asked[2:] == [("switch", [], ["a"], True), ("unload", "a")]
