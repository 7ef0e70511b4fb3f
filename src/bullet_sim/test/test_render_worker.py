"""The render process: start, stop, latest wins, death, lockstep."""

import os
import signal
import subprocess
import sys
import textwrap
import threading
import time

import numpy as np
import pytest
from bullet_sim.child import blocking_pair
from bullet_sim.description.model import VisualLink
from bullet_sim.errors import RenderError
from bullet_sim.render import client as module
from bullet_sim.render import worker_process
from bullet_sim.render.client import RenderClient
from bullet_sim.render.request import DEFAULT
from bullet_sim.render.worker import make_renderer
from bullet_sim.render.worker_process import SharedMemory
from bullet_sim.snapshot import BodySource
from test_render import GHOST, PLACES, SIZES, _sources, box_at, check_outline, request, snapshot  # noqa: F401  pylint: disable=unused-import
from testing import pid_from_killed, wait_ended, wait_for

pytestmark = pytest.mark.usefixtures("sketches")

DEADLINE = 90.0  # [s] for anything a worker does
NO_EGL = {"__EGL_VENDOR_LIBRARY_FILENAMES": "/nonexistent"}


class Inbox:
    """Collects what a client calls back with."""

    def __init__(self):
        self.frames, self.errors = [], []
        self._changed = threading.Condition()

    def frame(self, frame):
        with self._changed:
            self.frames.append(frame)
            self._changed.notify_all()

    def error(self, text):
        with self._changed:
            self.errors.append(text)
            self._changed.notify_all()

    def wait(self, condition, what):
        with self._changed:
            assert self._changed.wait_for(condition, DEADLINE), f"{what} within {DEADLINE} s"


def wait_taken(client):
    """Waits until the client's thread has taken what was submitted."""
    wait_for(lambda: not client._pending, "the client's thread", DEADLINE)


@pytest.fixture(autouse=True)
def _patience(monkeypatch):
    """Tests stop a worker and go on; on a busy machine later than the client would wait."""
    monkeypatch.setattr(worker_process, "HANG_TIMEOUT", 600.0)


@pytest.fixture(name="inbox")
def _inbox():
    return Inbox()


@pytest.fixture(name="client")
def _client(inbox, sources):
    """A client of the test's own, which may kill its worker."""
    with RenderClient(inbox.frame, inbox.error) as client:
        client.start("tiny")
        client.set_sources(sources)
        yield client


@pytest.fixture(name="running", scope="module")
def _running():
    """A client whose worker goes on from test to test."""
    with RenderClient() as client:
        client.start("tiny")
        yield client


@pytest.fixture(name="shared")
def _shared(running, inbox, sources):
    """That client with this test's callbacks and bodies."""
    running.on_frame, running.on_error = inbox.frame, inbox.error
    running.set_sources(sources)
    running.dropped.clear()
    yield running
    assert running.restarts == 0


def direct(kind, sources, moment, *requests):
    """The same pictures drawn in this process."""
    renderer, _ = make_renderer(kind, DEFAULT)
    renderer.sync_sources(sources)
    renderer.apply(moment)
    pictures = [renderer.render(r, moment.step) for r in requests]
    renderer.close()
    return pictures


def test_starts_draws_and_stops(client, inbox, sources):
    assert client.renderer.kind == "tiny" and client.renderer.reason == ""
    client.submit(snapshot(step=42), [request()])
    inbox.wait(lambda: inbox.frames, "a frame")
    frame = inbox.frames[0]
    assert (frame.camera, frame.step, frame.time) == ("eye", 42, 0.042)
    assert frame.rgb.shape == (480, 640, 3) and frame.rgb.dtype == np.uint8
    np.testing.assert_array_equal(frame.rgb, direct("tiny", sources, snapshot(), request())[0])
    pid = client._worker.process.pid
    client.close()
    client.close()
    wait_ended(pid, DEADLINE)
    assert not inbox.errors


