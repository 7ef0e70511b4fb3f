"""A ROS graph for tests: a launch on a master of its own, in processes that a server forks."""

import contextlib
import multiprocessing
import multiprocessing.connection
import multiprocessing.forkserver
import os
import random
import re
import shutil
import signal
import sys
import tempfile
import threading
import time
import xmlrpc.client

from commands import procfs

MARK = "PADDOCK_TEST"  # variable by which all that a group of tests has started is known
LAUNCHED = "/launched"  # parameter that is set after all others of a launch file
START_LIMIT = 180.0  # wall time for a master to come up [s]
# wall time that processes may take to end by themselves [s]
END_GRACE = float(os.environ.get("PADDOCK_TEST_GRACE", "60"))
POLL = 0.1  # wall time between two looks [s]
LOG_LINES = 60  # of a launch, shown with a failed test
TOPICS = re.compile(r" \[topics: [^]]*\]")  # in each line of rosout.log
PRELOADED = [
    *("pytest", "unittest", "psutil", "yaml", "numpy", "rospy", "actionlib", "roslaunch"),
    *("roslaunch.parent", "roslaunch.pmon", "roslaunch.server", "roslaunch.nodeprocess", "tf2_ros"),
    *("geometry_msgs.msg", "nav_msgs.msg", "sensor_msgs.msg", "std_srvs.srv", "rosgraph_msgs.msg"),
    *("controller_manager_msgs.srv", "gazebo_msgs.msg", "gazebo_msgs.srv"),
]


class Graph:
    """What runs while tests do: a launch on a master of its own, or only the port for a master.

    Args:
        folder: Of the launch file and its logs.
        text: Of the launch file; None: there is no launch.
    """

    def __init__(self, folder, text):
        from paddock_common.process import free_port

        self.folder = folder
        self._temporary = tempfile.mkdtemp(prefix="paddock_")
        self.port = free_port()
        environment = dict(os.environ)
        for name in ("PYTEST_XDIST_WORKER", "PYTEST_CURRENT_TEST"):
            environment.pop(name, None)
        self.environment = {
            **environment,
            MARK: os.path.basename(self._temporary),
            "ROS_HOME": str(folder / "ros_home"),
            "ROS_LOG_DIR": str(folder / "log"),
            "ROS_MASTER_URI": f"http://127.0.0.1:{self.port}",
            "TMPDIR": self._temporary,
        }
        self.launch_log = folder / "launch.log"
        start_fork_server()
        self._launch = self.broken = None
        if text is not None:
            self._launch = self._start_launch(text)

    def _start_launch(self, text):
        file = self.folder / "world.launch"
        body, end, _ = text.rpartition("</launch>")
        file.write_text(f'{body}  <param name="{LAUNCHED}" value="true"/>\n{end}\n')
        arguments = ["roslaunch", "--screen", "-p", str(self.port), str(file)]
        process = forks().Process(
            target=run_launch, args=(arguments, self.environment, str(self.launch_log))
        )
        process.start()
        return process

    def wait_launched(self):
        """Waits until the launch has set its parameters.

        Raises:
            AssertionError: It has ended, or it takes too long.
        """
        if self._launch is None:
            return
        deadline = time.monotonic() + START_LIMIT
        while not has_parameter(self.environment["ROS_MASTER_URI"], LAUNCHED):
            if not self._launch.is_alive() or time.monotonic() > deadline:
                self.broken = f"the launch does not come up:\n{self.log_since(0)}"
                raise AssertionError(self.broken)
            time.sleep(POLL)

    def close(self, interrupted=False, problems=()):
        """Ends the launch and what it has started.

        Args:
            interrupted: Whether a test may still run.
            problems: What else went wrong; then nothing is waited for.

        Returns:
            What went wrong, a list of texts.
        """
        problems = list(problems)
        if self._launch is not None:
            with contextlib.suppress(ProcessLookupError):
                os.kill(self._launch.pid, signal.SIGINT)
            self._launch.join(END_GRACE)
        problems += left_behind(self.environment[MARK], interrupted or bool(problems))
        shutil.rmtree(self._temporary, ignore_errors=True)
        return problems

    def log_size(self):
        """Size of the launch's log [B]."""
        return self.launch_log.stat().st_size if self.launch_log.exists() else 0

    def log_since(self, start):
        """Last lines of what the launch has printed since its log had a size [B]."""
        if not self.launch_log.exists():
            return ""
        with self.launch_log.open(errors="replace") as stream:
            stream.seek(start)
            return "".join(stream.readlines()[-LOG_LINES:])

    @property
    def _rosout(self):
        return self.folder / "log" / "latest" / "rosout.log"

    def rosout_size(self):
        """Size of what nodes have logged [B]."""
        return self._rosout.stat().st_size if self._rosout.exists() else 0

    def node_errors(self, start):
        """Last warnings and errors that nodes have logged since their log had a size [B].

        Topics are left out.
        """
        if not self._rosout.exists():
            return ""
        with self._rosout.open(errors="replace") as stream:
            stream.seek(start)
            lines = [line for line in stream if re.match(r"\S+ (WARN|ERROR|FATAL) ", line)]
        return "".join(TOPICS.sub("", line) for line in lines[-LOG_LINES:])


