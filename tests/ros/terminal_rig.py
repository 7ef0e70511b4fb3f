"""A real terminal (tmux) and a real X server (Xvfb) for the teleops' tests, both of their own."""

import os
import shlex
import subprocess
import tempfile
from pathlib import Path
from xmlrpc.client import ServerProxy

import psutil
import rosgraph
import rospy
from sim_client import wait_until
from testing import start_x_server

LIMIT = 90.0  # longest wait for what should come within a second [s]


class Terminal:
    """One tmux server with one pane that runs a shell."""

    def __init__(self, width=80, height=24, **environment):
        """Starts it.

        Args:
            environment: Variables of the shell; None removes one.
        """
        self._directory = tempfile.TemporaryDirectory()
        self._socket = str(Path(self._directory.name) / "tmux")
        self._count = 0
        variables = {
            name: value
            for name, value in os.environ.items()
            if name not in environment and name not in ("TMUX", "TMUX_PANE", "COLUMNS", "LINES")
        }
        variables.update({name: value for name, value in environment.items() if value is not None})
        subprocess.run(
            [
                "tmux",
                "-S",
                self._socket,
                "-f",
                "/dev/null",
                "new-session",
                "-d",
                "-x",
                str(width),
                "-y",
                str(height),
                "bash --norc --noprofile",
            ],
            env=variables,
            check=True,
            timeout=LIMIT,
        )
        try:
            self.settings = self.run("stty -a")
        except BaseException:
            self.close()
            raise

    def tmux(self, *arguments):
        """Runs a tmux command and returns what it prints."""
        return subprocess.run(
            ["tmux", "-S", self._socket, *arguments],
            check=True,
            timeout=LIMIT,
            stdout=subprocess.PIPE,
            text=True,
        ).stdout

    def keys(self, *names):
        """Presses keys by tmux' names."""
        self.tmux("send-keys", *names)

    def type(self, line):
        """Types a line for the shell and Enter."""
        self.tmux("send-keys", "-l", line)
        self.keys("Enter")

    def run(self, command):
        """Runs a command in the pane's shell and returns what it prints, without the sizes."""
        self._count += 1
        out = Path(self._directory.name) / f"out{self._count}"
        self.type(f"{command} > {shlex.quote(str(out))}.part; mv {out}.part {out}")
        wait_until(out.exists, f"the shell to run {command}", LIMIT)
        return "\n".join(line for line in out.read_text().splitlines() if "rows" not in line)

    def screen(self):
        """Returns what the pane shows."""
        return self.tmux("capture-pane", "-p")

    def wait_screen(self, *words):
        """Waits until the pane shows all words and returns the screen."""
        try:
            wait_until(
                lambda: all(word in self.screen() for word in words),
                f"{words} on the screen",
                LIMIT,
            )
        except AssertionError as error:
            raise AssertionError(f"{error}; it shows:\n{self.screen()}") from None
        return self.screen()

    def resize(self, width, height):
        """Changes the size."""
        self.tmux("resize-window", "-x", str(width), "-y", str(height))

    def state(self):
        """Returns (alternate screen on, cursor visible) as tmux says."""
        return tuple(self.tmux("display-message", "-p", "#{alternate_on} #{cursor_flag}").split())

    def close(self):
        """Ends it all."""
        self.tmux("kill-server")
        self._directory.cleanup()


class XServer:
    """An Xvfb of its own."""

    def __init__(self):
        """Starts it."""
        self._process, self.display = start_x_server("1024x768")

    def key(self, action, *names):
        """Sends real key events.

        Args:
            action: "keydown", "keyup" or "key" (both).
            names: X names of keys.
        """
        self.xdotool(action, *names)

    def xdotool(self, *arguments):
        """Runs xdotool and returns what it prints; a search may find nothing."""
        return subprocess.run(
            ["xdotool", *arguments],
            check=arguments[0] != "search",
            timeout=LIMIT,
            env=dict(os.environ, DISPLAY=self.display),
            stdout=subprocess.PIPE,
            text=True,
        ).stdout

    def close(self):
        """Ends it."""
        self._process.terminate()
        self._process.wait(LIMIT)


def node_pid(name):
    """Returns the process id of a running node, or None when it does not answer."""
    try:
        uri = rosgraph.Master(rospy.get_name()).lookupNode(name)
        return ServerProxy(uri).getPid(rospy.get_name())[2]
    except (rosgraph.MasterException, OSError):
        return None


def parent_of(pid):
    """Returns the process id of a process' parent."""
    return psutil.Process(pid).ppid()
