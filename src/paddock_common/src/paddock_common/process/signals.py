"""SIGINT and SIGTERM end a node, whatever it is doing.

rospy's own handlers run the whole shutdown in the main thread, between two of its instructions. If
that thread has a lock which the shutdown needs, both wait for ever: each call of the master takes
one, so a node that is asked to end while it starts may stay until roslaunch kills it 17 s later.
"""

import _thread
import atexit
import os
import signal
import threading

import rospy

from paddock_common.process import starting

NUMBERS = (signal.SIGINT, signal.SIGTERM)
PATIENCE = 10.0  # longest wait at exit for a shutdown that is under way [s]


def init_node(name, **options):
    """Calls rospy.init_node, of a node whose shutdown has a thread of its own.

    A signal that comes before the node is made ends the process at once.

    Args:
        name: Of the node.
        options: rospy.init_node's.
    """
    for number in NUMBERS:
        signal.signal(number, signal.SIG_DFL)
    starting.init_node(name, disable_signals=True, **options)
    watch()


def watch():
    """Has SIGINT and SIGTERM shut the node down; main thread only."""
    reader, writer = os.pipe()
    os.set_blocking(writer, False)
    asked, done = [], threading.Event()

    def note(number, _frame):
        asked.append(number)
        os.write(writer, b".")

    def shut_down():
        os.read(reader, 1)
        rospy.signal_shutdown(f"signal-{int(asked[0])}")
        done.set()

    def finish():
        if asked:
            done.wait(PATIENCE)

    _thread.start_new_thread(shut_down, ())
    atexit.register(finish)
    for number in NUMBERS:
        signal.signal(number, note)
