"""The relay's process: python -I -S relay_process.py SOCKET_FD. It imports nothing but the standard
library, so that it starts at once and stays small.

Records come through a Unix stream socket, each with a head `kind, subscriber, length`:
    MESSAGE     its bytes follow, to be sent to the subscriber
    ADD         a new subscriber; length: how many messages may wait for it; the file descriptor of
                its socket comes along (SCM_RIGHTS)
    REMOVE      the subscriber has gone
    HURRY       length 1: messages come all the time; 0: now and then
    ECHO        answer with 0: what came before is sent, or waits for a slow subscriber
Back goes the number (uint32, from 1) of each subscriber whose socket has failed, and 0.
"""

import collections
import select
import signal
import socket
import struct
import sys
import time

HEAD = struct.Struct("<BII")
NUMBER = struct.Struct("<I")
MESSAGE, ADD, REMOVE, HURRY, ECHO = range(5)
PIECE = 1 << 18  # [bytes] read at once
DESCRIPTORS = 64  # most file descriptors that come at once
NAP = 0.0002  # [s] between two looks while messages come all the time ...
LINGER = 0.05  # [s] ... and how long without one before it waits to be woken


def keep(waiting, data, limit):
    """Let a message wait behind the others (deque); the oldest is dropped beyond the limit, but not
    the rest of one that is sent in part (a memoryview in front)."""
    if len(waiting) > limit:
        del waiting[1 if isinstance(waiting[0], memoryview) else 0]
    waiting.append(data)


class Subscriber:
    """The socket of a subscriber and what waits for it, the oldest is dropped beyond `limit`."""

    def __init__(self, sock, limit):
        self.socket, self._limit = sock, limit
        self.waiting = collections.deque()  # a memoryview in front is the rest of a message

    def send(self, data):
        """Send at once what the kernel takes at once.

        Returns:
            Whether nothing waits.

        Raises:
            OSError: the subscriber is gone.
        """
        if self.waiting:
            keep(self.waiting, bytes(data), self._limit)
            return False
        sent = self._try(data)
        if sent < len(data):
            rest = bytes(data)  # a copy: what was read is given up
            self.waiting.append(memoryview(rest)[sent:] if sent else rest)
        return sent == len(data)

    def _try(self, data):
        try:
            return self.socket.send(data, socket.MSG_DONTWAIT)
        except BlockingIOError:
            return 0

    def go_on(self):
        """Send what waits, as far as the kernel takes it; returns and raises as send()."""
        while self.waiting:
            data = self.waiting[0]
            sent = self._try(data)
            if sent < len(data):
                if sent:
                    self.waiting[0] = memoryview(data)[sent:]
                return False
            self.waiting.popleft()
        return True


class Relay:
    """Reads records and sends messages.

    Args:
        channel: Unix stream socket.
    """

    def __init__(self, channel):
        self._channel = channel
        channel.setblocking(False)  # CPython 3.11 passes over the flags of recv_fds
        self._subscribers, self._slow = {}, {}
        self._pieces, self._missing = [], 0  # of a record that is not complete
        self._descriptors = collections.deque()
        self._hurry = False

    def serve(self):
        """Until the other end of the channel closes."""
        poller = select.poll()
        poller.register(self._channel, select.POLLIN)
        last = time.monotonic()
        while True:
            data = self._read()
            if data:
                self._take(data)
                last = time.monotonic()
            elif data is not None:
                return
            for number in list(self._slow):
                self._attempt(number, None)
            if data:
                continue
            if self._hurry and time.monotonic() - last < LINGER:
                time.sleep(NAP)  # who writes need not wake us: that costs it more than all else
            else:
                self._wait(poller)

    def _wait(self, poller):
        for subscriber in self._slow.values():
            poller.register(subscriber.socket, select.POLLOUT)
        poller.poll()
        for subscriber in self._slow.values():
            poller.unregister(subscriber.socket)

    def _read(self):
        """Bytes, b'' at the end, None when there are none now."""
        try:
            data, descriptors, _, _ = socket.recv_fds(self._channel, PIECE, DESCRIPTORS)
        except BlockingIOError:
            return None
        except ConnectionError:
            return b""
        self._descriptors += descriptors
        return data

    def _take(self, data):
        """Do what whole records say; a part of one is kept until the rest is there."""
        if self._missing > 0:
            self._pieces.append(data)
            self._missing -= len(data)
            if self._missing > 0:
                return
            data = b"".join(self._pieces)
        view, start, size = memoryview(data), 0, len(data)
        while size - start >= HEAD.size:
            kind, number, length = HEAD.unpack_from(data, start)
            begin = start + HEAD.size
            if kind != MESSAGE:
                self._command(kind, number, length)
                start = begin
            elif size - begin >= length:
                self._attempt(number, view[begin : begin + length])
                start = begin + length
            else:
                break
        else:
            length = 0
        left = data[start:]
        self._pieces = [left] if left else []
        self._missing = HEAD.size + length - len(left) if left else 0

    def _command(self, kind, number, length):
        if kind == HURRY:
            self._hurry = bool(length)
        elif kind == ECHO:
            self._answer(0)
        elif kind == ADD:
            sock = socket.socket(fileno=self._descriptors.popleft())
            self._subscribers[number] = Subscriber(sock, length)
        elif number in self._subscribers:
            self._slow.pop(number, None)
            self._subscribers.pop(number).socket.close()

    def _attempt(self, number, data):
        """Send a message or, None, what waits."""
        subscriber = self._subscribers.get(number)
        if subscriber is None:
            return
        try:
            done = subscriber.go_on() if data is None else subscriber.send(data)
        except OSError:
            self._command(REMOVE, number, 0)
            self._answer(number)
            return
        if done:
            self._slow.pop(number, None)
        else:
            self._slow[number] = subscriber

    def _answer(self, number):
        try:
            self._channel.send(NUMBER.pack(number))
        except OSError:
            pass  # the bridge has gone, or rospy notices by itself


def main(descriptor):
    """Serve; Ctrl-C is left to the bridge."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    Relay(socket.socket(fileno=int(descriptor))).serve()


if __name__ == "__main__":
    main(sys.argv[1])
