"""This process: its priority, signals that ask it to stop, and its end with the one that started
it; imports no rospy.
"""

import ctypes
import os
import signal


def give_way(niceness=5):
    """Lowers this process's priority, so that nodes that do little leave the processors to others.

    Linux groups processes by their session (autogroup) and looks at a group's niceness first. A
    node of a launch file has a session of its own; one that was started in a terminal has not.

    Args:
        niceness: as of nice(1), 1 to 19.
    """
    os.nice(niceness)
    if os.getsid(0) != os.getpid():
        return
    try:
        with open("/proc/self/autogroup", "w", encoding="ascii") as stream:
            stream.write(str(niceness))
    except OSError:
        pass  # there are no such groups


class StopRequest:
    """Whether a signal has asked this process to stop; to be made in the main thread.

    The handler stores the number and does no work of its own: it runs between two instructions of
    the main thread, which may have a lock that the work needs.

    Args:
        signals: Numbers of the signals; they are handled from here on.
        then: Called by the handler, without arguments, at each of them; must not block.

    Attributes:
        signal: Number of the first one that came; None: none has come.
    """

    def __init__(self, signals=(signal.SIGINT, signal.SIGTERM), then=None):
        self.signal, self._then = None, then
        self._before = {number: signal.signal(number, self._handle) for number in signals}

    def requested(self):
        """Whether one has come."""
        return self.signal is not None

    def close(self):
        """Handles the signals as before."""
        while self._before:
            signal.signal(*self._before.popitem())

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def _handle(self, number, _frame):
        if self.signal is None:
            self.signal = number
        if self._then is not None:
            self._then()


PR_SET_PDEATHSIG = 1  # prctl(2)


def end_with_roslaunch(number=signal.SIGTERM):
    """Has the kernel send this process a signal when the roslaunch that started it ends.

    Does nothing for a process that something else has started: a shell may well end before it.

    Args:
        number: The signal.

    Returns:
        Whether roslaunch is the parent.
    """
    parent = os.getppid()
    if not is_roslaunch(command_line(parent)):
        return False
    if not signal_at_end_of(parent, number):
        os.kill(os.getpid(), number)
    return True


def signal_at_end_of(parent, number=signal.SIGTERM):
    """Has the kernel send this process a signal when its parent ends.

    Args:
        parent: Process id of the parent.
        number: The signal.

    Returns:
        Whether it is still the parent; if not, it has ended before and no signal will come.
    """
    ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, ctypes.c_ulong(number), 0, 0, 0)
    return os.getppid() == parent


def is_roslaunch(words):
    """Whether a command line, a list of words, is roslaunch's."""
    return any(os.path.basename(word) == "roslaunch" for word in words[:3])


def command_line(pid):
    """Words of a process's command line; empty where there is no such process."""
    try:
        with open(f"/proc/{pid}/cmdline", "rb") as file:
            return os.fsdecode(file.read()).split("\0")[:-1]
    except OSError:
        return []
