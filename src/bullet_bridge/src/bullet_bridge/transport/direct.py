"""Sending from the publishing thread, without a thread for each subscriber.

rospy passes each message of a publisher with a queue to one thread per subscriber and yields to it:
several thread switches per message, which slow down the physics. A DirectConnection writes to the
subscriber's socket in the publishing thread. Only what the kernel does not accept at once is queued
for a thread. Nagle's algorithm is off, so that no message waits for an acknowledgement.
"""

import collections
import socket
import threading

import rospy
from rospy.exceptions import TransportTerminated

from bullet_bridge.transport.relay_process import enqueue


class ConnectionWrapper:
    """Wraps a rospy transport to one subscriber, as rospy's QueuedConnection does.

    Args:
        connection: rospy transport with a socket.
    """

    def __init__(self, connection):
        self._connection = connection

    def __getattr__(self, name):
        if name.startswith("__"):
            raise AttributeError(name)
        return getattr(self._connection, name)

    def write_data(self, data):
        """Send a message; rospy calls it with the topic's lock held.

        Raises:
            TransportTerminated: the connection is closed.
        """
        if self._connection.done:
            raise TransportTerminated("connection closed")
        self._write(data)
        return True


def prepare_socket(sock):
    """Make a subscriber's socket blocking and turn off Nagle's algorithm."""
    sock.settimeout(None)
    if sock.family in (socket.AF_INET, socket.AF_INET6):
        sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)


class DirectConnection(ConnectionWrapper):
    """Writes to the subscriber's socket in the publishing thread.

    Args:
        connection: rospy transport with a socket.
        limit: queue size [messages], the oldest is dropped beyond; None: no queue, a write blocks
            until the kernel has accepted the whole message.
    """

    def __init__(self, connection, limit):
        super().__init__(connection)
        self._limit, self._socket = limit, connection.socket
        prepare_socket(self._socket)
        self._changed = threading.Condition()
        self._queue, self._thread, self._busy = collections.deque(), None, False
        connection.set_cleanup_callback(self._on_close)

    def _write(self, data):
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

    def _send_now(self, data):
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

    def _send_later(self, data):
        with self._changed:
            enqueue(self._queue, data, self._limit)
        self._wake()

    def _wake(self):
        with self._changed:
            self._busy = bool(self._queue) or self._busy
            if self._thread is None:
                self._thread = threading.Thread(
                    target=self._send_queued, name="slow-subscriber", daemon=True
                )
                self._thread.start()
            self._changed.notify_all()

    def _send_queued(self):
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

    def _on_close(self, _connection):
        with self._changed:
            self._changed.notify_all()


def send_directly(publisher, limit, relay=None):
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

    def add_connection(connection):
        if getattr(connection, "socket", None) is not None:
            try:
                relayed = relay.add_subscriber(connection, limit) if relay is not None else None
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
