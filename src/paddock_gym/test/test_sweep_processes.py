"""Trials stop when their sweep stops, also those that are about to start."""

import sys
import threading

from paddock_gym.sweep.trial import Processes
from testing import wait_ended

LIMIT = 30.0  # [s]
FAMILY = """
import subprocess, sys
child = subprocess.Popen([sys.executable, "-c", "import time; time.sleep(1000)"])
print(child.pid, flush=True)
child.wait()
"""


def test_run_returns_the_status_and_logs_the_output(tmp_path):
    log = tmp_path / "log.txt"
    command = [sys.executable, "-c", "print('words'); raise SystemExit(3)"]
    assert Processes().run(command, log) == 3
    assert log.read_text() == "words\n"


def test_stop_kills_children_too(tmp_path):
    processes, log, results = Processes(), tmp_path / "log.txt", []
    command = [sys.executable, "-c", FAMILY]
    thread = threading.Thread(target=lambda: results.append(processes.run(command, log)))
    thread.start()
    while not log.exists() or not log.read_text().endswith("\n"):
        thread.join(0.01)
    processes.stop()
    thread.join(LIMIT)
    assert results == [None]
    wait_ended(int(log.read_text()), LIMIT)


def test_nothing_starts_after_stop(tmp_path):
    processes, trace = Processes(), tmp_path / "trace"
    processes.stop()
    assert processes.run(["touch", str(trace)], tmp_path / "log.txt") is None
    assert not trace.exists()