def run_launch(arguments, environment, log):
    """Is roslaunch, in a forked process."""
    become(environment, log)
    import roslaunch

    threading.Thread(target=end_with_parent, daemon=True).start()
    sys.argv = arguments
    roslaunch.main(arguments)


def become(environment, output):
    """Makes a forked process one of its own: session, variables, output, random numbers."""
    os.setsid()
    os.environ.clear()
    os.environ.update(environment)
    with open(output, "ab", buffering=0) as stream:
        os.dup2(stream.fileno(), 1)
        os.dup2(stream.fileno(), 2)
    random.seed()
    sys.path[:] = built_paths()


def built_paths():
    """sys.path without packages' sources, where there are no messages.

    The devel space puts a package's sources first once the package is imported.
    """
    return [path for path in sys.path if not re.search("/src/.+/src$", path)]


def forks():
    """The context of processes that are forked from the server."""
    return multiprocessing.get_context("forkserver")


def new_folder(folder):
    """Makes a folder, without what an earlier run has left there."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    return folder


def left_behind(mark, at_once):
    """Ends what has a mark; what was wrong, a list of texts.

    Args:
        at_once: Whether nothing gets the time to end by itself.
    """
    left = end_marked(MARK, mark, 0.0 if at_once else END_GRACE)
    return [f"left processes behind: {', '.join(left)}"] if left else []


def start_fork_server():
    """Starts the process that test processes are forked from, unless it runs.

    From Python 3.13 it imports what is preloaded by the sys.path of the process that starts it.
    """
    forks().set_forkserver_preload(PRELOADED)
    paths, sys.path[:] = list(sys.path), built_paths()
    try:
        multiprocessing.forkserver.ensure_running()
    finally:
        sys.path[:] = paths


def end_with_parent():
    """Ends roslaunch as Ctrl-C does when the process that wanted it has been killed."""
    multiprocessing.connection.wait([multiprocessing.parent_process().sentinel])
    os.kill(os.getpid(), signal.SIGINT)


def has_parameter(uri, name):
    """Whether a master answers and has a parameter."""
    try:
        return bool(xmlrpc.client.ServerProxy(uri).hasParam("/tests", name)[2])
    except (OSError, xmlrpc.client.Error):
        return False


def marked(name, value):
    """Processes of this user whose environment has a variable: process id -> command line."""
    lines = {pid: " ".join(procfs.arguments(pid)) for pid in procfs.marked(name, value)}
    return {
        pid: line[:200]
        for pid, line in lines.items()  # multiprocessing's own end with their parent
        if line and pid != os.getpid() and "from multiprocessing." not in line
    }


def end_marked(name, value, grace):
    """Ends what has not ended by itself within a grace of wall time [s].

    Returns:
        The command lines of what had to be ended.
    """
    deadline = time.monotonic() + grace
    while (found := marked(name, value)) and time.monotonic() < deadline:
        time.sleep(POLL)
    names = list(found.values())
    while found:
        for pid in found:
            procfs.send(pid, signal.SIGKILL)
        time.sleep(POLL)
        found = marked(name, value)
    return names
