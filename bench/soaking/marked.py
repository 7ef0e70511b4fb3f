"""Processes that a session has started, found by a variable in their environment."""

import operator
import os
import pathlib
import signal
import time
from dataclasses import dataclass

from processes import PROC, arguments_of
from usage import role_of

from soaking.crowd import Crowd

MARK = "PADDOCK_SOAK"  # variable by which all that a session has started is known
PERIOD = 0.03  # [s] between two looks


@dataclass
class Ending:
    """How marked processes ended.

    Attributes:
        seconds: Since the begin until none was left, or until it was not waited for any more.
        left: Command lines of what is left.
        lives: (role, seconds since the begin when it was last seen), the longest life last.
        slowdown: By what others have slowed it down, see Crowd.
    """

    seconds: float
    left: list
    lives: list
    slowdown: float


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
        limit: Longest wait in wall time [s]; longer where others want the processors, see Crowd.
        spared: Roles that are not waited for, see usage.role_of.
        begin: time.monotonic() from which on the time counts [s]; None: now.

    Returns:
        Ending.
    """
    begin = time.monotonic() if begin is None else begin
    crowd, lives = Crowd(), {}
    while True:
        pids = marked(mark)
        words = {pid: line for pid in pids if (line := arguments_of(pid))}
        left = {pid: line for pid, line in words.items() if role_of(line) not in spared}
        seconds = time.monotonic() - begin
        crowd.look(words)
        for pid, line in left.items():
            lives[pid] = (role_of(line), seconds)
        if not left or seconds >= limit * crowd.slowdown():
            lines = [" ".join(line)[:160] for line in left.values()]
            last = sorted(lives.values(), key=operator.itemgetter(1))
            return Ending(seconds, lines, last, crowd.slowdown())
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
