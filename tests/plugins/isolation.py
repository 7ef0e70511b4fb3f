"""Runs each file of ROS tests in a process, a ROS graph and folders of its own.

Files with the marker `isolated` have a process of their own, too: a process that forks must have no
threads, and one that many files share has. A file below tests/ros or tests/long may set two names:

    LAUNCH  text of a launch file; it runs, on a ROS master of its own, while the file's tests do.
            Without it there is no master, but ROS_MASTER_URI names a free port.
    NODE    name of the node that the test process is; by default that of the file.

Files that take their LAUNCH from shared_worlds.py (`from shared_worlds import CAR as LAUNCH`)
run in one graph, one after the other; node_fixture.py resets the world before each.

The process is forked from a server that has imported rospy and roslaunch already; it collects the
one file and runs its tests when the pytest that has collected everything says so. With --pdb, or
when one such file alone is selected without -n, its tests run in the process of pytest itself.
"""

import contextlib
import functools
import os
import re
import shutil
import signal
import sys
import tempfile
import time

import pytest
from graphs import (
    END_GRACE,
    MARK,
    Graph,
    become,
    end_marked,
    forks,
    left_behind,
    marked,
    new_folder,
)
from selection import world_of

FOLDERS = ("tests/ros", "tests/long")
RUN = "PADDOCK_TEST_RUN"  # variable by which all that a run has started is known


class Group:
    """The tests of one file and their process.

    Args:
        graph: That they run on; None: one of their own, which ends with them.
        timeout: Longest wall time of one test [s]; a test's own mark may allow more.
    """

    def __init__(self, item, root, timeout, graph=None):
        self.path, self.timeout = item.path, timeout
        self.name = re.sub("^test_", "", item.path.stem)
        self.folder = new_folder(root / "test-results" / item.path.parent.name / self.name)
        self._owns_graph = graph is None
        self.graph = graph or Graph(self.folder, getattr(item.module, "LAUNCH", None))
        self.environment = self.graph.environment
        self._temporary = None
        if not self._owns_graph:  # what the file leaves behind is told from the world's processes
            self._temporary = tempfile.mkdtemp(prefix="paddock_")
            self.environment = {
                **self.environment,
                MARK: os.path.basename(self._temporary),
                "TMPDIR": self._temporary,
            }
        self._child = self._connection = None
        self.rosout_start = self.graph.rosout_size()

    def start_child(self):
        """Starts the process that the tests run in."""
        self._connection, other = forks().Pipe()
        output = str(self.folder / "output.txt")
        arguments = [str(self.path), f"--timeout={self.timeout:g}", "-p", "no:cacheprovider"]
        self._child = forks().Process(
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
        if self.graph.broken:
            raise AssertionError(self.graph.broken)
        try:
            self._connection.send((item.nodeid, nextitem and nextitem.nodeid))
            timeout = max([self.timeout] + [mark.args[0] for mark in item.iter_markers("timeout")])
            if not self._connection.poll(timeout + END_GRACE):
                self._child.kill()
                raise AssertionError(f"the test process has not answered for {timeout:g} s")
            return self._connection.recv()
        except (EOFError, OSError):
            self._child.join(END_GRACE)
            status = self._child.exitcode
            raise AssertionError(f"the test process has ended, exit status {status}") from None

    def close(self, interrupted=False):
        """Ends the process, and the graph if it is the file's own.

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
        if self._owns_graph:
            return self.graph.close(interrupted, problems)
        problems += left_behind(self.environment[MARK], interrupted or bool(problems))
        shutil.rmtree(self._temporary, ignore_errors=True)
        return problems


def run_child(connection, arguments, environment, output):
    """Is the pytest of one file, in a forked process."""
    become(environment, output)
    pytest.main(arguments, plugins=[Child(connection)])


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
        self._group = self._graph = self._world = None  # graph: of the files of a world
        self._folders = {config.rootpath / folder for folder in FOLDERS}
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
        for report in self._reports(item, nextitem, following):
            item.ihook.pytest_runtest_logreport(report=report)
        item.ihook.pytest_runtest_logfinish(nodeid=item.nodeid, location=item.location)
        item.session._setupstate.teardown_exact(nextitem)  # of what ran here before the group
        return True

    def _is_isolated(self, item):
        """Whether a test belongs to a group with a process of its own."""
        if item.get_closest_marker("isolated"):
            return True
        return item.path.parent in self._folders

    def _new_group(self, item):
        root = self._config.rootpath
        world = world_of(item.path)
        if world and self._graph is None:
            folder = new_folder(root / "test-results" / item.path.parent.name / world.lower())
            self._graph, self._world = Graph(folder, item.module.LAUNCH), world
        timeout = float(self._config.getini("timeout"))
        return Group(item, root, timeout, self._graph if world else None)

    def _close_graph(self, interrupted=False):
        """Ends the graph of a world's files; what went wrong, a list of texts."""
        graph, self._graph = self._graph, None
        return graph.close(interrupted) if graph else []

    def _reports(self, item, nextitem, following):
        """Runs a test in its group's process; the reports, the last one after the group's end."""
        begin, start = time.monotonic(), 0
        try:
            if self._group is None:
                self._group = self._new_group(item)
                start = self._group.graph.log_size()
                self._group.start_child()
                self._group.graph.wait_launched()
                started = time.monotonic() - begin
            else:
                start, started = self._group.graph.log_size(), 0.0
            hook = self._config.hook
            reports = [
                hook.pytest_report_from_serializable(config=self._config, data=data)
                for data in self._group.run(item, following)
            ]
            reports[0].duration += started
        except AssertionError as error:
            reports = [failure(item, str(error), time.monotonic() - begin)]
        graph = self._group.graph
        for report in reports:
            if report.failed and (log := graph.log_since(start)):
                report.sections.append((f"launch, see {graph.launch_log}", log))
            if report.failed and (errors := graph.node_errors(self._group.rosout_start)):
                report.sections.append(("warnings and errors of nodes", errors))
        if following is None:
            group, self._group = self._group, None
            problems = group.close()
            if nextitem is None or world_of(nextitem.path) != self._world or problems:
                problems += self._close_graph()
            if problems:
                reports.append(failure(item, "; ".join(problems), 0.0, "teardown"))
        return reports

    def _run_here(self, item, nextitem, following):
        if self._group is None:
            self._group = self._new_group(item)
            os.environ.update(self._group.environment)
            self._group.graph.wait_launched()
        item.config.hook.pytest_runtest_logstart(nodeid=item.nodeid, location=item.location)
        from _pytest.runner import runtestprotocol

        runtestprotocol(item, nextitem=nextitem)
        item.config.hook.pytest_runtest_logfinish(nodeid=item.nodeid, location=item.location)
        if following is None:
            self._close()
        return True

    def _close(self, interrupted=False):
        group, self._group = self._group, None
        problems = group.close(interrupted) if group else []
        for problem in [*problems, *self._close_graph(interrupted)]:
            print(f"{self._world or group.name}: {problem}", file=sys.stderr)

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
