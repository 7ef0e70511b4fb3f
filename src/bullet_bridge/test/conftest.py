"""Fixtures of many tests: publishers without a master, an empty world."""

import pytest
from bullet_sim.world import World
from fake_impl import fake_publishers


@pytest.fixture
def topics(monkeypatch):
    """Topics by name, of the publishers that plugins make from now on."""
    return fake_publishers(monkeypatch)


@pytest.fixture
def world(request):
    """A world without models, with the GRAVITY of the test's module."""
    world = World(gravity=getattr(request.module, "GRAVITY", (0.0, 0.0, -9.81)))
    yield world
    world.close()
