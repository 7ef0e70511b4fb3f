"""Ends what a killed roslaunch has left: nodes are in sessions of their own and would go on.

    guard.py PID MARK

waits for the end of a process and then ends all processes that have MARK in their environment.
Where roslaunch ends as it should, there are none. It holds no terminal and takes no part in Ctrl-C.
"""

import os
import select
import signal
import sys
import time

VARIABLE = "PADDOCK_SESSION"
GRACE = 1.0  # [s] for what ends by itself
TERMINATED = 2.0  # [s] from SIGTERM to SIGKILL
POLL = 0.05  # [s]


def start(environ):
    """Starts a guard over this process and whatever program it becomes.

    Args:
        environ: Of what is launched; gets the mark.
    """
    import subprocess
    import uuid

    from commands.paths import PYTHON

    environ.pop(VARIABLE, None)
    mark = uuid.uuid4().hex
    subprocess.Popen(
        [PYTHON, "-I", "-S", os.path.abspath(__file__), str(os.getpid()), mark],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        env=environ,
        start_new_session=True,
    )
    environ[VARIABLE] = mark


def main(pid, mark):
    """Waits for a process's end, then ends what has the mark."""
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, signal.SIG_IGN)
    try:
        process = os.pidfd_open(pid)
    except ProcessLookupError:
        pass
    else:
        select.select([process], [], [])
    if not wait_none(mark, GRACE):
        return
    names = sorted({name(other) for other in marked(mark)} - {""})
    print(f"run: roslaunch has left {', '.join(names)}; ended now", file=sys.stderr, flush=True)
    for number, seconds in ((signal.SIGTERM, TERMINATED), (signal.SIGKILL, TERMINATED)):
        for other in marked(mark):
            try:
                os.kill(other, number)
                os.kill(other, signal.SIGCONT)  # a stopped process takes no SIGTERM
            except ProcessLookupError:
                pass
        if not wait_none(mark, seconds):
            return


def wait_none(mark, seconds):
    """Waits until no process has the mark; returns those that still have it."""
    end = time.monotonic() + seconds
    while (left := marked(mark)) and time.monotonic() < end:
        time.sleep(POLL)
    return left


def marked(mark):
    """Pids of this user's processes with a mark in their environment."""
    wanted = f"{VARIABLE}={mark}".encode()
    return [
        int(entry)
        for entry in os.listdir("/proc")
        if entry.isdigit() and wanted in read(entry, "environ").split(b"\0")
    ]


def name(pid):
    """Name of a node, or of its program."""
    words = [os.fsdecode(word) for word in read(pid, "cmdline").split(b"\0")[:-1]]
    for word in words:
        if word.startswith("__name:="):
            return word.partition(":=")[2]
    programs = [os.path.basename(word) for word in words if not word.startswith("-")]
    if "-c" not in words:
        programs = [word for word in programs if not word.startswith("python")] or programs
    return programs[0] if programs else ""


def read(pid, file):
    """A file of /proc/PID; empty where the process has ended or is another user's."""
    try:
        with open(f"/proc/{pid}/{file}", "rb") as stream:
            return stream.read()
    except OSError:
        return b""


if __name__ == "__main__":
    main(int(sys.argv[1]), sys.argv[2])
