"""How publishers send: through the relay, or in lockstep directly.

Normally the physics never waits for a subscriber: the relay process sends, and what a slow
subscriber cannot take goes to a short queue from which the oldest message is dropped. In lockstep
publish() returns when the socket of every subscriber has taken the message and nothing is dropped,
so that all messages of a step are sent when the step returns.
"""

import contextlib
import threading
import warnings

import rospy

from bullet_bridge.transport.direct import send_directly

QUEUE_SIZE = 10  # messages per subscriber, the oldest is dropped beyond

# rospy warns about a missing queue size. (catch_warnings is not for several threads.)
warnings.filterwarnings("ignore", "The publisher should be created with", SyntaxWarning)

_in_lockstep, _relay = False, None
_made = threading.local()  # .lists: of the publishers made within each all_or_none


def set_lockstep(lockstep):
    """Choose the mode; to be called before the first publisher is made."""
    global _in_lockstep
    _in_lockstep = lockstep


def set_relay(relay):
    """Set the Relay to send through, or None; to be called before the first publisher is made."""
    global _relay
    _relay = relay


def publisher(topic, kind, latch=False, queue_size=QUEUE_SIZE, relayed=True):
    """A rospy.Publisher that sends as the mode asks for.

    Args:
        topic, kind, latch: as rospy's.
        queue_size: messages per subscriber.
        relayed: False for large messages that other threads than the simulation's publish.
    """
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
    """Unregister the publishers made in this context if an exception leaves it."""
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
