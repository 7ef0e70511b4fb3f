"""Cameras between the simulation and the render worker."""

import threading
from types import SimpleNamespace

import cv2
import numpy as np
import pytest
from bullet_bridge.plugins import cameras as module
from bullet_bridge.plugins.cameras import Cameras

LIMIT = 30.0  # [s]


class Client:
    """Stands in for RenderClient: a test sets when it may start and when an image is finished."""

    may_start = threading.Event()

    def __init__(self, on_frame, on_error, zero_copy, quality):
        self.on_frame, self.on_error, self.epoch, self.waiting = on_frame, on_error, 0, []
        self.sources, self.busy = None, ()

    def start(self, _kind):
        """Works as soon as a test lets it."""
        assert self.may_start.wait(LIMIT)
        return SimpleNamespace(kind="tiny", reason="", details="a test")

    def set_sources(self, sources, _scene):
        self.sources = sources

    def needing_snapshot(self, requests):
        return [request for request in requests if request.name not in self.busy]

    def submit(self, snapshot, requests):
        self.waiting += [(snapshot, request, self.epoch) for request in requests]

    def render_sync(self, snapshot, requests):
        return [
            SimpleNamespace(camera=request.name, time=snapshot, epoch=self.epoch, labels=None)
            for request in requests
        ]

    def discard(self):
        """Only the epoch: as if all were being drawn."""
        self.epoch += 1

    def finish(self):
        waiting, self.waiting = self.waiting, []
        for snapshot, request, epoch in waiting:
            self.on_frame(
                SimpleNamespace(camera=request.name, time=snapshot, epoch=epoch, labels=None)
            )


class Camera:
    """An output that stores the times of its images."""

    def __init__(self, name):
        self.request, self.times = SimpleNamespace(name=name), []

    def publish_frame(self, frame):
        self.times.append(frame.time)


def drawn(cameras, world, camera, waits=False):
    cameras.request(camera.request)
    cameras.flush(world, waits)


@pytest.fixture(autouse=True)
def _no_renderer_and_no_ros(monkeypatch):
    monkeypatch.setattr(module, "RenderClient", Client)
    monkeypatch.setattr(module.rospy, "is_shutdown", lambda: False)
    monkeypatch.setattr(module.rospy, "loginfo", lambda *_: None)


@pytest.fixture(name="cameras")
def _cameras(request):
    cameras = Cameras("tiny", getattr(request, "param", False))
    cameras.restart()  # before the first camera there is nothing to forget
    Client.may_start.set()
    cameras.start()
    cameras._starter.join()
    return cameras


def test_nothing_waits_for_a_worker_that_starts():
    """Of what is published meanwhile only the images are missing."""
    cameras, camera = Cameras("gl", False), Camera("a")
    Client.may_start.clear()
    cameras.start()
    cameras.start()  # of the next model
    cameras.add(camera)
    cameras.set_sources(["a body"])
    drawn(cameras, SimpleNamespace(snapshot=lambda: 1.0), camera)
    Client.may_start.set()
    cameras._starter.join()
    drawn(cameras, SimpleNamespace(snapshot=lambda: 2.0), camera)
    cameras._client.finish()
    assert (cameras._client.sources, camera.times) == (["a body"], [2.0])


def test_steps_on_request_wait_for_a_worker_that_starts():
    """A driver that is stepped saw nothing for the first seconds on a busy machine."""
    cameras, camera = Cameras("gl", False), Camera("a")
    Client.may_start.clear()
    cameras.add(camera)
    threading.Timer(0.2, Client.may_start.set).start()
    drawn(cameras, SimpleNamespace(snapshot=lambda: 1.0), camera, waits=True)
    cameras._client.finish()
    assert (camera.times, cameras.take_failures()) == ([1.0], [])


def test_images_of_before_a_reset_do_not_come_after_it(cameras):
    camera, world = Camera("a"), SimpleNamespace(snapshot=lambda: now)
    cameras.add(camera)
    for now in (1.0, 2.0):  # noqa: B007 (the world reads it)
        drawn(cameras, world, camera)
    cameras._client.finish()
    now = 3.0
    drawn(cameras, world, camera)
    cameras.restart()
    now = 0.1
    drawn(cameras, world, camera)
    cameras._client.finish()
    assert camera.times == [1.0, 2.0, 0.1]


def test_a_snapshot_is_made_only_for_what_will_be_rendered(cameras):
    made = []
    world = SimpleNamespace(snapshot=lambda: made.append(1) or 1.0)
    cameras._client.busy = ("a",)
    drawn(cameras, world, Camera("a"))
    assert not made
    cameras.request(SimpleNamespace(name="b"))
    drawn(cameras, world, Camera("a"))
    assert len(made) == 1 and [request.name for _, request, _ in cameras._client.waiting] == ["b"]


def test_removing_leaves_a_later_namesake(cameras):
    old, new = Camera("a"), Camera("a")
    cameras.add(old)
    cameras.add(new)
    cameras.remove(old)
    drawn(cameras, SimpleNamespace(snapshot=lambda: 1.0), new)
    cameras._client.finish()
    cameras.remove(new)
    drawn(cameras, SimpleNamespace(snapshot=lambda: 2.0), new)
    cameras._client.finish()
    assert (old.times, new.times) == ([], [1.0])


def test_images_are_saved_under_gazebos_names(tmp_path):
    """WORLD_MODEL_LINK_CAMERA(NUMBER)-NNNN.jpg, as Camera::FrameFilename has them."""
    rgb = np.zeros((48, 64, 3), np.uint8)
    rgb[:, :32] = 200, 40, 10
    folder = tmp_path / "of" / "images"
    saved = module.SavedImages(str(folder), "default_m_base_cam(2)")
    saved.write(rgb)
    saved.write(rgb[:, ::-1])
    names = [f"default_m_base_cam(2)-{number:04d}.jpg" for number in (0, 1)]
    assert sorted(path.name for path in folder.iterdir()) == names
    seen = cv2.imread(str(folder / names[1]))
    assert np.abs(seen[24, 48].astype(int) - (10, 40, 200)).max() < 12
    assert np.abs(seen[24, 12].astype(int)).max() < 12


def test_a_folder_that_cannot_be_written_is_an_error_in_the_log(tmp_path, monkeypatch):
    (tmp_path / "file").write_text("")
    told = []
    monkeypatch.setattr(module.rospy, "logerr_throttle", lambda _, text: told.append(text))
    module.SavedImages(str(tmp_path / "file" / "x"), "c").write(np.zeros((4, 4, 3), np.uint8))
    assert len(told) == 1 and "cannot be written" in told[0]


@pytest.mark.parametrize(
    "cameras, at_once", [(True, [1.0, 2.0, 3.0]), (False, [])], indirect=["cameras"]
)
def test_every_image_is_waited_for_if_requested(cameras, at_once):
    camera = Camera("a")
    cameras.add(camera)
    for now in (1.0, 2.0, 3.0):
        drawn(cameras, SimpleNamespace(snapshot=lambda: now), camera)  # noqa: B023
    assert camera.times == at_once
