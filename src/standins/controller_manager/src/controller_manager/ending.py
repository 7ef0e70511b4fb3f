"""Shutdown on signals, without work in signal handlers.

rospy's own handler runs the whole shutdown inside the handler: if the main thread holds a lock at
that time (logging has some), the handler deadlocks on it. Here the handler sets a flag, and the
main thread ends when it sees it.
"""

import signal

import rospy

_asked = []


def watch():
    """Installs handlers of SIGINT and SIGTERM, for nodes made with disable_signals=True."""
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda number, _frame: _asked.append(number))


def over():
    """Whether a shutdown was requested."""
    return bool(_asked) or rospy.is_shutdown()
