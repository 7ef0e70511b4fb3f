"""Processes that a session has started, found by a variable in their environment."""

import os
import pathlib
import signal
import time

from processes import PROC, arguments_of
from usage import role_of

MARK = "PADDOCK_SOAK"  # variable by which all that a session has started is known
PERIOD = 0.02  # [s] between two looks


def marked(mark, proc=PROC):
    """Pids of this user's processes with a mark; those that have ended are left out."""
    wanted, found = f"{MARK}={mark}".encode(), []
    for folder in pathlib.Path(proc).glob("[0-9]*"):
        try:
            if wanted in (folder / "environ").read_bytes().split(b"\0"):
                if arguments_of(folder.name, proc):
                    found.append(int(folder.name))
        except OSError:  # it has ended, or is another user's
            continue
    return sorted(found)


def wait_none(mark, limit, spared=(), begin=None):
    """Waits until no marked process is left.

    Args:
        mark: Of the session.
        limit: Longest wait in wall time [s].
        spared: Roles that are not waited for, see usage.role_of.
        begin: time.monotonic() from which on the time counts [s]; None: now.

    Returns:
        (Seconds since the begin, command lines of what is left).
    """
    begin = time.monotonic() if begin is None else begin
    while True:
        words = [arguments_of(pid) for pid in marked(mark)]
        left = [" ".join(line)[:160] for line in words if line and role_of(line) not in spared]
        seconds = time.monotonic() - begin
        if not left or seconds >= limit:
            return seconds, left
        time.sleep(PERIOD)


def kill_all(mark):
    """Ends by SIGKILL what is left of a session."""
    while left := marked(mark):
        for pid in left:
            send(pid, signal.SIGKILL)
        time.sleep(PERIOD)


def send(pid, number):
    """Sends a signal; returns whether there was such a process."""
    try:
        os.kill(pid, number)
    except ProcessLookupError:
        return False
    return True


def environment_of(pid):
    """Variables that a process was started with."""
    try:
        entries = pathlib.Path(f"/proc/{pid}/environ").read_bytes().split(b"\0")
    except OSError:
        return {}
    pairs = (os.fsdecode(entry).partition("=") for entry in entries if entry)
    return {name: value for name, _, value in pairs}
