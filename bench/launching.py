"""Starting and stopping a world of our own, and reading what its processes cost."""

import os
import pathlib
import signal
import socket
import subprocess
import sys

TICK = os.sysconf('SC_CLK_TCK')


def free_port():
    """A TCP port of the loopback interface that is free now."""
    with socket.socket() as sock:
        sock.bind(('127.0.0.1', 0))
        return sock.getsockname()[1]


def _stat(pid):
    """Fields of /proc/PID/stat after the command name; empty when it is gone."""
    try:
        return pathlib.Path(f'/proc/{pid}/stat').read_text().rpartition(')')[2].split()
    except OSError:
        return []


def cpu_seconds(pid):
    """User and system time of all threads of a process [s]; 0 when it is gone."""
    fields = _stat(pid)
    return (int(fields[11]) + int(fields[12])) / TICK if fields else 0.0


def descendants(pid):
    """Pids of the children of a process and theirs."""
    children = {}
    for entry in os.listdir('/proc'):
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
        return pathlib.Path(f'/proc/{pid}/cmdline').read_bytes().split(b'\0')
    except OSError:
        return []


class Launch:
    """track_model world.launch on a master of its own; a context manager.

    Args:
        log: file that takes what roslaunch and its nodes print.
        arguments: launch arguments, NAME:=VALUE.
    """

    def __init__(self, log, arguments=()):
        port = free_port()
        self.environment = dict(os.environ, ROS_IP='127.0.0.1',
                                ROS_MASTER_URI=f'http://127.0.0.1:{port}')
        self.environment.pop('ROS_HOSTNAME', None)
        self._command = ['roslaunch', '-p', str(port), 'track_model', 'world.launch', *arguments]
        self._log, self._process, self._observers = log, None, []

    def __enter__(self):
        self._process = subprocess.Popen(
            self._command, env=self.environment, stdin=subprocess.DEVNULL, stdout=self._log,
            stderr=self._log, start_new_session=True)
        return self

    def observer(self, *arguments):
        """Start observe.py on this master; it ends with the launch at the latest."""
        script = pathlib.Path(__file__).with_name('observe.py')
        process = subprocess.Popen(
            [sys.executable, str(script), *map(str, arguments)], env=self.environment,
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=self._log, text=True)
        self._observers.append(process)
        return process

    def find(self, *words):
        """Pid of the first process below roslaunch whose command line holds all words.

        Returns:
            None when there is none.
        """
        for pid in sorted(descendants(self._process.pid)):
            line = b' '.join(_command(pid)).decode(errors='replace')
            if all(word in line for word in words):
                return pid
        return None

    def bridge(self):
        """Pid of the bridge, or None."""
        return self.find('bullet_bridge', '__name:=gazebo')

    def render_worker(self):
        """Pid of the render process, or None while there is none."""
        return self.find('bullet_sim.render.worker')

    def __exit__(self, *_):
        for process in self._observers:
            if process.poll() is None:
                process.terminate()
            process.wait()
            process.stdin.close()
            process.stdout.close()
        below = descendants(self._process.pid)
        for number, patience in ((signal.SIGINT, 20), (signal.SIGTERM, 10), (signal.SIGKILL, 5)):
            if self._process.poll() is not None:
                break
            try:
                os.killpg(self._process.pid, number)
                self._process.wait(patience)
            except (subprocess.TimeoutExpired, ProcessLookupError):
                continue
            if number == signal.SIGKILL:    # roslaunch could not stop its nodes
                for pid in below:
                    try:
                        os.kill(pid, signal.SIGKILL)
                    except ProcessLookupError:
                        pass
