"""The bridge's end of the viewer: responds, and survives whatever the viewer does."""

import os
import signal
import sys
import threading
import time

import pytest
from bullet_bridge.loop.jobs import JobQueue
from bullet_bridge.plugins import viewer_link
from bullet_bridge.plugins.viewer_link import ViewerLink, missing_display
from bullet_sim.formats.sdf import world as sdf
from bullet_sim.world import World
from paddock_common.testing import wait_for

DEADLINE = 90.0  # [s] of wall time
CLIENT = """
import sys
from multiprocessing.connection import Connection
link = Connection(int(sys.argv[1]))
def ask(*message):
    link.send(message)
    return link.recv()
"""
WRITE = "\nopen({path!r}, 'w').write(repr(found))\n"


class Server:
    """The part of the server that the link uses."""

    def __init__(self, world):
        self.world, self.paused, self.calls = world, False, []

    def set_paused(self, paused):
        self.paused = paused
        self.calls.append(("paused", paused))

    def reset(self, time):
        self.calls.append(("reset", time))

    def begin_steps(self, count):
        assert self.paused
        self.world.step(count)


class Rig:
    """A world with a simulation thread, and viewers made of a few lines of Python."""

    def __init__(self, monkeypatch):
        monkeypatch.setenv("QT_QPA_PLATFORM", "offscreen")
        self.warnings = []
        monkeypatch.setattr(
            viewer_link.rospy, "logwarn", lambda text, *values: self.warnings.append(text % values)
        )
        self.world = World()
        self.world.spawn(sdf.ground_plane())
        self.jobs, self.server = JobQueue(), Server(self.world)
        self._going = True
        self._thread = threading.Thread(target=self._simulate)
        self._thread.start()
        self.link = None

    def _simulate(self):
        while self._going:
            self.jobs.run_pending(wait=0.01)

    def start(self, script):
        self.link = ViewerLink(
            self.jobs, self.world, self.server, "tiny", (sys.executable, "-c", script)
        )
        return self.link.open()

    def wait_closed(self):
        wait_for(lambda: not self.link.is_open(), "the end of the viewer")

    def alive(self):
        return self.jobs.call(lambda: self.world.step() or True, timeout=DEADLINE)

    def close(self):
        if self.link is not None:
            self.link.close()
        self._going = False
        self._thread.join()
        self.jobs.close()
        self.world.close()


@pytest.fixture(name="rig")
def _rig(monkeypatch):
    rig = Rig(monkeypatch)
    yield rig
    rig.close()


def run(rig, script, tmp_path):
    """Has a viewer run a script that leaves its findings in `found`; returns them as text."""
    path = tmp_path / "found"
    assert rig.start(CLIENT + script + WRITE.format(path=str(path))) == ""
    rig.wait_closed()
    assert rig.warnings == []
    return path.read_text()


def test_a_view_has_the_world(rig, tmp_path):
    found = run(
        rig,
        """
kind, view = ask('view')
again = ask('view')[1]
found = kind, [m.name for m in view.models], len(view.sources), again.sources, sys.argv[2]
""",
        tmp_path,
    )
    assert found == "('view', ['ground_plane'], 1, None, 'tiny')"


def test_buttons_reach_the_server(rig, tmp_path):
    run(
        rig,
        """
for word in ('pause', 'unpause', 'reset'):
    link.send((word,))
found = ask('view')[0]
""",
        tmp_path,
    )
    assert rig.server.calls == [("paused", True), ("paused", False), ("reset", True)]


@pytest.mark.parametrize("count", [1, 100, 333])
def test_step_pauses_and_advances_exactly(rig, tmp_path, count):
    found = run(
        rig,
        f"""
link.send(('step', {count}))
view = ask('view')[1]
found = view.snapshot.step, view.paused
""",
        tmp_path,
    )
    assert found == f"({count}, True)"


def test_an_error_is_returned_and_the_viewer_stays(rig, tmp_path):
    def refuse(time):
        raise viewer_link.SimError("no reset today")

    rig.server.reset = refuse
    assert (
        run(rig, "found = ask('reset'), ask('view')[0]", tmp_path)
        == "(('error', 'no reset today'), 'view')"
    )


@pytest.mark.parametrize(
    "script, word",
    [
        ("raise RuntimeError('no screen')", "no screen"),
        ("import os; os.abort()", "signal 6"),
        ("import sys; sys.exit(3)", "exit code 3"),
    ],
)
def test_a_viewer_that_fails_is_one_warning(rig, script, word):
    assert rig.start(script) == ""
    rig.wait_closed()
    assert len(rig.warnings) == 1 and word in rig.warnings[0]
    assert rig.alive()


def test_a_killed_viewer_is_one_warning_and_can_be_opened_again(rig, tmp_path):
    rig.start(CLIENT + "while True: ask('view')")
    os.kill(rig.link.process.pid, signal.SIGKILL)
    rig.wait_closed()
    assert len(rig.warnings) == 1 and "signal 9" in rig.warnings[0]
    assert rig.alive()
    first = rig.link.process.pid
    assert rig.link.open() == "" and rig.link.process.pid != first


def test_opening_twice_keeps_the_one(rig):
    rig.start(CLIENT + "link.recv()")
    pid = rig.link.process.pid
    assert rig.link.open() == "" and rig.link.process.pid == pid


def test_closing_ends_the_viewer_without_a_warning(rig):
    rig.start(
        CLIENT
        + """
try:
    link.recv()
except EOFError:
    pass
"""
    )
    rig.link.close()
    assert rig.link.process.poll() == 0
    assert rig.warnings == []


def test_the_end_of_the_simulation_ends_the_viewer(rig):
    rig.start(CLIENT + "try:\n    while True: ask('view')\nexcept (EOFError, OSError): pass")
    rig.jobs.close()
    rig.wait_closed()
    assert rig.link.process.poll() == 0


def test_without_a_display_one_warning_and_no_process(rig, monkeypatch):
    for name in ("DISPLAY", "WAYLAND_DISPLAY", "QT_QPA_PLATFORM"):
        monkeypatch.delenv(name, raising=False)
    assert "no display" in rig.start("raise SystemExit(9)")
    assert rig.link.process is None and len(rig.warnings) == 1


@pytest.mark.parametrize(
    "environment, can",
    [
        ({}, False),
        ({"DISPLAY": ""}, False),
        ({"DISPLAY": ":0"}, True),
        ({"WAYLAND_DISPLAY": "wayland-0"}, True),
        ({"QT_QPA_PLATFORM": "offscreen"}, True),
    ],
)
def test_display(environment, can):
    assert (missing_display(environment) == "") is can


def test_a_missing_program_is_reported(rig):
    rig.link = ViewerLink(rig.jobs, rig.world, rig.server, "tiny", ("/no/such/viewer",))
    assert "/no/such/viewer" in rig.link.open()
    assert not rig.link.is_open()


def test_the_real_viewer_opens_and_closes(rig):
    rig.link = ViewerLink(rig.jobs, rig.world, rig.server, "tiny")
    assert rig.link.open() == ""
    observed = []
    view = viewer_link.Observer.view
    end = time.monotonic() + DEADLINE

    def spy(observer, paused):
        observed.append(paused)
        return view(observer, paused)

    viewer_link.Observer.view = spy
    try:
        while not observed:
            assert time.monotonic() < end and rig.link.is_open(), rig.warnings
            rig.jobs.call(rig.world.step)
            time.sleep(0.05)
    finally:
        viewer_link.Observer.view = view
    rig.link.close()
    assert rig.link.process.poll() == 0 and rig.warnings == []
