"""Runs each file of ROS tests in a process, a ROS graph and folders of its own.

Files with the marker `isolated` have a process of their own, too: a process that forks must have no
threads, and one that many files share has. A file below tests/ros or tests/long may set two names:

    LAUNCH  text of a launch file; it runs, on a ROS master of its own, while the file's tests do.
            Without it there is no master, but ROS_MASTER_URI names a free port.
    NODE    name of the node that the test process is; by default that of the file.

The process is forked from a server that has imported rospy and roslaunch already; it collects the
one file and runs its tests when the pytest that has collected everything says so. With --pdb, or
when one such file alone is selected without -n, its tests run in the process of pytest itself.
"""

import contextlib
import functools
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

import pytest

from commands import procfs

FOLDERS = ("tests/ros", "tests/long")
MARK = "PADDOCK_TEST"  # variable by which all that a group of tests has started is known
RUN = "PADDOCK_TEST_RUN"  # the same for all that a run has started
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


class Group:
    """The tests of one file: their folders, launch, processes.

    Args:
        timeout: Longest wall time of one test [s].
    """

    def __init__(self, item, root, timeout):
        from paddock_common.testing import free_port

        self.path = item.path
        self.name = item.path.stem.removeprefix("test_")
        self.timeout = timeout
        self.folder = root / "test-results" / item.path.parent.name / self.name
        shutil.rmtree(self.folder, ignore_errors=True)
        self.folder.mkdir(parents=True)
        self._temporary = tempfile.TemporaryDirectory(prefix="paddock_", ignore_cleanup_errors=True)
        self.port = free_port()
        self.environment = dict(os.environ)
        for name in ("PYTEST_XDIST_WORKER", "PYTEST_CURRENT_TEST"):
            self.environment.pop(name, None)
        self.environment |= {
            MARK: os.path.basename(self._temporary.name),
            "ROS_HOME": str(self.folder / "ros_home"),
            "ROS_LOG_DIR": str(self.folder / "log"),
            "ROS_MASTER_URI": f"http://127.0.0.1:{self.port}",
            "TMPDIR": self._temporary.name,
        }
        self.launch_log = self.folder / "launch.log"
        self._context = multiprocessing.get_context("forkserver")
        start_fork_server()
        self._launch = self._child = self._connection = self._broken = None
        text = getattr(item.module, "LAUNCH", None)
        if text is not None:
            self._launch = self._start_launch(text)

    def _start_launch(self, text):
        file = self.folder / "world.launch"
        body, end, _ = text.rpartition("</launch>")
        file.write_text(f'{body}  <param name="{LAUNCHED}" value="true"/>\n{end}\n')
        arguments = ["roslaunch", "--screen", "-p", str(self.port), str(file)]
        process = self._context.Process(
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
                self._broken = f"the launch does not come up:\n{self.log_since(0)}"
                raise AssertionError(self._broken)
            time.sleep(POLL)

    def start_child(self):
        """Starts the process that the tests run in."""
        self._connection, other = self._context.Pipe()
        output = str(self.folder / "output.txt")
        arguments = [str(self.path), f"--timeout={self.timeout:g}", "-p", "no:cacheprovider"]
        self._child = self._context.Process(
            target=run_child, args=(other, arguments, self.environment, output)
        )
        self._child.start()
        other.close()

    def run(self, item, nextitem):
        """Runs a test in that process.

        Args:
            nextitem: The one after it in this group, or None.

        Returns:
            List of reports as pytest_report_to_serializable gives them.

        Raises:
            AssertionError: The process has ended, or does not answer, or has no launch.
        """
        if self._broken:
            raise AssertionError(self._broken)
        try:
            self._connection.send((item.nodeid, nextitem and nextitem.nodeid))
            if not self._connection.poll(self.timeout + END_GRACE):
                self._child.kill()
                raise AssertionError(f"the test process has not answered for {self.timeout:g} s")
            return self._connection.recv()
        except (EOFError, OSError):
            self._child.join(END_GRACE)
            status = self._child.exitcode
            raise AssertionError(f"the test process has ended, exit status {status}") from None

    def close(self, interrupted=False):
        """Ends the processes.

        Args:
            interrupted: Whether a test may still run.

        Returns:
            What went wrong, a list of texts.
        """
        problems = []
        if self._child is not None:
            with contextlib.suppress(OSError):
                if interrupted:
                    os.kill(self._child.pid, signal.SIGINT)
                self._connection.send(None)
            self._child.join(END_GRACE)
            if self._child.is_alive():
                problems.append("the test process does not end")
        if self._launch is not None:
            with contextlib.suppress(ProcessLookupError):
                os.kill(self._launch.pid, signal.SIGINT)
            self._launch.join(END_GRACE)
        grace = 0.0 if problems or interrupted else END_GRACE
        left = end_marked(MARK, self.environment[MARK], grace)
        if left:
            problems.append(f"left processes behind: {', '.join(left)}")
        self._temporary.cleanup()
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

    def node_errors(self):
        """Last warnings and errors that nodes of this file have logged, without their topics."""
        log = self.folder / "log" / "latest" / "rosout.log"
        if not log.exists():
            return ""
        with log.open(errors="replace") as stream:
            lines = [line for line in stream if re.match(r"\S+ (WARN|ERROR|FATAL) ", line)]
        return "".join(TOPICS.sub("", line) for line in lines[-LOG_LINES:])


def run_launch(arguments, environment, log):
    """Is roslaunch, in a forked process."""
    become(environment, log)
    import roslaunch

    threading.Thread(target=end_with_parent, daemon=True).start()
    sys.argv = arguments
    roslaunch.main(arguments)


def run_child(connection, arguments, environment, output):
    """Is the pytest of one file, in a forked process."""
    become(environment, output)
    pytest.main(arguments, plugins=[Child(connection)])


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


def start_fork_server():
    """Starts the process that test processes are forked from, unless it runs.

    From Python 3.13 it imports what is preloaded by the sys.path of the process that starts it.
    """
    multiprocessing.get_context("forkserver").set_forkserver_preload(PRELOADED)
    paths, sys.path[:] = list(sys.path), built_paths()
    try:
        multiprocessing.forkserver.ensure_running()
    finally:
        sys.path[:] = paths


def end_with_parent():
    """Ends roslaunch as Ctrl-C does when the process that wanted it has been killed."""
    multiprocessing.connection.wait([multiprocessing.parent_process().sentinel])
    os.kill(os.getpid(), signal.SIGINT)


class Child:
    """Plugin of that pytest: runs the tests that it is told and sends their reports back."""

    def __init__(self, connection):
        self._connection = connection
        self._reports = []

    def pytest_runtestloop(self, session):
        """Runs tests until it is told None."""
        items = {item.nodeid: item for item in session.items}
        hook = session.config.hook
        while (message := self._connection.recv()) is not None:
            item, following = items[message[0]], items.get(message[1])
            hook.pytest_runtest_protocol(item=item, nextitem=following)
            reports, self._reports = self._reports, []
            give = functools.partial(hook.pytest_report_to_serializable, config=session.config)
            self._connection.send([give(report=report) for report in reports])
        return True

    def pytest_collectreport(self, report):
        """Prints why a file cannot be collected."""
        if report.failed:
            print(report.longrepr)

    def pytest_runtest_logreport(self, report):
        """Keeps a report."""
        self._reports.append(report)


class Isolation:
    """Plugin of the pytest that has collected everything (or a worker of pytest-xdist)."""

    def __init__(self, config):
        self._config = config
        self._group = None
        self._here = False  # whether tests run in this process

    @pytest.hookimpl(trylast=True)
    def pytest_collection_finish(self, session):
        """Decides where tests run; pytest-timeout watches them where they run."""
        items = [item for item in session.items if self._is_isolated(item)]
        for item in items:
            item.add_marker(pytest.mark.timeout(0), append=False)  # before its own
        alone = (
            len({item.path for item in session.items}) == 1
            and "PYTEST_XDIST_WORKER" not in os.environ
        )
        self._here = self._config.option.usepdb or alone

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtest_protocol(self, item, nextitem):
        """Has a test run by its group's process."""
        if not self._is_isolated(item):
            return None
        following = nextitem if nextitem is not None and nextitem.path == item.path else None
        if self._here:
            return self._run_here(item, nextitem, following)
        item.ihook.pytest_runtest_logstart(nodeid=item.nodeid, location=item.location)
        for report in self._reports(item, following):
            item.ihook.pytest_runtest_logreport(report=report)
        item.ihook.pytest_runtest_logfinish(nodeid=item.nodeid, location=item.location)
        item.session._setupstate.teardown_exact(nextitem)  # of what ran here before the group
        return True

    def _is_isolated(self, item):
        """Whether a test belongs to a group with a process of its own."""
        if item.get_closest_marker("isolated"):
            return True
        root = self._config.rootpath
        return item.path.is_relative_to(root) and str(item.path.parent.relative_to(root)) in FOLDERS

    def _new_group(self, item):
        return Group(item, self._config.rootpath, float(self._config.getini("timeout")))

    def _reports(self, item, following):
        """Runs a test in its group's process; the reports, the last one after the group's end."""
        begin, start = time.monotonic(), 0
        try:
            if self._group is None:
                self._group = self._new_group(item)
                self._group.start_child()
                self._group.wait_launched()
                started = time.monotonic() - begin
            else:
                start, started = self._group.log_size(), 0.0
            hook = self._config.hook
            reports = [
                hook.pytest_report_from_serializable(config=self._config, data=data)
                for data in self._group.run(item, following)
            ]
            reports[0].duration += started
        except AssertionError as error:
            reports = [failure(item, str(error), time.monotonic() - begin)]
        for report in reports:
            if report.failed and (log := self._group.log_since(start)):
                report.sections.append((f"launch, see {self._group.launch_log}", log))
            if report.failed and (errors := self._group.node_errors()):
                report.sections.append(("warnings and errors of nodes", errors))
        if following is None:
            group, self._group = self._group, None
            if problems := group.close():
                reports.append(failure(item, "; ".join(problems), 0.0, "teardown"))
        return reports

    def _run_here(self, item, nextitem, following):
        if self._group is None:
            self._group = self._new_group(item)
            os.environ.update(self._group.environment)
            self._group.wait_launched()
        item.config.hook.pytest_runtest_logstart(nodeid=item.nodeid, location=item.location)
        from _pytest.runner import runtestprotocol

        runtestprotocol(item, nextitem=nextitem)
        item.config.hook.pytest_runtest_logfinish(nodeid=item.nodeid, location=item.location)
        if following is None:
            self._close()
        return True

    def _close(self, interrupted=False):
        group, self._group = self._group, None
        if group is not None:
            for problem in group.close(interrupted):
                print(f"{group.name}: {problem}", file=sys.stderr)

    def pytest_unconfigure(self):
        """Ends what an interrupted run has started."""
        self._close(interrupted=True)
        if "PYTEST_XDIST_WORKER" not in os.environ:
            run = os.environ.pop(RUN, None)
            for pid in marked(RUN, run):
                with contextlib.suppress(ProcessLookupError):
                    os.kill(pid, signal.SIGINT)
            end_marked(RUN, run, END_GRACE)


def pytest_configure(config):
    """Registers the plugin, but not in a group's own process."""
    config.addinivalue_line("markers", "isolated: the file's tests run in a process of their own")
    if MARK in os.environ:
        return
    if "PYTEST_XDIST_WORKER" not in os.environ:
        os.environ[RUN] = str(os.getpid())
        if signal.getsignal(signal.SIGTERM) is signal.SIG_DFL:
            signal.signal(signal.SIGTERM, signal.default_int_handler)
    config.pluginmanager.register(Isolation(config), "isolation-groups")


def failure(item, text, duration, when="call"):
    """A report of a failure that no test has reported itself."""
    return pytest.TestReport(
        item.nodeid, item.location, {}, "failed", text, when, duration=duration
    )


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
