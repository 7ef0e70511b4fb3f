"""Sending through a process of its own: one write of the simulation thread for all subscribers.

To send a message to a process that sleeps takes the sender's time to wake it, several times what
the message costs otherwise, and several nodes hear each message. The simulation thread leaves that
to the relay. What the relay does with the messages stands in relay_process.
"""

import collections
import pathlib
import select
import socket
import struct
import subprocess
import sys
import threading
import time

import rospy
from bullet_sim.system.sockets import blocking_pair

from bullet_bridge.transport.calling_back import call_subscribers_back
from bullet_bridge.transport.direct import Front, prepare
from bullet_bridge.transport.relay_process import ADD, ECHO, HEAD, HURRY, MESSAGE, NUMBER, REMOVE

PATIENCE = 2.0  # [s] wall time that the relay may leave its socket full, or take to end


class RelayedConnection(Front):
    """Has the relay write to the subscriber's socket."""

    def __init__(self, connection, relay, number):
        super().__init__(connection)
        self._relay, self._number = relay, number
        self._size, self._head = -1, b""  # of the last message; most topics have one size
        self.stat_bytes, self.stat_num_msg = connection.stat_bytes, connection.stat_num_msg

    def _write(self, data):
        size = len(data)
        if size != self._size:
            self._size, self._head = size, HEAD.pack(MESSAGE, self._number, size)
        self._relay.put(self._head + data)
        self.stat_bytes += size
        self.stat_num_msg += 1


