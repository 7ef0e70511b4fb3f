"""Being asked to end, without work in signal handlers.

rospy's own handler runs all of a shutdown inside the handler: when the signal comes while the main
thread holds a lock (logging has some), whatever needs that lock waits for ever. Here the handler
leaves a note, and the main thread ends when it sees it.
"""

import signal

import rospy

_asked = []


def watch():
    """Notes SIGINT and SIGTERM from now on; for nodes made with disable_signals=True."""
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda number, _frame: _asked.append(number))


def over():
    """Whether the node has been asked to end."""
    return bool(_asked) or rospy.is_shutdown()
