"""Helpers of tests: processes that exit, do not exit, and leave others behind."""

import os
import signal
import socket
import subprocess
import sys

import pytest
from paddock_common.testing import (
    free_port,
    is_asleep,
    is_running,
    pid_from_killed,
    stop_session,
    wait_ended,
    wait_for,
)

LIMIT = 60.0  # [s]
STUBBORN = """
import signal, subprocess, sys, time
signal.signal(signal.SIGINT, signal.SIG_IGN)
print(subprocess.Popen(["sleep", "600"]).pid, flush=True)
time.sleep(600)"""


def start(code):
    return subprocess.Popen(
        [sys.executable, "-c", code], stdout=subprocess.PIPE, text=True, start_new_session=True
    )


def test_a_free_port_can_be_used():
    with socket.socket() as server:
        server.bind(("127.0.0.1", free_port()))


def test_a_zombie_does_not_run():
    process = subprocess.Popen([sys.executable, "-c", "input()"], stdin=subprocess.PIPE)
    assert is_running(process.pid) and is_running(os.getpid())
    with pytest.raises(AssertionError, match=f"process {process.pid} has not ended within 0.01 s"):
        wait_ended(process.pid, 0.01)
    process.stdin.close()
    wait_ended(process.pid, LIMIT)  # it has not been waited for yet
    process.wait()
    assert not is_running(process.pid)


def test_a_process_is_asleep_while_none_of_its_threads_has_something_to_do():
    code = """
import threading, time
print(1, flush=True)
input()
threading.Thread(target=lambda: [None for _ in iter(int, 1)], daemon=True).start()
time.sleep(600)"""
    process = subprocess.Popen(
        [sys.executable, "-c", code], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )
    process.stdout.readline()
    wait_for(lambda: is_asleep(process.pid), "its sleep")
    process.stdin.write("\n")
    process.stdin.flush()
    wait_for(lambda: not is_asleep(process.pid), "its work")
    process.send_signal(signal.SIGSTOP)
    wait_for(lambda: is_asleep(process.pid), "its sleep")
    process.kill()
    wait_ended(process.pid, LIMIT)
    # it has not been waited for yet; its threads end one after the other
    wait_for(lambda: is_asleep(process.pid), "the end of all its threads")
    process.wait()
    process.stdin.close()
    process.stdout.close()
    assert is_asleep(process.pid)


def test_what_a_killed_process_leaves_behind():
    code = (
        "import subprocess, time\n"
        "print(subprocess.Popen(['sleep', '600']).pid, flush=True)\ntime.sleep(600)"
    )
    pid = pid_from_killed(code)
    assert is_running(pid)
    os.kill(pid, signal.SIGKILL)
    wait_ended(pid, LIMIT)


def test_a_session_stops_by_interrupt():
    process = start("import time; print(1, flush=True)\ntime.sleep(600)")
    process.stdout.readline()
    stop_session(process, LIMIT)
    assert process.returncode == -signal.SIGINT
    stop_session(process, LIMIT)  # it has exited already
    process.stdout.close()


def test_a_session_that_ignores_interrupts_is_killed_with_its_children():
    process = start(STUBBORN)
    child = int(process.stdout.readline())
    with pytest.raises(AssertionError, match="did not end within 0.2 s"):
        stop_session(process, 0.2)
    assert process.returncode == -signal.SIGKILL
    wait_ended(child, LIMIT)
    process.stdout.close()