class Relay:
    """The relay's process, as the bridge sees it.

    If it dies or hangs, what it served is closed, the master is asked to tell the subscribers where
    to connect again, and `alive` is False from then on.

    Args:
        on_end: called with one line of text when the process dies before close().
        call_back: called, some seconds after that, to have the subscribers connect again.

    Raises:
        OSError: it does not start.
    """

    def __init__(self, on_end=rospy.logerr, call_back=call_subscribers_back):
        self._on_end, self._call_back = on_end, call_back
        self._channel, its = blocking_pair()
        self._channel.setsockopt(
            socket.SOL_SOCKET, socket.SO_SNDTIMEO, struct.pack("ll", int(PATIENCE), 0)
        )
        script = pathlib.Path(__file__).with_name("relay_process.py")
        try:
            self.process = subprocess.Popen(
                [sys.executable, "-I", "-S", str(script), str(its.fileno())],
                stdin=subprocess.DEVNULL,
                pass_fds=[its.fileno()],
            )
        except OSError:
            self._channel.close()
            raise
        finally:
            its.close()
        self.alive, self._closing = True, False
        self._lock = threading.RLock()
        self._parts, self._gone, self._last = collections.deque(), collections.deque(), 0
        self._gathering = self._flushing = False
        self._served = {}  # number -> rospy transport
        self._caught_up = threading.Event()
        self._listener = threading.Thread(target=self._listen, name="relay", daemon=True)
        self._listener.start()

    def serve(self, connection, limit):
        """Take over a rospy transport with a socket.

        Args:
            connection: the transport.
            limit: messages that may wait for it, the oldest is dropped beyond.

        Returns:
            RelayedConnection, or None: the relay has ended.
        """
        sock = connection.socket
        prepare(sock)
        with self._lock:
            self._flush()
            if not self.alive:
                return None
            self._last += 1  # its record goes by itself, behind what was put before
            number = self._last
            try:
                socket.send_fds(self._channel, [HEAD.pack(ADD, number, limit)], [sock.fileno()])
            except OSError:
                self._give_up("does not take subscribers")
                return None
            self._served[number] = connection
        connection.set_cleanup_callback(lambda _: self._forget(number))
        return RelayedConnection(connection, self, number)

    def _forget(self, number):
        """Never waits: rospy calls it with locks held that a signal handler may want."""
        self._gone.append(number)
        if not self._gathering and self._lock.acquire(blocking=False):
            try:
                self._flush()
            finally:
                self._lock.release()

    def hurry(self, flag):
        """Tell whether messages come all the time, so that the relay should not sleep."""
        self.put(HEAD.pack(HURRY, 0, int(flag)))

    def catch_up(self):
        """Wait until all that was put is sent, or waits for a subscriber that is slow."""
        with self._lock:
            self._caught_up.clear()
            self.put(HEAD.pack(ECHO, 0, 0))
            self._flush()
        deadline = time.monotonic() + PATIENCE
        while self.alive and not self._caught_up.wait(0.1):
            if time.monotonic() > deadline:
                self._give_up(f"did not answer for {PATIENCE:g} s")

    def put(self, data):
        """Write whole records, now or at release()."""
        self._parts.append(data)  # atomic: other threads put, too
        if not self._gathering:
            with self._lock:
                self._flush()

    def gather(self):
        """From here to release() what is put, by any thread, waits and goes in one piece."""
        self._gathering = True

    def release(self):
        """Write what was gathered."""
        self._gathering = False
        if self._parts:
            with self._lock:
                self._flush()

    def _flush(self):
        """Write what was put; a signal handler may come in between, which leaves that to us."""
        if self._flushing:
            return
        self._flushing = True
        try:
            while self._parts or self._gone:
                parts = [self._parts.popleft() for _ in range(len(self._parts))]
                while self._gone:
                    number = self._gone.popleft()
                    if self._served.pop(number, None) is not None:
                        parts.append(HEAD.pack(REMOVE, number, 0))
                if self.alive and parts:
                    self._write(b"".join(parts))
        finally:
            self._flushing = False

    def _write(self, data):
        try:
            sent = self._channel.send(data, socket.MSG_DONTWAIT)
        except BlockingIOError:
            sent = 0
        except OSError:
            self._give_up("is gone")
            return
        if sent < len(data):
            self._send_rest(memoryview(data)[sent:])

    def _send_rest(self, data):
        """The relay never waits for a subscriber: it is worth waiting for."""
        poller = select.poll()
        poller.register(self._channel, select.POLLOUT)
        try:
            while data:
                if not poller.poll(PATIENCE * 1000):
                    self._give_up(f"took nothing for {PATIENCE:g} s")
                    return
                try:
                    data = data[self._channel.send(data, socket.MSG_DONTWAIT) :]
                except BlockingIOError:
                    pass
        except OSError:
            self._give_up("is gone")

    def _give_up(self, reason):
        """Whatever the relay has sent of a message is lost: the connections have to go, too."""
        with self._lock:
            if not self.alive:
                return
            self.alive = False
            served, self._served = list(self._served.values()), {}
        self.process.kill()
        threading.Thread(
            target=self._end, args=(served, reason), name="relay-end", daemon=True
        ).start()

    def _end(self, served, reason):
        """In a thread of its own: closing takes locks of rospy's topics."""
        for connection in served:
            connection.close()
        if not self._closing and not rospy.is_shutdown():
            self._on_end(
                f"the relay (pid {self.process.pid}) {reason}; the bridge sends by itself "
                "from now on"
            )
            self._call_back()

    def _listen(self):
        """The thread: closes what the relay found closed."""
        left = b""
        while True:
            try:
                data = self._channel.recv(4096)
            except OSError:
                data = b""
            if not data:
                break
            left += data
            while len(left) >= NUMBER.size:
                (number,) = NUMBER.unpack_from(left)
                left = left[NUMBER.size :]
                if number == 0:
                    self._caught_up.set()
                    continue
                with self._lock:
                    connection = self._served.pop(number, None)
                if connection is not None:
                    connection.close()
        self._give_up("has ended")

    def close(self):
        """End the process; it sends what it has got."""
        self._closing = True
        with self._lock:
            self._flush()
            self.alive = False
        try:
            self._channel.shutdown(socket.SHUT_RDWR)
        except OSError:
            pass
        try:
            self.process.wait(PATIENCE)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
        self._listener.join(PATIENCE)
        self._channel.close()
