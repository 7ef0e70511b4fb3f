"""Publishers for two kinds of running.

Normally the physics never waits for a subscriber: what one cannot take at once waits in a short
queue, from which the oldest message is dropped. In lockstep publish() returns when the socket of
every subscriber has the message and nothing is dropped: when a step has returned, all is out.
"""

import contextlib
import threading
import warnings

import rospy

from bullet_bridge.direct import send_directly

QUEUE = 10      # messages per subscriber that may wait, oldest dropped

_in_lockstep = False
_made = threading.local()       # .lists: of the publishers made within each all_or_none


def set_lockstep(lockstep):
    """Choose, before the first publisher is made."""
    global _in_lockstep
    _in_lockstep = lockstep


def publisher(topic, kind, latch=False, queue_size=QUEUE):
    """A rospy.Publisher that fits the way of running."""
    with warnings.catch_warnings():     # rospy takes the missing queue for an oversight
        warnings.simplefilter('ignore')
        made = rospy.Publisher(topic, kind, latch=latch, queue_size=None)
    for made_here in getattr(_made, 'lists', ()):
        made_here.append(made)
    send_directly(made, None if _in_lockstep else queue_size)
    return made


@contextlib.contextmanager
def all_or_none():
    """An exception that leaves this context withdraws the publishers made in it."""
    made_here, before = [], getattr(_made, 'lists', ())
    _made.lists = (*before, made_here)
    try:
        yield
    except BaseException:
        for made in made_here:
            made.unregister()
        raise
    finally:
        _made.lists = before
