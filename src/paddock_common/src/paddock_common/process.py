"""This process: its priority, signals that request a stop, and its exit together with its parent;
a free port for another one, and its stop. Imports no rospy.
"""

from __future__ import annotations

import ctypes
import os
import random
import signal
import socket
import subprocess
import threading
from collections.abc import Callable, Iterable, Sequence
from typing import Any

FIRST, LAST = 20000, 32000  # ports below the kernel's ephemeral ones


def lower_priority(niceness: int = 5) -> None:
    """Lowers this process's priority, so that nodes with little to do leave the CPUs to others.

    Linux groups processes by their session (autogroup) and applies a group's niceness first. A
    node of a launch file has its own session; one that was started in a terminal does not.

    Args:
        niceness: as of nice(1), 1 to 19.
    """
    os.nice(niceness)
    _set_session(niceness)


def raise_priority(niceness: int) -> bool:
    """Raises the priority of this thread and, if it is a node's of a launch file, of its session.

    A thread that always runs is interrupted by each process that wakes up, on the processor where
    it is, although others may be idle. Does nothing on a machine with one processor, where all
    others would have to wait.

    Args:
        niceness: as of nice(1), -20 to -1.

    Returns:
        Whether it has another one; root may do that, others only as far as RLIMIT_NICE allows.
    """
    if len(os.sched_getaffinity(0)) < 2:
        return False
    try:
        os.setpriority(os.PRIO_PROCESS, threading.get_native_id(), niceness)
    except PermissionError:
        return False
    _set_session(niceness)
    return True


def _set_session(niceness: int) -> None:
    """Sets the niceness of this process's session, if it is its first process."""
    if os.getsid(0) != os.getpid():
        return
    try:
        with open("/proc/self/autogroup", "w", encoding="ascii") as stream:
            stream.write(str(niceness))
    except OSError:
        pass  # the kernel has no such groups, or does not allow it


class StopRequest:
    """Whether a signal has requested a stop of this process; construct it in the main thread.

    The handler only stores the signal: it runs between two instructions of the main thread, which
    may hold a lock that any further work needs.

    Args:
        signals: Signals to handle from now on.
        then: Called by the handler, without arguments, at each signal; must not block.

    Attributes:
        signal: The first signal received; None: none was received.
    """

    def __init__(
        self,
        signals: Iterable[signal.Signals] = (signal.SIGINT, signal.SIGTERM),
        then: Callable[[], object] | None = None,
    ) -> None:
        self.signal: int | None = None
        self._then = then
        self._before = {number: signal.signal(number, self._handle) for number in signals}

    def requested(self) -> bool:
        """Returns whether a signal was received."""
        return self.signal is not None

    def close(self) -> None:
        """Restores the previous signal handlers."""
        while self._before:
            signal.signal(*self._before.popitem())

    def __enter__(self) -> StopRequest:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _handle(self, number: int, _frame: object) -> None:
        if self.signal is None:
            self.signal = number
        if self._then is not None:
            self._then()


PR_SET_PDEATHSIG = 1  # prctl(2)


def exit_with_roslaunch(number: int = signal.SIGTERM) -> bool:
    """Makes the kernel send this process a signal when the roslaunch that started it exits.

    Does nothing if the parent is another program: a shell may exit before its children.

    Returns:
        Whether roslaunch is the parent.
    """
    parent = os.getppid()
    if not is_roslaunch(command_line(parent)):
        return False
    if not signal_at_exit_of(parent, number):
        os.kill(os.getpid(), number)
    return True


def signal_at_exit_of(parent: int, number: int = signal.SIGTERM) -> bool:
    """Makes the kernel send this process a signal when its parent exits.

    Returns:
        Whether it is still the parent; if not, it has exited before and no signal will be sent.
    """
    ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, ctypes.c_ulong(number), 0, 0, 0)
    return os.getppid() == parent


def is_roslaunch(arguments: Sequence[str]) -> bool:
    """Returns whether a command line, a list of arguments, is roslaunch's."""
    return any(os.path.basename(argument) == "roslaunch" for argument in arguments[:3])


def command_line(pid: int) -> list[str]:
    """Returns the arguments of a process's command line; empty if there is no such process."""
    try:
        with open(f"/proc/{pid}/cmdline", "rb") as file:
            return os.fsdecode(file.read()).split("\0")[:-1]
    except OSError:
        return []


def free_port() -> int:
    """Returns an unused TCP port outside the range that the kernel assigns."""
    for port in random.sample(range(FIRST, LAST), 100):
        with socket.socket() as probe:
            try:
                probe.bind(("127.0.0.1", port))
            except OSError:
                continue
            return port
    raise OSError(f"no free port found between {FIRST} and {LAST}")


def stop_session(process: subprocess.Popen[Any], limit: float) -> None:
    """Stops a process and its session as Ctrl-C does; kills it if it does not exit.

    Args:
        process: Started with start_new_session=True.
        limit: Wall time from SIGINT to SIGKILL [s].

    Raises:
        AssertionError: It had to be killed.
    """
    if process.poll() is None:
        os.killpg(process.pid, signal.SIGINT)
    try:
        process.wait(limit)
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGKILL)
        process.wait()
        command: Any = process.args
        name = os.path.basename(command[0])
        raise AssertionError(f"{name} did not end within {limit:g} s") from None
