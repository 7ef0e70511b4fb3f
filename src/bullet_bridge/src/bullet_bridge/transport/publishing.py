"""Publishers whose messages leave in the simulation's thread, in order.

How publishers send: through the relay, or in lockstep directly. Normally the physics never waits
for a subscriber: the relay process sends, and what a slow subscriber cannot take goes to a short
queue from which the oldest message is dropped. In lockstep publish() returns when the socket of
every subscriber has taken the message and nothing is dropped, so that all messages of a step are
sent when the step returns.
"""

from __future__ import annotations

import contextlib
import threading
import warnings
from collections.abc import Callable, Iterator
from typing import Any

import rospy
from bullet_sim.errors import ModelError
from rospy.impl.registration import get_topic_manager

from bullet_bridge.transport.connections import DirectConnection
from bullet_bridge.transport.relay import Relay


def send_directly(
    publisher: rospy.Publisher, limit: int | None, relay: Relay | None = None
) -> None:
    """Wrap each TCP connection of a new rospy.Publisher in a connection wrapper.

    Args:
        publisher: rospy.Publisher without a queue that has no connections yet.
        limit: see DirectConnection.
        relay: Relay that sends instead while it is alive; None: always DirectConnection.
    """
    impl = publisher.impl
    if getattr(impl, "sends_directly", False):  # shared with another Publisher of this topic
        return
    original = impl.add_connection

    def add_connection(connection: Any) -> Any:
        if getattr(connection, "socket", None) is not None:
            try:
                relayed = None
                if relay is not None and limit is not None:
                    relayed = relay.add_subscriber(connection, limit)
                connection = relayed or DirectConnection(connection, limit)
            except OSError as error:  # closed already
                rospy.logdebug("a subscriber of %s has disconnected: %s", impl.resolved_name, error)
                return False
        try:
            added = original(connection)
        except Exception:  # the topic was unregistered in the meantime
            connection.close()
            raise
        if impl.closed:
            connection.close()
        return added

    impl.add_connection, impl.sends_directly = add_connection, True


QUEUE_SIZE = 10  # messages per subscriber, the oldest is dropped beyond

# rospy warns about a missing queue size. (catch_warnings is not for several threads.)
warnings.filterwarnings("ignore", "The publisher should be created with", SyntaxWarning)

_in_lockstep, _relay = False, None
_made = threading.local()  # .lists: of the endpoints made within each all_or_none


def set_lockstep(lockstep: bool) -> None:
    """Choose the mode; to be called before the first publisher is made."""
    global _in_lockstep
    _in_lockstep = lockstep


def set_relay(relay: Relay | None) -> None:
    """Set the Relay to send through, or None; to be called before the first publisher is made."""
    global _relay
    _relay = relay


def publisher(
    topic: str,
    message_type: type,
    latch: bool = False,
    queue_size: int = QUEUE_SIZE,
    relayed: bool = True,
) -> rospy.Publisher:
    """A rospy.Publisher that sends as the mode requires.

    Args:
        topic, message_type, latch: as rospy's.
        queue_size: messages per subscriber.
        relayed: False for large messages that other threads than the simulation's publish.

    Raises:
        ModelError: messages of another type leave on the topic.
    """
    check_type(topic, message_type, get_topic_manager().get_publisher_impl)
    made = rospy.Publisher(topic, message_type, latch=latch, queue_size=None)
    note_endpoint(made)
    if _in_lockstep:
        send_directly(made, None)
    else:
        send_directly(made, queue_size, _relay if relayed else None)
    return made


def check_type(topic: str, message_type: Any, find: Callable[[str], Any]) -> None:
    """Refuse a second type on a topic: rospy takes it, and subscribers cannot read what they get.

    Args:
        find: function of a resolved name -> the topic's publishers or subscribers in this process.

    Raises:
        ModelError: names the topic and both types.
    """
    name = rospy.resolve_name(topic)
    present = find(name)
    if present is not None and present.data_class not in (message_type, rospy.AnyMsg):
        raise ModelError(
            f"topic {name} carries {present.data_class._type} already, and cannot carry "
            f"{message_type._type}, too; it needs another name"
        )


def note_endpoint(made: Any) -> None:
    """Unregister an endpoint, too, if the present all_or_none fails."""
    for made_here in getattr(_made, "lists", ()):
        made_here.append(made)


@contextlib.contextmanager
def all_or_none() -> Iterator[None]:
    """Unregister the publishers and other endpoints made here if an exception leaves it."""
    made_here: list[Any] = []
    before = getattr(_made, "lists", ())
    _made.lists = (*before, made_here)
    try:
        yield
    except BaseException:
        for made in made_here:
            made.unregister()
        raise
    finally:
        _made.lists = before