def test_closing_waits_for_no_picture_and_no_clean_up(client):
    process = client._worker.process
    os.kill(process.pid, signal.SIGSTOP)
    client.submit(snapshot(step=1), [request()])
    client.close()
    assert process.returncode == -signal.SIGKILL


BUSY = """
import sys, time
from bullet_sim.render import worker
worker.serve = lambda *_: (print("busy", flush=True), time.sleep(600.0))
worker.main(sys.argv[1:])
"""


def test_it_ends_with_its_parent_also_while_it_starts_or_draws():
    memory = SharedMemory()
    ours, its = blocking_pair()
    with subprocess.Popen(
        [sys.executable, "-c", BUSY, str(its.fileno()), str(memory.fd), "gl", "auto", "auto"],
        pass_fds=[its.fileno(), memory.fd],
        stdout=subprocess.PIPE,
        text=True,
    ) as process:
        its.close()
        assert process.stdout.readline() == "busy\n" and process.poll() is None
        ours.close()
        try:
            assert process.wait(DEADLINE) == 0
        finally:
            process.kill()
    memory.close()


def test_lockstep_gives_each_camera_its_frame(shared, sources):
    requests = [request("left", 320, 240, noise_stddev=0.01, seed=3), request("right", 200, 300)]
    for moment in (snapshot(step=1), snapshot(step=2, pan=0.3)):
        frames = shared.render_sync(moment, requests, DEADLINE)
        assert [(f.camera, f.step) for f in frames] == [
            ("left", moment.step),
            ("right", moment.step),
        ]
        for frame, picture in zip(frames, direct("tiny", sources, moment, *requests)):
            np.testing.assert_array_equal(frame.rgb, picture)


def test_gl_draws_where_camera_info_says_and_as_it_does_directly(inbox, sources):
    with RenderClient(inbox.frame, inbox.error) as client:
        renderer = client.start("auto")
        if renderer.kind != "gl":
            assert renderer.reason
            pytest.skip(f"no EGL here: {renderer.reason}")
        client.set_sources(sources)
        frame = client.render_sync(snapshot(), [request()], DEADLINE)[0]
        for place in PLACES:
            cameras = [request(f"{w}x{h}", w, h) for w, h in SIZES]
            frames = client.render_sync(box_at(place), cameras, DEADLINE)
            for picture, camera in zip(frames, cameras):
                check_outline(picture.rgb, camera, place)
    np.testing.assert_array_equal(frame.rgb, direct("gl", sources, snapshot(), request())[0])


def test_auto_falls_back_and_says_why():
    with RenderClient(environment=NO_EGL) as client:
        renderer = client.start("auto")
        assert renderer.kind == "tiny" and "gl renderer" in renderer.reason
    with pytest.raises(RenderError, match="gl renderer .* ended"):
        RenderClient(environment=NO_EGL).start("gl")
    with pytest.raises(RenderError, match="'vulkan', must be one of auto, gl, tiny"):
        RenderClient().start("vulkan")


def test_latest_wins_per_camera(shared, inbox):
    large, small = request("large", 1280, 960), request("small", 64, 48)
    shared.render_sync(snapshot(), [small], DEADLINE)
    os.kill(shared._worker.process.pid, signal.SIGSTOP)
    begin = time.monotonic()
    for step in range(1, 51):
        shared.submit(snapshot(step=step), [large, small])
    assert time.monotonic() - begin < DEADLINE, "submit must not wait for pictures"
    os.kill(shared._worker.process.pid, signal.SIGCONT)

    def steps(name):
        return [f.step for f in inbox.frames if f.camera == name]

    inbox.wait(lambda: steps("large")[-1:] == [50] and steps("small")[-1:] == [50], "the newest")
    for name in ("large", "small"):
        assert steps(name) == sorted(steps(name))
        assert len(steps(name)) + shared.dropped[name] == 50
        assert shared.dropped[name] > 0


