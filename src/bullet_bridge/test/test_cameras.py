"""Cameras between the simulation and the render worker."""

from types import SimpleNamespace

import pytest
from bullet_bridge.outputs import cameras as module
from bullet_bridge.outputs.cameras import Cameras


class Client:
    """Stands in for RenderClient: a test says when a picture is finished."""

    def __init__(self, on_frame, on_error, zero_copy, quality):
        self.on_frame, self.on_error, self.epoch, self.waiting = on_frame, on_error, 0, []

    def start(self, _kind):
        """Always works."""
        return SimpleNamespace(kind="tiny", reason="", details="a test")

    def set_sources(self, _sources, _scene):
        """Nothing to draw."""

    def submit(self, snapshot, requests):
        """Keep them."""
        self.waiting += [(snapshot, request, self.epoch) for request in requests]

    def render_sync(self, snapshot, requests):
        """At once."""
        return [
            SimpleNamespace(camera=request.name, time=snapshot, epoch=self.epoch, labels=None)
            for request in requests
        ]

    def discard(self):
        """Only the epoch: as if all were being drawn."""
        self.epoch += 1

    def finish(self):
        """The pictures that were asked for are drawn."""
        waiting, self.waiting = self.waiting, []
        for snapshot, request, epoch in waiting:
            self.on_frame(
                SimpleNamespace(camera=request.name, time=snapshot, epoch=epoch, labels=None)
            )


class Camera:
    """An output that keeps the times of its pictures."""

    def __init__(self, name):
        self.request, self.times = SimpleNamespace(name=name), []

    def publish_frame(self, frame):
        """Store it."""
        self.times.append(frame.time)


@pytest.fixture(name="cameras")
def _cameras(monkeypatch, request):
    monkeypatch.setattr(module, "RenderClient", Client)
    monkeypatch.setattr(module.rospy, "is_shutdown", lambda: False)
    monkeypatch.setattr(module.rospy, "loginfo", lambda *_: None)
    cameras = Cameras("tiny", getattr(request, "param", False))
    cameras.restart()  # before the first camera there is nothing to forget
    cameras.start()
    return cameras


def test_pictures_of_before_a_reset_do_not_come_after_it(cameras):
    camera, world = Camera("a"), SimpleNamespace(snapshot=lambda: now)
    cameras.add(camera)
    for now in (1.0, 2.0):  # noqa: B007 (the world reads it)
        cameras.draw(world, [camera])
    cameras._client.finish()
    now = 3.0
    cameras.draw(world, [camera])
    cameras.restart()
    now = 0.1
    cameras.draw(world, [camera])
    cameras._client.finish()
    assert camera.times == [1.0, 2.0, 0.1]


def test_removing_leaves_a_later_namesake(cameras):
    old, new = Camera("a"), Camera("a")
    cameras.add(old)
    cameras.add(new)
    cameras.remove(old)
    cameras.draw(SimpleNamespace(snapshot=lambda: 1.0), [new])
    cameras._client.finish()
    cameras.remove(new)
    cameras.draw(SimpleNamespace(snapshot=lambda: 2.0), [new])
    cameras._client.finish()
    assert (old.times, new.times) == ([], [1.0])


@pytest.mark.parametrize(
    "cameras, at_once", [(True, [1.0, 2.0, 3.0]), (False, [])], indirect=["cameras"]
)
def test_every_picture_is_waited_for_if_asked(cameras, at_once):
    camera = Camera("a")
    cameras.add(camera)
    for now in (1.0, 2.0, 3.0):
        cameras.draw(SimpleNamespace(snapshot=lambda: now), [camera])  # noqa: B023
    assert camera.times == at_once
