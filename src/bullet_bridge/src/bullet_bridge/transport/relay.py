"""The relay process: packed messages go to subscribers from there, not from the bridge.

Sending through the relay process: one write of the simulation thread for all subscribers. A write
to the socket of a sleeping process also wakes that process. The wake-up takes the sender several
times as long as the write, and each message has several subscribers. So the simulation thread
writes to the relay process only, which writes to the subscribers: see relay_process.py.
"""

from __future__ import annotations

import array
import collections
import pathlib
import select
import socket
import struct
import sys
import threading
import time
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import rospy
from bullet_sim.child import Child
from bullet_sim.pose import Array
from rospy.exceptions import TransportTerminated

from bullet_bridge.transport.connections import (
    ConnectionWrapper,
    prepare_socket,
    reconnect_subscribers,
)
from bullet_bridge.transport.relay_process import ADD, DRAIN, HEAD, MESSAGE, NUMBER, POLL, REMOVE

TIMEOUT = 2.0  # [s] wall time for the relay to accept data, to reply and to exit


class ChannelError(OSError):
    """The relay process does not take data; the message is what the process does or is."""


class RelayChannel:
    """Starts the relay process, writes to it and reads from it.

    Attributes:
        name: for messages, with the process id.

    Raises:
        OSError: the process does not start.
    """

    def __init__(self) -> None:
        script = pathlib.Path(__file__).with_name("relay_process.py")
        command = (sys.executable, "-I", "-S", str(script))
        self._child = Child("the relay", command, logged=False)
        self.process, self.name = self._child.process, self._child.name
        self._socket = self._child.socket
        self._socket.setsockopt(
            socket.SOL_SOCKET, socket.SO_SNDTIMEO, struct.pack("ll", int(TIMEOUT), 0)
        )

    def pass_socket(self, record: bytes, passed: socket.socket) -> None:
        """Write a record and pass a socket along with it.

        Raises:
            ChannelError: the process does not take it.
        """
        try:
            descriptors = array.array("i", [passed.fileno()])
            self._socket.sendmsg([record], [(socket.SOL_SOCKET, socket.SCM_RIGHTS, descriptors)])
        except OSError:
            raise ChannelError("does not take subscribers") from None

    def write(self, data: bytes) -> None:
        """Write records.

        Raises:
            ChannelError: the process has exited, or has read nothing for TIMEOUT.
        """
        try:
            sent = self._socket.send(data, socket.MSG_DONTWAIT)
        except BlockingIOError:
            sent = 0
        except OSError:
            raise ChannelError("has exited") from None
        if sent < len(data):
            self._write_rest(memoryview(data)[sent:])

    def _write_rest(self, data: memoryview) -> None:
        """Block until the relay has read the rest; it never blocks on a subscriber itself."""
        poller = select.poll()
        try:
            poller.register(self._socket, select.POLLOUT)
            while data:
                if not poller.poll(TIMEOUT * 1000):
                    raise ChannelError(f"read nothing for {TIMEOUT:g} s")
                try:
                    data = data[self._socket.send(data, socket.MSG_DONTWAIT) :]
                except BlockingIOError:
                    pass
        except ChannelError:
            raise
        except OSError:
            raise ChannelError("has exited") from None

    def numbers(self) -> Iterator[int]:
        """Yields the numbers that the process writes, until it exits."""
        left = b""
        while True:
            try:
                data = self._socket.recv(4096)
            except OSError:
                return
            if not data:
                return
            left += data
            while len(left) >= NUMBER.size:
                (number,) = NUMBER.unpack_from(left)
                left = left[NUMBER.size :]
                yield number

    def end(self) -> None:
        """Shut the process down, which sends what it has read; kill it after TIMEOUT."""
        self._child.shut_down()
        self._child.wait(TIMEOUT)

    def close(self) -> None:
        """Close the socket, after numbers() has ended."""
        self._child.close()


class RelayedConnection(ConnectionWrapper):
    """Passes messages to the relay process, which writes them to the subscriber's socket."""

    def __init__(self, connection: Any, relay: Relay, number: int) -> None:
        super().__init__(connection)
        self._relay, self._number = relay, number
        self._size, self._head = -1, b""  # of the last message; most topics have one size
        self.stat_bytes, self.stat_num_msg = connection.stat_bytes, connection.stat_num_msg

    def _write(self, data: bytes) -> None:
        size = len(data)
        self._relay.put(self._head_of(size) + data)
        self.stat_bytes += size
        self.stat_num_msg += 1

    def write_block(self, block: Array) -> None:
        """As of a ConnectionWrapper, in one piece."""
        if self._connection.done:
            raise TransportTerminated("connection closed")
        count, size = block.shape
        head = np.frombuffer(self._head_of(size), np.uint8)
        self._relay.put(np.hstack((np.broadcast_to(head, (count, len(head))), block)).tobytes())
        self.stat_bytes += block.size
        self.stat_num_msg += count

    def _head_of(self, size: int) -> bytes:
        """What is before a message of a size [bytes] in a record."""
        if size != self._size:
            self._size, self._head = size, HEAD.pack(MESSAGE, self._number, size)
        return self._head


