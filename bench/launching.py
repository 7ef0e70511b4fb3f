"""Starting and stopping a world of our own, and reading what its processes cost."""

import json
import os
import pathlib
import signal
import socket
import subprocess
import sys

from figures import BenchError

TICK = os.sysconf("SC_CLK_TCK")


def free_port():
    """A TCP port of the loopback interface that is free now."""
    with socket.socket() as sock:
        sock.bind(("127.0.0.1", 0))
        return sock.getsockname()[1]


def _stat(pid):
    """Fields of /proc/PID/stat after the command name; empty when it is gone."""
    try:
        return pathlib.Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    except OSError:
        return []


def cpu_seconds(pid):
    """User and system time of all threads of a process [s]; 0 when it is gone."""
    fields = _stat(pid)
    return (int(fields[11]) + int(fields[12])) / TICK if fields else 0.0


def memory_bytes(pid):
    """Proportional set size of a process (shared pages count by their share); 0 when gone."""
    try:
        for line in pathlib.Path(f"/proc/{pid}/smaps_rollup").read_text().splitlines():
            if line.startswith("Pss:"):
                return int(line.split()[1]) * 1024
    except OSError:
        pass
    return 0


class Observer:
    """An observer's process: lines to it, JSON from it."""

    def __init__(self, process):
        self.process = process

    def tell(self, text):
        """Send a line."""
        self.process.stdin.write(f"{text}\n")
        self.process.stdin.flush()

    def answer(self):
        """The next answer, a dict."""
        line = self.process.stdout.readline()
        if not line:
            raise BenchError(f"an observer ended early (exit status {self.process.wait()})")
        return json.loads(line)

    def ask(self, text):
        """Send a line and wait for the answer."""
        self.tell(text)
        return self.answer()


def descendants(pid):
    """Pids of the children of a process and theirs."""
    children = {}
    for entry in os.listdir("/proc"):
        if entry.isdigit():
            fields = _stat(entry)
            if fields:
                children.setdefault(int(fields[1]), []).append(int(entry))
    found, open_ends = [], [pid]
    while open_ends:
        new = children.get(open_ends.pop(), [])
        found += new
        open_ends += new
    return found


def _command(pid):
    try:
        return pathlib.Path(f"/proc/{pid}/cmdline").read_bytes().split(b"\0")
    except OSError:
        return []


class Launch:
    """A launch file on a master of its own; a context manager.

    Args:
        log: file that takes what roslaunch and its nodes print.
        arguments: launch arguments, NAME:=VALUE.
        package, file: the launch file.
        with_control: also start deepracer_control's node (original mode).
        parameters: also load the car's controller YAML.
    """

    def __init__(
        self,
        log,
        arguments=(),
        package="track_model",
        file="world.launch",
        with_control=False,
        parameters=False,
    ):
        port = free_port()
        self.environment = dict(
            os.environ, ROS_IP="127.0.0.1", ROS_MASTER_URI=f"http://127.0.0.1:{port}"
        )
        for name in ("ROS_HOSTNAME", "PYTHONDONTWRITEBYTECODE"):  # the second slows down each start
            self.environment.pop(name, None)
        self._command = ["roslaunch", "-p", str(port), package, file, *arguments]
        self._with_control, self._parameters = with_control, parameters
        self._log, self._process, self._observers, self._others = log, None, [], []

    def __enter__(self):
        self._process = subprocess.Popen(
            self._command,
            env=self.environment,
            stdin=subprocess.DEVNULL,
            stdout=self._log,
            stderr=self._log,
            start_new_session=True,
        )
        if self._with_control:
            self._beside("rosrun", "deepracer_control", "control")
        if self._parameters:
            path = subprocess.check_output(["rospack", "find", "track_model"], text=True).strip()
            self._beside("rosparam", "load", f"{path}/config/agent_control.yaml")
        return self

    def _beside(self, *command):
        """Start something that waits for the master itself."""
        script = 'until rostopic list >/dev/null 2>&1; do sleep 0.1; done; exec "$@"'
        self._others.append(
            subprocess.Popen(
                ["bash", "-c", script, "--", *command],
                env=self.environment,
                stdin=subprocess.DEVNULL,
                stdout=self._log,
                stderr=self._log,
                start_new_session=True,
            )
        )

    def observer(self, *arguments):
        """Start an observer on this master; it ends with the launch at the latest."""
        script = pathlib.Path(__file__).with_name("observe.py")
        process = subprocess.Popen(
            [sys.executable, str(script), *map(str, arguments)],
            env=self.environment,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._log,
            text=True,
        )
        self._observers.append(process)
        return Observer(process)

    def find(self, *words):
        """Pid of the first process below roslaunch whose command line holds all words.

        Returns:
            None when there is none.
        """
        for pid in sorted(descendants(self._process.pid)):
            line = b" ".join(_command(pid)).decode(errors="replace")
            if all(word in line for word in words):
                return pid
        return None

    def bridge(self):
        """Pid of the bridge, or None."""
        return self.find("bullet_bridge", "__name:=gazebo")

    def relay(self):
        """Pid of the process that sends for the bridge, or None."""
        return self.find("relay_process")

    def render_worker(self):
        """Pid of the render process, or None while there is none."""
        return self.find("bullet_sim.render.worker")

    def __exit__(self, *_):
        for process in self._observers:
            if process.poll() is None:
                process.terminate()
            process.wait()
            process.stdin.close()
            process.stdout.close()
        for process in self._others:
            if process.poll() is None:
                os.killpg(process.pid, signal.SIGTERM)
            process.wait()
        below = descendants(self._process.pid)
        for number, patience in ((signal.SIGINT, 20), (signal.SIGTERM, 10), (signal.SIGKILL, 5)):
            if self._process.poll() is not None:
                break
            try:
                os.killpg(self._process.pid, number)
                self._process.wait(patience)
            except (subprocess.TimeoutExpired, ProcessLookupError):
                continue
            if number == signal.SIGKILL:  # roslaunch could not stop its nodes
                for pid in below:
                    try:
                        os.kill(pid, signal.SIGKILL)
                    except ProcessLookupError:
                        pass
