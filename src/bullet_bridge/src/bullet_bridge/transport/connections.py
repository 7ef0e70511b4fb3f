"""Connections to subscribers, as rospy's transports, that write in the publishing thread.

Sending from the publishing thread, without a thread for each subscriber. rospy passes each message
of a publisher with a queue to one thread per subscriber and yields to it: several thread switches
per message, which slow down the physics. A DirectConnection writes to the subscriber's socket in
the publishing thread. Only what the kernel does not accept immediately is queued for a thread.
Nagle's algorithm is off, so that no message waits for an acknowledgement.
"""

from __future__ import annotations

import collections
import socket
import threading
import time
from collections.abc import Iterable
from typing import Any

import rosgraph
import rospy
from bullet_sim.pose import Array
from rospy.exceptions import TransportTerminated
from rospy.impl.registration import get_topic_manager

from bullet_bridge.transport.relay_process import enqueue


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

    def write_block(self, block: Array) -> None:
        """Send messages (k, n) of bytes, as write_data each."""
        for message in block:
            self.write_data(message.tobytes())


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
        self._queue: collections.deque[bytes | memoryview] = collections.deque()
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
