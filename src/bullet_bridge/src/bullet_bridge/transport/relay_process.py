"""The relay process: python -I -S relay_process.py SOCKET_FD. It imports only the standard library,
to start fast and stay small.

It reads records from a Unix stream socket; each starts with a header `type, subscriber, length`:
    MESSAGE     followed by the message's bytes, to be sent to the subscriber
    ADD         a new subscriber; length: its queue size [messages]; the file descriptor of its
                socket is passed along (SCM_RIGHTS)
    REMOVE      the subscriber has disconnected
    POLL        length 1: poll the socket for records; 0: block until one arrives
    DRAIN       reply 0 when all earlier messages are sent or queued for a slow subscriber
It writes back the number (uint32, from 1) of each subscriber whose socket has failed, and 0.

Messages of one subscriber that it has read at once it sends at once: it has read several where it
is behind, and then has the least to do.
"""

from __future__ import annotations

import collections
import select
import signal
import socket
import struct
import sys
import time

HEAD = struct.Struct("<BII")
NUMBER = struct.Struct("<I")
MESSAGE, ADD, REMOVE, POLL, DRAIN = range(5)
READ_SIZE = 1 << 14  # [bytes] read at once; topics may be behind each other by as much ...
LARGEST_READ = 1 << 18  # [bytes] ... and this of the rest of a message
DESCRIPTOR = struct.Struct("i")
DESCRIPTORS_SIZE = socket.CMSG_SPACE(64 * DESCRIPTOR.size)  # of up to 64 in one read [bytes]
POLL_PERIOD = 0.0005  # [s] between two reads while polling ...
POLL_TIMEOUT = 0.05  # [s] ... and time without a record after which it blocks


def enqueue(queue: collections.deque[bytes | memoryview], data: bytes, limit: int) -> None:
    """Append a message to a queue (deque); beyond the limit the oldest one is dropped.

    A memoryview at the head is the rest of a message that is sent in part, and is not dropped.
    """
    if len(queue) > limit:
        del queue[1 if isinstance(queue[0], memoryview) else 0]
    queue.append(data)


class Subscriber:
    """A subscriber's socket and its queue of at most `limit` messages."""

    def __init__(self, sock: socket.socket, limit: int) -> None:
        self.socket, self._limit = sock, limit
        # a memoryview at the head is the rest of a message
        self.queue: collections.deque[bytes | memoryview] = collections.deque()

    def send(self, messages: list[memoryview]) -> bool:
        """Send messages without blocking; what the kernel does not accept is queued.

        Returns:
            Whether the queue is empty.

        Raises:
            OSError: the connection has failed.
        """
        sent = 0
        if not self.queue:
            data = messages[0] if len(messages) == 1 else b"".join(messages)
            sent = self._send_part(data)
            if sent == len(data):
                return True
        for message in messages:
            if sent >= len(message):
                sent -= len(message)
                continue
            rest = bytes(message)  # a copy: the read buffer is freed
            if sent:
                self.queue.append(memoryview(rest)[sent:])
            else:
                enqueue(self.queue, rest, self._limit)
            sent = 0
        return False

    def _send_part(self, data: bytes | memoryview) -> int:
        try:
            return self.socket.send(data, socket.MSG_DONTWAIT)
        except BlockingIOError:
            return 0

    def flush(self) -> bool:
        """Send queued messages without blocking; returns and raises as send()."""
        while self.queue:
            data = self.queue[0]
            sent = self._send_part(data)
            if sent < len(data):
                if sent:
                    self.queue[0] = memoryview(data)[sent:]
                return False
            self.queue.popleft()
        return True


