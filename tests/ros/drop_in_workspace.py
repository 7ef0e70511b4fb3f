"""A user's workspace: a package that is built against ours and launched from there."""

import os
import re
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import rosgraph
import rospy
from paddock_common.process import stop_session
from sim_client import wait_until

ROOT = Path(__file__).resolve().parents[2]
PACKAGE = ROOT / "tests" / "drop_in" / "campus_rover"
BUILD_LIMIT = 400.0  # wall time of configuring and building one package [s]
STOP_LIMIT = 90.0  # wall time from SIGINT to the end of a launch [s]


class Workspace:
    """A catkin workspace in a temporary directory that holds one package.

    Args:
        files: Path below the package -> text; None: those of tests/drop_in/PACKAGE.
    """

    environment = os.environ

    def __init__(self, package=PACKAGE.name, files=None):
        self.package = package
        self._directory = tempfile.TemporaryDirectory(prefix="drop_in_")
        self.path = Path(self._directory.name)
        self.setup = self.path / "devel" / "setup.bash"
        self.source = self.path / "src" / package
        if files is None:
            shutil.copytree(PACKAGE.parent / package, self.source)
        for name, text in (files or {}).items():
            (self.source / name).parent.mkdir(parents=True, exist_ok=True)
            (self.source / name).write_text(text)

    def build(self, *targets):
        """Builds it on top of the active workspace, and targets such as install.

        Returns:
            (exit status, output).
        """
        options = [f"-DPYTHON_EXECUTABLE={sys.executable}", *targets]
        done = subprocess.run(
            ["catkin_make", "-C", str(self.path), *options],
            text=True,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            check=False,
            timeout=BUILD_LIMIT,
        )
        return done.returncode, done.stdout

    def close(self):
        """Deletes it."""
        self._directory.cleanup()


class Launched:
    """One of a package's launch files, on a master of its own; use it with `with`.

    Args:
        workspace: Where it is launched from: has a setup file, a package and an environment.
    """

    def __init__(self, workspace, file, port, **arguments):
        words = " ".join(f"{name}:={value}" for name, value in arguments.items())
        self._command = [
            "bash",
            "-c",
            f"source {workspace.setup} && "
            f"exec roslaunch -p {port} {workspace.package} {file} {words}",
        ]
        self._environment = dict(workspace.environment, ROS_MASTER_URI=f"http://127.0.0.1:{port}")
        self._environment.pop("DISPLAY", None)
        self._log = tempfile.TemporaryFile(mode="w+")
        self._process = None

    def __enter__(self):
        self._process = subprocess.Popen(
            self._command,
            env=self._environment,
            stdin=subprocess.DEVNULL,
            stdout=self._log,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        )
        return self

    def __exit__(self, *exception):
        if exception[0] is not None:
            print(self.output())
        try:
            stop_session(self._process, STOP_LIMIT)
        finally:
            self._log.close()

    def output(self):
        """What was printed so far, without the terminal's colours."""
        self._log.flush()
        with open(f"/proc/self/fd/{self._log.fileno()}", encoding="utf-8") as stream:
            return re.sub(r"\x1b(\[[0-9;]*m|\][^\x07]*\x07)", "", stream.read())

    @property
    def pid(self):
        """Process id of roslaunch."""
        return self._process.pid

    def running(self):
        """Whether roslaunch still runs."""
        return self._process.poll() is None


def master_port():
    """Port of this file's own ROS master, which the launch file starts."""
    return int(os.environ["ROS_MASTER_URI"].rpartition(":")[2])


def master_answers():
    """Whether that master is there."""
    try:
        return rosgraph.Master("/test").getPid() > 0
    except OSError:
        return False


class MasterCase(unittest.TestCase):
    """Launch files of one workspace, one after the other on one master; the test is a node.

    Attributes:
        NODE: Its name.
    """

    @classmethod
    def setUpClass(cls):
        cls.workspace = cls.make_workspace()
        cls.addClassCleanup(cls.workspace.close)
        status, output = cls.workspace.build()
        if status != 0:
            raise AssertionError(f"the package does not build:\n{output}")
        master = subprocess.Popen(
            ["rosmaster", "--core", "-p", str(master_port())],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        cls.addClassCleanup(master.wait)
        cls.addClassCleanup(master.terminate)
        wait_until(master_answers, "the ROS master")
        rosgraph.Master("/test").setParam("/use_sim_time", True)
        rospy.init_node(cls.NODE)
        cls.addClassCleanup(rospy.signal_shutdown, "the test is over")

    def launch(self, file):
        """Launches a file of the package for this test; returns Launched."""
        launched = Launched(self.workspace, file, master_port())
        launched.__enter__()
        self.addCleanup(self.stop, launched)
        return launched

    def stop(self, launched):
        """Ends a launch and waits until the simulator has left the graph."""
        print(launched.output())
        launched.__exit__(None, None, None)
        graph = rosgraph.Master("/test")
        wait_until(lambda: "/gazebo'" not in str(graph.getSystemState()), "the simulator's end")
