"""Sending without a thread in between.

rospy hands every message of a publisher with a queue to a thread per subscriber and yields to it,
which costs the physics several thread switches a message. Here the publishing thread writes to the
socket itself as long as the kernel takes the bytes at once; only what it does not take waits for a
thread. Nagle's algorithm is off: a message waits for nobody's acknowledgement.
"""

import collections
import socket
import threading

import rospy
from rospy.exceptions import TransportTerminated

from bullet_bridge.transport.relay_process import keep


class Front:
    """Stands before a rospy transport to one subscriber, as rospy's QueuedConnection does.

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
            TransportTerminated: the subscriber is gone.
        """
        if self._connection.done:
            raise TransportTerminated("connection closed")
        self._write(data)
        return True


def prepare(sock):
    """Make a subscriber's socket wait for nobody's acknowledgement, and blocking."""
    sock.settimeout(None)
    if sock.family in (socket.AF_INET, socket.AF_INET6):
        sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)


class DirectConnection(Front):
    """Writes to the subscriber's socket itself.

    Args:
        connection: rospy transport with a socket.
        limit: messages that may wait, the oldest is dropped beyond; None: writing waits until the
            kernel has taken all.
    """

    def __init__(self, connection, limit):
        super().__init__(connection)
        self._limit, self._socket = limit, connection.socket
        prepare(self._socket)
        self._changed = threading.Condition()
        self._waiting, self._thread, self._busy = collections.deque(), None, False
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
        """Whether the kernel took all; the rest of what it took in part goes to the thread."""
        try:
            sent = self._socket.send(data, socket.MSG_DONTWAIT)
        except BlockingIOError:
            return False
        if sent < len(data):
            with self._changed:
                self._waiting.appendleft(memoryview(data)[sent:])
            self._wake()
        return True

    def _send_later(self, data):
        with self._changed:
            keep(self._waiting, data, self._limit)
        self._wake()

    def _wake(self):
        with self._changed:
            self._busy = bool(self._waiting) or self._busy
            if self._thread is None:
                self._thread = threading.Thread(
                    target=self._drain, name="slow-subscriber", daemon=True
                )
                self._thread.start()
            self._changed.notify_all()

    def _drain(self):
        """The thread: sends what waits, in order."""
        while True:
            with self._changed:
                while not self._waiting and not self._connection.done:
                    self._busy = False
                    self._changed.wait()
                if self._connection.done:
                    return
                data = self._waiting.popleft()
            try:
                self._socket.sendall(data)
            except OSError:
                self._connection.close()
                return

    def _on_close(self, _connection):
        with self._changed:
            self._changed.notify_all()


def send_directly(publisher, limit, relay=None):
    """Let a new rospy.Publisher use DirectConnection for TCP subscribers.

    Args:
        publisher: rospy.Publisher without a queue, just made: nobody is connected yet.
        limit: see DirectConnection.
        relay: Relay that serves them instead as long as it is alive; None: none.
    """
    impl = publisher.impl
    if getattr(impl, "sends_directly", False):  # another Publisher of the same topic did it
        return
    plain = impl.add_connection

    def add_connection(connection):
        if getattr(connection, "socket", None) is not None:
            try:
                relayed = relay.serve(connection, limit) if relay is not None else None
                connection = relayed or DirectConnection(connection, limit)
            except OSError as error:  # gone already
                rospy.logdebug("subscriber of %s is gone: %s", impl.resolved_name, error)
                return False
        try:
            added = plain(connection)
        except Exception:  # the topic was withdrawn meanwhile
            connection.close()
            raise
        if impl.closed:
            connection.close()
        return added

    impl.add_connection, impl.sends_directly = add_connection, True
