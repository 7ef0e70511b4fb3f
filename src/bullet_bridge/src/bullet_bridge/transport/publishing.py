"""Publishers for two kinds of running.

Normally the physics never waits for a subscriber: what one cannot take at once waits in a short
queue, from which the oldest message is dropped; a process of its own, the relay, does the sending.
In lockstep publish() returns when the socket of every subscriber has the message and nothing is
dropped: when a step has returned, all is out.
"""

import contextlib
import threading
import warnings

import rospy

from bullet_bridge.transport.direct import send_directly

QUEUE = 10  # messages per subscriber that may wait, oldest dropped

_in_lockstep, _relay = False, None
_made = threading.local()  # .lists: of the publishers made within each all_or_none


def set_lockstep(lockstep):
    """Choose, before the first publisher is made."""
    global _in_lockstep
    _in_lockstep = lockstep


def set_relay(relay):
    """Let a Relay do the sending; None: none. Before the first publisher is made."""
    global _relay
    _relay = relay


def publisher(topic, kind, latch=False, queue_size=QUEUE, relayed=True):
    """A rospy.Publisher that fits the way of running.

    Args:
        topic, kind, latch: as rospy's.
        queue_size: messages per subscriber that may wait.
        relayed: False for big messages that the simulation thread does not send.
    """
    with warnings.catch_warnings():  # rospy takes the missing queue for an oversight
        warnings.simplefilter("ignore")
        made = rospy.Publisher(topic, kind, latch=latch, queue_size=None)
    for made_here in getattr(_made, "lists", ()):
        made_here.append(made)
    if _in_lockstep:
        send_directly(made, None)
    else:
        send_directly(made, queue_size, _relay if relayed else None)
    return made


@contextlib.contextmanager
def all_or_none():
    """An exception that leaves this context withdraws the publishers made in it."""
    made_here, before = [], getattr(_made, "lists", ())
    _made.lists = (*before, made_here)
    try:
        yield
    except BaseException:
        for made in made_here:
            made.unregister()
        raise
    finally:
        _made.lists = before
