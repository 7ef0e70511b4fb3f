"""Ends what a killed program has left: nodes are in sessions of their own and would go on.

    supervisor.py PID MARK NAME

waits for the end of a process and then ends all processes that have MARK in their environment.
Where the program ends as it should, there are none. It holds no terminal and takes no part in
Ctrl-C.
"""

import errno
import os
import select
import signal
import sys
import time

if __name__ == "__main__":  # by python3 -I -S
    sys.path.insert(0, os.path.dirname(os.path.dirname(os.path.realpath(__file__))))

from commands import procfs  # noqa: E402

VARIABLE = "PADDOCK_SESSION"
GRACE = 1.0  # [s] for what ends by itself
TERMINATED = 2.0  # [s] from SIGTERM to SIGKILL
POLL = 0.05  # [s]
PIDFD_OPEN = 434  # the system call, which os has from Python 3.9


def start(environ, name="roslaunch"):
    """Starts a supervisor over this process and whatever program it becomes.

    Args:
        environ: Of what is launched; gets the mark.
        name: Of that program, for the message that it has left something.
    """
    import subprocess
    import uuid

    from commands.paths import PYTHON

    environ.pop(VARIABLE, None)
    mark = uuid.uuid4().hex
    subprocess.Popen(
        [PYTHON, "-I", "-S", os.path.abspath(__file__), str(os.getpid()), mark, name],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        env=environ,
        start_new_session=True,
    )
    environ[VARIABLE] = mark


def main(pid, mark, name):
    """Waits for a process's end, then ends what has the mark."""
    import ctypes

    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, signal.SIG_IGN)
    process = ctypes.CDLL(None, use_errno=True).syscall(PIDFD_OPEN, pid, 0)
    if process >= 0:
        select.select([process], [], [])
    elif ctypes.get_errno() != errno.ESRCH:  # it has ended
        raise OSError(ctypes.get_errno(), os.strerror(ctypes.get_errno()))
    left = wait_none(mark, GRACE)
    if not left:
        return
    names = sorted({procfs.program(procfs.arguments(other)) for other in left} - {""})
    print(f"run: {name} has left {', '.join(names)}; ended now", file=sys.stderr, flush=True)
    for number, seconds in ((signal.SIGTERM, TERMINATED), (signal.SIGKILL, TERMINATED)):
        for other in procfs.marked(VARIABLE, mark):
            procfs.send(other, number)
            procfs.send(other, signal.SIGCONT)  # a stopped process takes no SIGTERM
        if not wait_none(mark, seconds):
            return


def wait_none(mark, seconds):
    """Waits until no process has the mark; returns those that still have it."""
    end = time.monotonic() + seconds
    while (left := procfs.marked(VARIABLE, mark)) and time.monotonic() < end:
        time.sleep(POLL)
    return left


if __name__ == "__main__":
    main(int(sys.argv[1]), sys.argv[2], sys.argv[3])
