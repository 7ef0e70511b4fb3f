"""Processes that are started for somebody: free ports, and stops that leave nothing."""

import signal
import socket
import subprocess
import sys

import pytest
from paddock_common.process import free_port, stop_session
from testing import wait_ended

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
