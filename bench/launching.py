"""Worlds on ROS masters of their own: starting, finding and ending their processes, observers."""

import json
import os
import pathlib
import signal
import subprocess
import sys
import threading
import time
import uuid

from figures import BenchError
from paddock_common.process import free_port
from usage import procfs, roles_of

BENCH = pathlib.Path(__file__).resolve().parent
WORLDS = BENCH / "worlds"
SCRIPT = BENCH / "observe.py"
RESPONSE_LIMIT = 60.0  # wall time for an observer's answer [s]; a service has 30 s of its own
TAG = "PADDOCK_BENCH"  # variable by which all that a Graph has started is known
POLL = 0.03  # [s] between two looks at processes that are being killed


class Unresponsive(BenchError):
    """An observer gave no answer in time."""


class Observer:
    """A process that observes a graph: lines to it, JSON lines from it.

    Args:
        log: File for what it prints on stderr.
        name: MODULE.FUNCTION, see observe.py.
    """

    def __init__(self, environment, log, name, *arguments):
        self.process = subprocess.Popen(
            [sys.executable, str(SCRIPT), name, *map(str, arguments)],
            env=environment,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=log,
            text=True,
        )
        self._lines, self._changed = [], threading.Condition()
        self._unwanted, self._ended = 0, False  # answers to come that nobody waits for
        self._asking = threading.Lock()
        threading.Thread(target=self._read, daemon=True).start()

    def _read(self):
        with self.process.stdout as lines:
            for line in lines:
                with self._changed:
                    if self._unwanted:
                        self._unwanted -= 1
                        continue
                    self._lines.append(line)
                    self._changed.notify_all()
        with self._changed:
            self._ended = True
            self._changed.notify_all()

    def tell(self, text):
        """Sends a line."""
        try:
            self.process.stdin.write(f"{text}\n")
            self.process.stdin.flush()
        except OSError:
            pass  # it has ended, which answer() says

    def answer(self, limit=None):
        """Waits for the next answer, a dict.

        Args:
            limit: Longest wait in wall time [s]; None: until it ends.

        Raises:
            Unresponsive: There is none within the limit.
            BenchError: The observer says that it cannot go on, or has ended.
        """
        with self._changed:
            if not self._changed.wait_for(lambda: self._lines or self._ended, limit):
                self._unwanted += 1
                raise Unresponsive(f"was not answered within {limit:g} s")
            line = self._lines.pop(0) if self._lines else None
        if line is None:
            raise BenchError(f"an observer ended early (exit status {self.process.wait()})")
        answer = json.loads(line)
        if "error" in answer:
            raise BenchError(answer["error"])
        return answer

    def ask(self, text, limit=None):
        """Sends a line and waits for the answer, see answer()."""
        with self._asking:
            self.tell(text)
            try:
                return self.answer(limit)
            except Unresponsive as error:
                raise Unresponsive(f"{text} {error}") from None

    def request(self, limit=RESPONSE_LIMIT, **fields):
        """Sends a JSON object and waits for the answer, see answer()."""
        return self.ask(json.dumps(fields), limit)

    def send(self, **fields):
        """Sends a JSON object whose answer nobody waits for."""
        with self._asking:
            with self._changed:
                self._unwanted += 1
            self.tell(json.dumps(fields))

    def close(self):
        """Ends it."""
        self.process.kill()
        self.process.wait()
        try:
            self.process.stdin.close()
        except OSError:  # with a line that it has not read
            pass


class Graph:
    """Processes on a ROS master of their own, known by a tag in their environment.

    Args:
        log: File that takes what they print.

    Attributes:
        tag: Of all processes.
        environment: dict of variables, without the tag.
    """

    def __init__(self, log, **variables):
        self.tag, self.port = uuid.uuid4().hex, free_port()
        self.environment = dict(
            os.environ,
            ROS_IP="127.0.0.1",
            ROS_MASTER_URI=f"http://127.0.0.1:{self.port}",
            **variables,
        )
        for name in ("ROS_HOSTNAME", "PYTHONDONTWRITEBYTECODE"):  # the second slows each start
            self.environment.pop(name, None)
        self._log, self._started = log, []

    def popen(self, *command, environment=None, **variables):
        """Starts a process with the tag, in a session of its own.

        Args:
            environment: Variables; None: those of the graph.

        Returns:
            subprocess.Popen.
        """
        process = subprocess.Popen(
            command,
            env={**(environment or self.environment), TAG: self.tag, **variables},
            stdin=subprocess.DEVNULL,
            stdout=self._log,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        )
        self._started.append(process)
        return process

    def pids(self):
        """Pids of its processes, ascending."""
        return procfs.marked(TAG, self.tag)

    def roles(self):
        """Role -> pids of its processes, see usage.role_of."""
        return roles_of(self.pids())

    def close(self):
        """Ends everything, by SIGKILL."""
        while left := self.pids():
            for pid in left:
                procfs.send(pid, signal.SIGKILL)
            time.sleep(POLL)
        for process in self._started:
            process.wait()


class Launch(Graph):
    """A launch file on a master of its own; a context manager.

    Args:
        log: file that takes what roslaunch and its nodes print.
        arguments: launch arguments, NAME:=VALUE.
        file: of the launch file: words after roslaunch, a package and a name or a path.
        with_control: also start deepracer_control's node (original mode).
        parameters: also load the car's controller YAML.
    """

    def __init__(
        self,
        log,
        arguments=(),
        file=("track_model", "world.launch"),
        with_control=False,
        parameters=False,
    ):
        super().__init__(log)
        self._command = ["roslaunch", "-p", str(self.port), *file, *arguments]
        self._with_control, self._parameters = with_control, parameters
        self._observers = []

    def __enter__(self):
        self.popen(*self._command)
        if self._with_control:
            self._popen_later("rosrun", "deepracer_control", "control")
        if self._parameters:
            path = subprocess.check_output(["rospack", "find", "track_model"], text=True).strip()
            self._popen_later("rosparam", "load", f"{path}/config/agent_control.yaml")
        return self

    def _popen_later(self, *command):
        """Starts something as soon as the master answers."""
        script = 'until rostopic list >/dev/null 2>&1; do sleep 0.1; done; exec "$@"'
        self.popen("bash", "-c", script, "--", *command)

    def observer(self, name, *arguments):
        """Starts an Observer on this master; it ends with the launch at the latest."""
        observer = Observer(self.environment, self._log, name, *arguments)
        self._observers.append(observer)
        return observer

    def roles(self):
        """Role -> pids of the graph's, the observers' and the bench's own processes."""
        observers = [observer.process.pid for observer in self._observers]
        return dict(super().roles(), observer=observers, bench=[os.getpid()])

    def pid(self, role):
        """Pid of the first process of a role, see usage.role_of; None when there is none."""
        return self.roles().get(role, [None])[0]

    def __exit__(self, *_):
        for observer in self._observers:
            observer.close()
        launch, *others = self._started
        for process in others:
            if process.poll() is None:
                os.killpg(process.pid, signal.SIGTERM)
        for number, limit in ((signal.SIGINT, 20), (signal.SIGTERM, 10)):
            if launch.poll() is not None:
                break
            os.killpg(launch.pid, number)
            try:
                launch.wait(limit)
            except subprocess.TimeoutExpired:
                continue
        self.close()
