"""Starting and stopping a world of our own, and finding its processes."""

import json
import os
import pathlib
import signal
import subprocess
import sys

from figures import BenchError
from paddock_common.testing import free_port
from processes import descendants
from usage import roles_of

WORLDS = pathlib.Path(__file__).with_name("worlds")


class Observer:
    """An observer's process: lines to it, JSON from it."""

    def __init__(self, process):
        self.process = process

    def tell(self, text):
        """Send a line."""
        self.process.stdin.write(f"{text}\n")
        self.process.stdin.flush()

    def answer(self):
        """The next answer, a dict.

        Raises:
            BenchError: the observer says that it cannot go on, or has ended.
        """
        line = self.process.stdout.readline()
        if not line:
            raise BenchError(f"an observer ended early (exit status {self.process.wait()})")
        answer = json.loads(line)
        if "error" in answer:
            raise BenchError(answer["error"])
        return answer

    def ask(self, text):
        """Send a line and wait for the answer."""
        try:
            self.tell(text)
        except BrokenPipeError:
            pass  # answer() says what became of it
        return self.answer()


class Launch:
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
        port = free_port()
        self.environment = dict(
            os.environ, ROS_IP="127.0.0.1", ROS_MASTER_URI=f"http://127.0.0.1:{port}"
        )
        for name in ("ROS_HOSTNAME", "PYTHONDONTWRITEBYTECODE"):  # the second slows each start
            self.environment.pop(name, None)
        self._command = ["roslaunch", "-p", str(port), *file, *arguments]
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

    def roles(self):
        """Role -> pids of roslaunch, everything below it, and the bench's own processes."""
        pids = [self._process.pid, *descendants(self._process.pid)]
        for process in self._others:
            pids += [process.pid, *descendants(process.pid)]
        return dict(
            roles_of(pids),
            observer=[process.pid for process in self._observers],
            bench=[os.getpid()],
        )

    def pid(self, role):
        """Pid of the first process of a role, see usage.role_of; None when there is none."""
        return self.roles().get(role, [None])[0]

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
        self._stop()

    def _stop(self):
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