def test_forgotten_pictures_do_not_come(shared, inbox):
    pid, before = shared._worker.process.pid, shared.epoch
    os.kill(pid, signal.SIGSTOP)
    try:
        shared.submit(snapshot(step=1), [request()])
        wait_taken(shared)
        shared.submit(snapshot(step=2), [request(), request("left")])
        shared.discard()
        shared.submit(snapshot(step=3), [request()])
    finally:
        os.kill(pid, signal.SIGCONT)
    inbox.wait(lambda: inbox.frames and inbox.frames[-1].step == 3, "the last frame")
    assert [(frame.step, frame.epoch - before) for frame in inbox.frames] == [(1, 0), (3, 1)]


def test_a_request_that_is_queued_is_not_replaced_at_once(client, monkeypatch):
    client.render_sync(snapshot(), [request()], DEADLINE)  # it has started
    os.kill(client._worker.process.pid, signal.SIGSTOP)
    try:
        with client._changed:  # all at once: what the worker will have
            for step in range(module.AHEAD):
                client.submit(snapshot(step=step), [request(f"eye{step}")])
        wait_taken(client)
        assert client.needing_snapshot([request(), request("left")]) == [request(), request("left")]
        monkeypatch.setattr(module, "REFRESH", 100.0)
        client.submit(snapshot(step=9), [request()])
        assert client.needing_snapshot([request(), request("left")]) == [request("left")]
        assert client.dropped == {"eye": 1}
        monkeypatch.setattr(module, "REFRESH", 0.0)
        assert client.needing_snapshot([request()]) == [request()]
    finally:
        os.kill(client._worker.process.pid, signal.SIGCONT)


def test_the_next_picture_is_drawn_while_the_last_is_handed_on(sources):
    seen = []

    def on_frame(frame):
        before = frame.rgb.copy()
        deadline = time.monotonic() + DEADLINE
        if frame.step == 1:  # its successor is ordered already: wait until it is drawn
            while not client._worker.connection.poll() and time.monotonic() < deadline:
                time.sleep(0.005)
        seen.append(
            (frame.step, bool(client._worker.connection.poll()), np.array_equal(before, frame.rgb))
        )

    with RenderClient(on_frame, zero_copy=True) as client:
        client.start("tiny")
        client.set_sources(sources)
        os.kill(client._worker.process.pid, signal.SIGSTOP)
        client.submit(snapshot(step=1), [request()])
        wait_taken(client)
        client.submit(snapshot(step=2, pan=0.3), [request()])
        os.kill(client._worker.process.pid, signal.SIGCONT)
        wait_for(lambda: len(seen) >= 2, "the pictures", DEADLINE)
    assert seen == [(1, True, True), (2, False, True)]


def test_the_worker_has_its_next_order_before_its_answer_is_read(sources):
    seen, go_on = [], threading.Event()

    def on_frame(frame):
        seen.append(frame.camera)
        go_on.wait(DEADLINE)

    with RenderClient(on_frame) as client:
        client.start("tiny")
        client.set_sources(sources)
        client.submit(snapshot(step=1), [request("first")])
        wait_for(lambda: seen, "the first picture", DEADLINE)
        client.submit(snapshot(step=2), [request("second")])
        client.submit(snapshot(step=3), [request("third")])
        os.kill(client._worker.process.pid, signal.SIGSTOP)
        go_on.set()
        wait_taken(client)
        assert seen == ["first"]
        os.kill(client._worker.process.pid, signal.SIGCONT)
        wait_for(lambda: len(seen) >= 3, "the pictures", DEADLINE)
    assert seen == ["first", "second", "third"]


def test_killed_worker_is_reported_and_started_again(client, inbox):
    client.render_sync(snapshot(), [request()], DEADLINE)
    first = client._worker.process.pid
    os.kill(first, signal.SIGKILL)
    with pytest.raises(RenderError, match=f"pid {first}.*signal 9"):
        client.render_sync(snapshot(), [request()], DEADLINE)
    inbox.wait(lambda: inbox.errors, "a report")
    assert "started again (at most 3 times within 60 s)" in inbox.errors[0]
    assert client._worker.process.pid != first and client.restarts == 1
    (frame,) = client.render_sync(snapshot(step=9), [request()], DEADLINE)
    assert frame.step == 9  # its bodies are back, too


