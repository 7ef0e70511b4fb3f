"""Runs each tutorial, and what other pages name, as a reader does: files, terminals, commands."""

import contextlib
import os
import re
import shutil
import signal
import subprocess
import tempfile
import time
from xmlrpc.client import ServerProxy

import page as tutorial
import pytest
from paddock_common.process import free_port
from page_commands import OTHERS
from testing import start_x_server

LIMIT = 240.0  # of one box [s]
UP = 120.0  # until a world and a robot in it are up [s]
END = 30.0  # of a terminal after Ctrl-C [s]


class Reader:
    """Somebody with a screen, a home and terminals."""

    def __init__(self, home, display):
        self.home, self.variables = home, home / "variables"
        self.variables.write_text("")
        self.printed, self.terminals = "", []
        # rqt, Qt and matplotlib keep their files in the reader's home
        self.environment = dict(
            os.environ,
            HOME=str(home),
            DISPLAY=display,
            ROS_MASTER_URI=f"http://127.0.0.1:{free_port()}",
            XDG_CACHE_HOME=str(home / ".cache"),
        )
        for name in ("WAYLAND_DISPLAY", "QT_QPA_PLATFORM", "ROS_PACKAGE_PATH", "XDG_CONFIG_HOME"):
            self.environment.pop(name, None)

    def save(self, box):
        path = self.home / re.sub("^~/", "", box.path)
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(box.text)

    def _shell(self, text, output):
        keep = f"\ndeclare -px | grep ' ROS_PACKAGE_PATH=' > {self.variables} || true\n"
        script = f"set -e\ncd {tutorial.ROOT}\n. {self.variables}\n{text}{keep}"
        return subprocess.Popen(
            ["bash", "-c", script],
            env=self.environment,
            stdin=subprocess.DEVNULL,
            stdout=output,
            stderr=subprocess.STDOUT,
            start_new_session=True,
            text=True,
        )

    def run(self, box):
        """Types a box; its commands have to end well."""
        with tempfile.TemporaryFile("w+") as output:
            process = self._shell(box.text, output)
            try:
                status = process.wait(LIMIT)
            except subprocess.TimeoutExpired:
                status = "none: it did not end"
                end(process)
            output.seek(0)
            printed = output.read()
        self.printed += printed
        assert status == 0, f"line {box.line}: exit status {status}:\n{printed}\n{self.logs()}"

    def open_terminal(self, box):
        """Types a box in a terminal of its own; the first brings a world, which is waited for."""
        log = self.home / f"terminal{len(self.terminals)}.log"
        with log.open("w") as output:
            self.terminals.append((self._shell(box.text, output), log))
        if len(self.terminals) == 1:
            self._wait_for_world()
        else:
            time.sleep(1.0)

    def _wait_for_world(self):
        """Waits until the simulator has a service and a robot's controllers run, as people do."""
        master, end_of_wait = ServerProxy(self.environment["ROS_MASTER_URI"]), time.monotonic() + UP
        while time.monotonic() < end_of_wait:
            with contextlib.suppress(OSError):
                topics = {name for name, _ in master.getPublishedTopics("/reader", "")[2]}
                if any(name.endswith("/joint_states") for name in topics):
                    return
            assert self.terminals[0][0].poll() is None, f"no world came up:\n{self.logs()}"
            time.sleep(0.5)
        raise AssertionError(f"no robot's joint states within {UP:g} s:\n{self.logs()}")

    def expect(self, box):
        for line in box.text.splitlines():
            assert line in self.printed, f"line {box.line}: {line!r} is not in:\n{self.printed}"

    def logs(self):
        return "\n".join(f"{log.name}:\n{log.read_text()[-3000:]}" for _, log in self.terminals)

    def close(self):
        """Presses Ctrl-C in each terminal, the last first; none may have ended badly before."""
        ended = [log.name for process, log in self.terminals if process.poll() not in (None, 0)]
        for process, _ in reversed(self.terminals):
            end(process)
        assert not ended, f"{ended} ended before the page's end:\n{self.logs()}"


def end(process):
    """Ends a session as Ctrl-C does, and at last by force."""
    if process.poll() is None:
        os.killpg(process.pid, signal.SIGINT)
        try:
            process.wait(END)
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            process.wait()


@pytest.fixture(scope="module")
def display():
    """An X server of its own."""
    server, name = start_x_server("1280x800")
    yield name
    server.terminate()
    server.wait(30)


@pytest.mark.parametrize("path", [*tutorial.PAGES, OTHERS], ids=lambda path: path.stem)
def test_page(path, display, tmp_path):
    reader = Reader(tmp_path, display)
    (tmp_path / "lessons").mkdir()
    steps = {
        "file": reader.save,
        "run": reader.run,
        "terminal": reader.open_terminal,
        "expect": reader.expect,
    }
    try:
        for box in tutorial.boxes(path):
            steps[box.kind](box)
    finally:
        reader.close()
    keep = os.environ.get("TUTORIAL_FILES")  # to take pictures from
    if keep:
        shutil.copytree(tmp_path / "lessons", os.path.join(keep, path.stem), dirs_exist_ok=True)
