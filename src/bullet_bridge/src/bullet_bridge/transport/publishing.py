"""Publishers whose messages leave in the simulation's thread, in order.

Sending from the publishing thread, without a thread for each subscriber. rospy passes each message
of a publisher with a queue to one thread per subscriber and yields to it: several thread switches
per message, which slow down the physics. A DirectConnection writes to the subscriber's socket in
the publishing thread. Only what the kernel does not accept immediately is queued for a thread.
Nagle's algorithm is off, so that no message waits for an acknowledgement.

How publishers send: through the relay, or in lockstep directly. Normally the physics never waits
for a subscriber: the relay process sends, and what a slow subscriber cannot take goes to a short
queue from which the oldest message is dropped. In lockstep publish() returns when the socket of
every subscriber has taken the message and nothing is dropped, so that all messages of a step are
sent when the step returns.
"""

import collections
import contextlib
import socket
import threading
import time
import warnings
from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING, Any

import rosgraph
import rospy
from rospy.exceptions import TransportTerminated
from rospy.impl.registration import get_topic_manager

from bullet_bridge.transport.relay_process import Queue, enqueue

if TYPE_CHECKING:
    from bullet_bridge.transport.relay import Relay


class ConnectionWrapper:
    """Wraps a rospy transport to one subscriber, as rospy's QueuedConnection does.

    Args:
        connection: rospy transport with a socket.
    """

    def __init__(self, connection: Any) -> None:
        self._connection = connection

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        return getattr(self._connection, name)

    def write_data(self, data: bytes) -> bool:
        """Send a message; rospy calls it with the topic's lock held.

        Raises:
            TransportTerminated: the connection is closed.
        """
        if self._connection.done:
            raise TransportTerminated("connection closed")
        self._write(data)
        return True


def prepare_socket(sock: socket.socket) -> None:
    """Make a subscriber's socket blocking and turn off Nagle's algorithm."""
    sock.settimeout(None)
    if sock.family in (socket.AF_INET, socket.AF_INET6):
        sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)


class DirectConnection(ConnectionWrapper):
    """Writes to the subscriber's socket in the publishing thread.

    Args:
        limit: queue size [messages], the oldest is dropped beyond; None: no queue, a write blocks
            until the kernel has accepted the full message.
    """

    def __init__(self, connection: Any, limit: int | None) -> None:
        super().__init__(connection)
        self._limit: Any = limit
        self._socket = connection.socket
        prepare_socket(self._socket)
        self._changed = threading.Condition()
        self._queue: Queue = collections.deque()
        self._thread: threading.Thread | None = None
        self._busy = False
        connection.set_cleanup_callback(self._on_close)

    def _write(self, data: bytes) -> None:
        try:
            if self._limit is None:
                self._socket.sendall(data)
            elif self._busy or not self._send_now(data):
                self._send_later(data)
        except OSError as error:
            self._connection.close()
            raise TransportTerminated(str(error)) from error
        self._connection.stat_bytes += len(data)
        self._connection.stat_num_msg += 1

    def _send_now(self, data: bytes) -> bool:
        """Send without blocking; the rest of a message sent in part is queued.

        Returns:
            Whether the kernel accepted the message or a part of it.
        """
        try:
            sent = self._socket.send(data, socket.MSG_DONTWAIT)
        except BlockingIOError:
            return False
        if sent < len(data):
            with self._changed:
                self._queue.appendleft(memoryview(data)[sent:])
            self._wake()
        return True

    def _send_later(self, data: bytes) -> None:
        with self._changed:
            enqueue(self._queue, data, self._limit)
        self._wake()

    def _wake(self) -> None:
        with self._changed:
            self._busy = bool(self._queue) or self._busy
            if self._thread is None:
                self._thread = threading.Thread(
                    target=self._send_queued, name="slow-subscriber", daemon=True
                )
                self._thread.start()
            self._changed.notify_all()

    def _send_queued(self) -> None:
        """The thread: sends queued messages in order."""
        while True:
            with self._changed:
                while not self._queue and not self._connection.done:
                    self._busy = False
                    self._changed.wait()
                if self._connection.done:
                    return
                data = self._queue.popleft()
            try:
                self._socket.sendall(data)
            except OSError:
                self._connection.close()
                return

    def _on_close(self, _connection: Any) -> None:
        with self._changed:
            self._changed.notify_all()


def send_directly(
    publisher: rospy.Publisher, limit: int | None, relay: "Relay | None" = None
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


DELAYS = (1.0, 4.0)  # [s] wall time before each try: a busy subscriber notices the loss later


def reconnect_subscribers(delays: Iterable[float] = DELAYS) -> None:
    """Register this node's publishers with the master again.

    A rospy subscriber does not reconnect when its connection is closed. The master sends
    it the publishers of the topic whenever one registers, also one that is registered already.
    """
    for delay in delays:
        time.sleep(delay)
        if rospy.is_shutdown():
            return
        try:
            master = rosgraph.Master(rospy.get_name())
            for topic, message_type in get_topic_manager().get_publications():
                master.registerPublisher(topic, message_type, rospy.get_node_uri())
        except (rosgraph.MasterException, OSError) as error:
            rospy.logerr("subscribers cannot be reconnected: %s", error)


QUEUE_SIZE = 10  # messages per subscriber, the oldest is dropped beyond

# rospy warns about a missing queue size. (catch_warnings is not for several threads.)
warnings.filterwarnings("ignore", "The publisher should be created with", SyntaxWarning)

_in_lockstep, _relay = False, None
_made = threading.local()  # .lists: of the endpoints made within each all_or_none


def set_lockstep(lockstep: bool) -> None:
    """Choose the mode; to be called before the first publisher is made."""
    global _in_lockstep
    _in_lockstep = lockstep


def set_relay(relay: "Relay | None") -> None:
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
    """
    made = rospy.Publisher(topic, message_type, latch=latch, queue_size=None)
    note_endpoint(made)
    if _in_lockstep:
        send_directly(made, None)
    else:
        send_directly(made, queue_size, _relay if relayed else None)
    return made


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
