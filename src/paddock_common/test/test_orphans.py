"""A node exits with roslaunch, and only with roslaunch."""

import os
import subprocess
import sys

import pytest
from paddock_common.process import is_roslaunch
from testing import is_running, wait_ended

NODE = """
import signal
from paddock_common.process import exit_with_roslaunch
exit_with_roslaunch()
print('ready', flush=True)
signal.pause()
"""
PARENT = "import subprocess, sys, signal; \
child = subprocess.Popen([sys.executable, '-c', sys.argv[1]], stdout=subprocess.PIPE); \
child.stdout.readline(); print(child.pid, flush=True); signal.pause()"


@pytest.fixture(name="orphan")
def _orphan(tmp_path):
    """Function: name of a parent's script -> pid of its child once the parent was killed."""
    pids = []

    def make(name):
        script = tmp_path / name
        script.write_text(PARENT)
        parent = subprocess.Popen(
            [sys.executable, str(script), NODE],
            stdout=subprocess.PIPE,
            text=True,
            env=dict(os.environ, PYTHONPATH=os.pathsep.join(sys.path)),
        )
        with parent:
            pids.append(int(parent.stdout.readline()))
            parent.kill()
        return pids[-1]

    yield make
    for pid in pids:
        if is_running(pid):
            os.kill(pid, 9)


def test_a_node_exits_with_a_killed_roslaunch(orphan):
    wait_ended(orphan("roslaunch"), 30.0)


def test_a_node_survives_a_shell(orphan):
    pid = orphan("terminal")
    with pytest.raises(AssertionError):
        wait_ended(pid, 0.5)


@pytest.mark.parametrize(
    "arguments, expected",
    [
        (["/usr/bin/python3", "/usr/bin/roslaunch", "a", "b.launch"], True),
        (["roslaunch", "x"], True),
        (["bash", "-c", "sleep 1; true", "roslaunch"], False),
        ([], False),
    ],
)
def test_what_counts_as_roslaunch(arguments, expected):
    assert is_roslaunch(arguments) is expected
