"""One session: a ROS master, the launch of soak.launch on it, and two observers."""

import signal
import subprocess
import sys
import time
import uuid

from figures import BenchError
from launching import BENCH, WORLDS, Observer
from usage import procfs

from soaking.process_under_test import ProcessesUnderTest

SUPERVISOR = BENCH.parent / "commands" / "supervisor.py"
START_LIMIT = 180.0  # wall time for a session to come up [s]
STOP_LIMIT = 30.0  # wall time from SIGINT to the end [s]; beyond it is a failure anyhow
CORE = ("rosmaster", "roscore", "rosout")
OURS = ("bridge", "relay", "render_worker", "control", "teleop", "drive", "odom_tf",
        "robot_state_publisher", "roslaunch", *CORE)  # fmt: skip


class Session(ProcessesUnderTest):
    """A master, the launch and the observers.

    Args:
        folder: pathlib.Path for logs and temporary files, emptied first.

    Attributes:
        launch: subprocess.Popen of roslaunch.
    """

    def __init__(self, folder):
        ros_home = str(folder / "ros_home")
        super().__init__(folder, "launch.log", ROS_HOME=ros_home, QT_QPA_PLATFORM="offscreen")
        self._observer_log = open(folder / "observers.log", "w")
        self._core = self.launch = self.monitor = self.operator = self._supervisor = None
        self._restarted = []

    def start(self):
        """Starts everything and waits until all topics of the monitor deliver.

        Raises:
            BenchError: It does not come up.
        """
        self.start_core()
        file = str(WORLDS / "soak.launch")
        session = uuid.uuid4().hex
        self.launch = self.popen("roslaunch", "--wait", file, PADDOCK_SESSION=session)
        self._supervisor = subprocess.Popen(  # as ./run starts it
            [
                sys.executable,
                "-I",
                "-S",
                str(SUPERVISOR),
                str(self.launch.pid),
                session,
                "roslaunch",
            ],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=self._log,
            start_new_session=True,
        )
        self.monitor = Observer(self.environment, self._observer_log, "soak.monitor")
        self.operator = Observer(self.environment, self._observer_log, "soak.operator")
        end = time.monotonic() + START_LIMIT
        while not self.monitor.request(what="sample")["complete"]:
            if self.launch.poll() is not None or time.monotonic() > end:
                raise BenchError(f"the session does not come up, see {self._log.name}")
            time.sleep(0.5)
        self.operator.request(what="ready", limit=START_LIMIT)

    def start_core(self):
        """Starts a roscore on the session's port."""
        self._core = self.popen("roscore", "-p", str(self.port))

    def roles(self):
        """Role -> pids of the session's own processes."""
        return {role: pids for role, pids in super().roles().items() if role in OURS}

    def pid(self, role):
        """Newest pid of a role, or None."""
        return self.roles().get(role, [None])[-1]

    def send(self, role, number):
        """Sends a signal to all processes of a role; returns their pids."""
        return [pid for pid in self.roles().get(role, []) if procfs.send(pid, number)]

    def recipe(self, role):
        """What starts a role's process again: command line and environment."""
        pid = self.pid(role)
        return None if pid is None else (procfs.arguments(pid), procfs.environment(pid))

    def start_again(self, recipe):
        """Starts a node again as roslaunch did."""
        command, environment = recipe
        self._restarted.append(self.popen(*command, environment=environment))

    def alive(self):
        """Whether roslaunch runs and the simulator with it."""
        return self.launch.poll() is None and self.pid("bridge") is not None

    def stop(self, number=signal.SIGINT):
        """Ends roslaunch by a signal; returns what wait_ended() does."""
        self._close_observers()
        begin = time.monotonic()
        if self.launch is not None and self.launch.poll() is None:
            procfs.send(self.launch.pid, number)
        result = self.wait_ended(begin=begin)
        self.close()
        return result

    def wait_ended(self, limit=STOP_LIMIT, spared=CORE, begin=None):
        """Waits until only the master runs, see ProcessesUnderTest.wait_ended()."""
        for process in self._restarted:  # those that roslaunch does not know
            if process.poll() is None:
                process.send_signal(signal.SIGINT)
        return super().wait_ended(limit, spared, begin)

    def close(self):
        """Ends the master and, if need be by SIGKILL, everything else."""
        self._close_observers()
        if self._core is not None and self._core.poll() is None:
            self._core.send_signal(signal.SIGINT)
            super().wait_ended(10.0)
        super().close()
        if self._supervisor is not None:
            self._supervisor.wait()
        self._observer_log.close()

    def _close_observers(self):
        for observer in (self.monitor, self.operator):
            if observer is not None:
                observer.close()
