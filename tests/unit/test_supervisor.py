"""What a killed roslaunch leaves is ended, and nothing else."""

import os
import signal
import subprocess
import sys

import pytest
from run_rig import ROOT
from testing import is_running, wait_ended

LIMIT = 30.0  # [s] of wall time; the supervisor's own limits are 5 s in all
# Becomes another program, as ./run does, which starts "nodes" in sessions of their own.
RUN = """
import os, sys
sys.path.insert(0, sys.argv[1])
from commands import supervisor
environ = dict(os.environ)
supervisor.start(environ)
os.execve(sys.executable, [sys.executable, "-c", sys.argv[2]], environ)
"""
LAUNCH = """
import signal, subprocess, sys
quiet = "import signal; signal.signal(signal.SIGTERM, signal.SIG_IGN); print(flush=True); \
signal.pause()"
for words in (["sleep", "1000"], [sys.executable, "-c", quiet], ["sleep", "1001"]):
    node = subprocess.Popen(words, start_new_session=True, stdout=subprocess.PIPE)
    if words[0] != "sleep":
        node.stdout.readline()
    print(node.pid, flush=True)
    last = node
last.send_signal(signal.SIGSTOP)
print("up", flush=True)
signal.pause()
"""


def session(code):
    """Starts RUN; returns its Popen and the pids that it prints."""
    process = subprocess.Popen(
        [sys.executable, "-c", RUN, str(ROOT), code],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    return process, [int(line) for line in iter(process.stdout.readline, "up\n")]


@pytest.fixture(name="bystander")
def _bystander():
    """A process without the mark."""
    process = subprocess.Popen(["sleep", "1000"])
    yield process
    process.kill()
    process.wait()


def test_nodes_of_a_killed_roslaunch_end(bystander):
    process, pids = session(LAUNCH)
    assert len(pids) == 3 and all(map(is_running, pids))
    process.send_signal(signal.SIGKILL)
    for pid in pids:  # one that ends, one that takes no SIGTERM, one that is stopped
        wait_ended(pid, LIMIT)
    assert bystander.poll() is None
    assert "roslaunch has left " in process.communicate(timeout=LIMIT)[1]


def test_after_an_orderly_end_the_supervisor_ends_without_a_word():
    process, pids = session("import os; print(os.getppid() and os.getpid()); print('up')")
    assert process.communicate(timeout=LIMIT)[1] == ""  # its end closes stderr, too
    assert process.returncode == 0


def test_sessions_do_not_end_each_other():
    first, first_pids = session(LAUNCH)
    second, second_pids = session(LAUNCH)
    first.kill()
    for pid in first_pids:
        wait_ended(pid, LIMIT)
    assert all(map(is_running, second_pids))
    second.kill()
    for pid in second_pids:
        wait_ended(pid, LIMIT)
    for process in (first, second):
        process.communicate(timeout=LIMIT)


def test_the_mark_of_an_outer_session_is_not_inherited():
    environ = dict(os.environ, PADDOCK_SESSION="outer")
    code = "import os; print(os.environ['PADDOCK_SESSION'])"
    done = subprocess.run(
        [sys.executable, "-c", RUN, str(ROOT), code], env=environ, capture_output=True, text=True
    )
    assert len(done.stdout.strip()) == 32