def test_a_worker_that_keeps_dying_is_given_up(client, inbox, monkeypatch):
    monkeypatch.setattr(module, "MAX_RESTARTS", 0)
    os.kill(client._worker.process.pid, signal.SIGKILL)
    client.submit(snapshot(), [request()])
    inbox.wait(lambda: inbox.errors, "a report")
    assert "not started again" in inbox.errors[0]
    with pytest.raises(RenderError, match="no images any more: .*signal 9"):
        client.render_sync(snapshot(), [request()], DEADLINE)
    client.submit(snapshot(), [request()])  # harmless: physics goes on
    assert client.dropped["eye"] == 1


def test_a_worker_that_dies_now_and_then_is_always_started_again(client, inbox, monkeypatch):
    monkeypatch.setattr(module, "MAX_RESTARTS", 1)
    monkeypatch.setattr(module, "WINDOW", 0.0)  # the last death is long ago
    for number in (1, 2):
        os.kill(client._worker.process.pid, signal.SIGKILL)
        with pytest.raises(RenderError, match="signal 9"):
            client.render_sync(snapshot(), [request()], DEADLINE)
        inbox.wait(lambda: len(inbox.errors) == number, "a report")  # noqa: B023
        assert client.render_sync(snapshot(step=number), [request()], DEADLINE)
    assert client.restarts == 2


def test_hanging_worker_meets_the_deadline(client):
    client.render_sync(snapshot(), [request()], DEADLINE)
    pid = client._worker.process.pid
    os.kill(pid, signal.SIGSTOP)
    with pytest.raises(RenderError, match="no image of eye for step 7 within 0.2 s"):
        client.render_sync(snapshot(), [request()], 0.2)
    client.close()
    wait_ended(pid, DEADLINE)


def test_a_stopped_worker_is_replaced_and_that_is_said_once(client, inbox, monkeypatch):
    monkeypatch.setattr(worker_process, "HANG_TIMEOUT", 2.5)
    client.render_sync(snapshot(), [request()], DEADLINE)
    first = client._worker.process.pid
    os.kill(first, signal.SIGSTOP)
    client.submit(snapshot(step=1), [request()])
    inbox.wait(lambda: inbox.errors, "a report")
    wait_ended(first, DEADLINE)
    client.submit(snapshot(step=2), [request()])
    inbox.wait(lambda: inbox.frames and inbox.frames[-1].step == 2, "a picture of the new one")
    assert client.restarts == 1 and len(inbox.errors) == 1
    assert f"pid {first}) did nothing for 2.5 s" in inbox.errors[0]


def test_ctrl_c_is_left_to_the_parent(shared):
    shared.render_sync(snapshot(), [request()], DEADLINE)
    os.kill(shared._worker.process.pid, signal.SIGINT)
    shared.render_sync(snapshot(), [request()], DEADLINE)
    assert shared.restarts == 0


def test_errors_name_camera_and_body(shared, inbox, sources):
    with pytest.raises(RenderError, match="camera lost: body 9"):
        shared.render_sync(snapshot(), [request("lost", key=9)], DEADLINE)
    ghost = BodySource(5, False, (VisualLink(shapes=(GHOST,)),))
    shared.set_sources([*sources, ghost])
    assert shared.render_sync(snapshot(), [request()], DEADLINE)
    inbox.wait(
        lambda: any("body 5: PyBullet cannot load" in text for text in inbox.errors), "the bad body"
    )
    assert shared.restarts == 0


def test_worker_ends_when_its_parent_is_killed():
    code = textwrap.dedent("""
        import sys, time
        from bullet_sim.render.client import RenderClient
        client = RenderClient()
        client.start('tiny')
        print(client._worker.process.pid, flush=True)
        time.sleep(60)""")
    wait_ended(pid_from_killed(code), DEADLINE)