class Relay:
    """Reads records and sends messages.

    Args:
        channel: Unix stream socket.
    """

    def __init__(self, channel: socket.socket) -> None:
        self._channel = channel
        channel.setblocking(False)
        self._subscribers: dict[int, Subscriber] = {}
        self._slow: dict[int, Subscriber] = {}
        self._parts: list[bytes] = []  # of an incomplete record
        self._missing = 0
        self._descriptors: collections.deque[int] = collections.deque()
        self._polling = False

    def serve(self) -> None:
        """Run until the other end of the channel closes."""
        poller = select.poll()
        poller.register(self._channel, select.POLLIN)
        last = time.monotonic()
        while True:
            data = self._read()
            if data:
                self._parse(data)
                last = time.monotonic()
            elif data is not None:
                return
            for number in list(self._slow):
                self._send(number, None)
            if data:
                continue
            if self._polling and time.monotonic() - last < POLL_TIMEOUT:
                time.sleep(POLL_PERIOD)  # a write to a sleeping process costs the bridge a wake-up
            else:
                self._wait(poller)

    def _wait(self, poller: select.poll) -> None:
        for subscriber in self._slow.values():
            poller.register(subscriber.socket, select.POLLOUT)
        poller.poll()
        for subscriber in self._slow.values():
            poller.unregister(subscriber.socket)

    def _read(self) -> bytes | None:
        """Bytes; b'' at the end of the stream; None when there is nothing to read."""
        try:
            size = max(READ_SIZE, min(self._missing, LARGEST_READ))
            data, passed, _, _ = self._channel.recvmsg(size, DESCRIPTORS_SIZE)
        except BlockingIOError:
            return None
        except ConnectionError:
            return b""
        for level, kind, content in passed:
            if (level, kind) == (socket.SOL_SOCKET, socket.SCM_RIGHTS):
                whole = len(content) - len(content) % DESCRIPTOR.size
                self._descriptors += (each for (each,) in DESCRIPTOR.iter_unpack(content[:whole]))
        return data

    def _parse(self, data: bytes) -> None:
        """Process complete records; an incomplete one is stored until its rest is read."""
        if self._missing > 0:
            self._parts.append(data)
            self._missing -= len(data)
            if self._missing > 0:
                return
            data = b"".join(self._parts)
        view, start, size = memoryview(data), 0, len(data)
        messages: dict[int, list[memoryview]] = {}  # by subscriber
        while size - start >= HEAD.size:
            record, number, length = HEAD.unpack_from(data, start)
            begin = start + HEAD.size
            if record != MESSAGE:
                self._send_all(messages)
                self._command(record, number, length)
                start = begin
            elif size - begin >= length:
                messages.setdefault(number, []).append(view[begin : begin + length])
                start = begin + length
            else:
                break
        else:
            length = 0
        self._send_all(messages)
        left = data[start:]
        self._parts = [left] if left else []
        self._missing = HEAD.size + length - len(left) if left else 0

    def _command(self, record: int, number: int, length: int) -> None:
        if record == POLL:
            self._polling = bool(length)
        elif record == DRAIN:
            self._reply(0)
        elif record == ADD:
            sock = socket.socket(fileno=self._descriptors.popleft())
            self._subscribers[number] = Subscriber(sock, length)
        elif number in self._subscribers:
            self._slow.pop(number, None)
            self._subscribers.pop(number).socket.close()

    def _send_all(self, messages: dict[int, list[memoryview]]) -> None:
        """Send the messages of each subscriber, and forget them."""
        for number, of_one in messages.items():
            self._send(number, of_one)
        messages.clear()

    def _send(self, number: int, messages: list[memoryview] | None) -> None:
        """Send messages to a subscriber or, None, flush its queue."""
        subscriber = self._subscribers.get(number)
        if subscriber is None:
            return
        try:
            done = subscriber.flush() if messages is None else subscriber.send(messages)
        except OSError:
            self._command(REMOVE, number, 0)
            self._reply(number)
            return
        if done:
            self._slow.pop(number, None)
        else:
            self._slow[number] = subscriber

    def _reply(self, number: int) -> None:
        try:
            self._channel.send(NUMBER.pack(number))
        except OSError:
            pass  # the bridge has ended, or rospy sees the closed connection itself


def main(descriptor: str) -> None:
    """Serve; SIGINT is left to the bridge."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    Relay(socket.socket(fileno=int(descriptor))).serve()


if __name__ == "__main__":
    main(sys.argv[1])