class Relay:
    """Starts and feeds the relay process.

    If the process exits or hangs, the connections of its subscribers are closed, the subscribers
    reconnect through the master, and `alive` is False from then on.

    Args:
        on_failure: called with one line of text when the process exits before close().
        reconnect: called after that, to have the subscribers reconnect; may take seconds.

    Raises:
        OSError: the process does not start.
    """

    def __init__(
        self,
        on_failure: Callable[[str], None] = rospy.logerr,
        reconnect: Callable[[], None] = reconnect_subscribers,
    ) -> None:
        self._on_failure, self._reconnect = on_failure, reconnect
        self._channel = RelayChannel()
        self.process = self._channel.process
        self.alive, self._closing = True, False
        self._lock = threading.RLock()
        self._buffer: collections.deque[bytes] = collections.deque()
        self._closed: collections.deque[int] = collections.deque()
        self._last = 0
        self._batching = self._flushing = False
        self._connections: dict[int, Any] = {}  # number -> rospy transport
        self._drained = threading.Event()
        self._receiver = threading.Thread(target=self._receive, name="relay", daemon=True)
        self._receiver.start()

    def add_subscriber(self, connection: Any, limit: int) -> RelayedConnection | None:
        """Pass the socket of a rospy transport to the relay process.

        Args:
            limit: queue size [messages], the oldest is dropped beyond.

        Returns:
            RelayedConnection, or None: the relay has exited.
        """
        sock = connection.socket
        prepare_socket(sock)
        with self._lock:
            self._flush()
            if not self.alive:
                return None
            self._last += 1  # its record is sent alone, after all earlier ones
            number = self._last
            try:
                self._channel.pass_socket(HEAD.pack(ADD, number, limit), sock)
            except ChannelError as error:
                self._fail(str(error))
                return None
            self._connections[number] = connection
        connection.set_cleanup_callback(lambda _: self._on_close(number))
        return RelayedConnection(connection, self, number)

    def _on_close(self, number: int) -> None:
        """Never blocks: rospy calls it holding locks that a signal handler may need."""
        self._closed.append(number)
        if not self._batching and self._lock.acquire(blocking=False):
            try:
                self._flush()
            finally:
                self._lock.release()

    def set_polling(self, polling: bool) -> None:
        """Choose whether the relay polls for messages (frequent ones) or blocks until one comes."""
        self.put(HEAD.pack(POLL, 0, int(polling)))

    def drain(self) -> None:
        """Wait until all messages are sent, or queued for a slow subscriber."""
        with self._lock:
            self._drained.clear()
            self.put(HEAD.pack(DRAIN, 0, 0))
            self._flush()
        deadline = time.monotonic() + TIMEOUT
        while self.alive and not self._drained.wait(0.1):
            if time.monotonic() > deadline:
                self._fail(f"did not respond for {TIMEOUT:g} s")

    def put(self, data: bytes) -> None:
        """Write complete records, now or in end_batch()."""
        self._buffer.append(data)  # atomic: other threads call it, too
        if not self._batching:
            with self._lock:
                self._flush()

    def begin_batch(self) -> None:
        """Buffer all records, of any thread, until end_batch() writes them in one call."""
        self._batching = True

    def end_batch(self) -> None:
        """Write the buffered records."""
        self._batching = False
        if self._buffer:
            with self._lock:
                self._flush()

    def _flush(self) -> None:
        """Write the buffer. A call from a signal handler during a flush leaves it to that flush."""
        if self._flushing:
            return
        self._flushing = True
        try:
            while self._buffer or self._closed:
                records = [self._buffer.popleft() for _ in range(len(self._buffer))]
                while self._closed:
                    number = self._closed.popleft()
                    if self._connections.pop(number, None) is not None:
                        records.append(HEAD.pack(REMOVE, number, 0))
                if self.alive and records:
                    try:
                        self._channel.write(b"".join(records))
                    except ChannelError as error:
                        self._fail(str(error))
        finally:
            self._flushing = False

    def _fail(self, reason: str) -> None:
        """Kill the process and close the connections: messages may have been sent in part."""
        with self._lock:
            if not self.alive:
                return
            self.alive = False
            connections, self._connections = list(self._connections.values()), {}
        self.process.kill()
        threading.Thread(
            target=self._close_all, args=(connections, reason), name="relay-end", daemon=True
        ).start()

    def _close_all(self, connections: list[Any], reason: str) -> None:
        """In a separate thread: closing takes locks of rospy's topics."""
        for connection in connections:
            connection.close()
        if not self._closing and not rospy.is_shutdown():
            self._on_failure(
                f"{self._channel.name} {reason}; the bridge sends directly from now on"
            )
            self._reconnect()

    def _receive(self) -> None:
        """The thread: closes connections whose socket has failed in the relay."""
        for number in self._channel.numbers():
            if number == 0:
                self._drained.set()
                continue
            with self._lock:
                connection = self._connections.pop(number, None)
            if connection is not None:
                try:
                    connection.close()
                except TypeError:  # rospy has closed its topic meanwhile, which has no list then
                    pass
        self._fail("has exited")

    def close(self) -> None:
        """Flush the buffer and shut the process down, which sends what it has read."""
        self._closing = True
        with self._lock:
            self._flush()
            self.alive = False
        self._channel.end()
        self._receiver.join(TIMEOUT)
        self._channel.close()
