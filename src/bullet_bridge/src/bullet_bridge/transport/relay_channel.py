"""The relay process and the socket to it; see relay_process.py for what goes through it."""

import pathlib
import select
import socket
import struct
import subprocess
import sys

from bullet_sim.child import blocking_pair

from bullet_bridge.transport.relay_process import NUMBER

TIMEOUT = 2.0  # [s] wall time for the relay to accept data, to reply and to end


class ChannelError(OSError):
    """The relay process does not take data; the message is what the process does or is."""


class RelayChannel:
    """Starts the relay process, writes to it and reads from it.

    Attributes:
        process: subprocess.Popen.

    Raises:
        OSError: the process does not start.
    """

    def __init__(self):
        self._socket, child_end = blocking_pair()
        self._socket.setsockopt(
            socket.SOL_SOCKET, socket.SO_SNDTIMEO, struct.pack("ll", int(TIMEOUT), 0)
        )
        script = pathlib.Path(__file__).with_name("relay_process.py")
        try:
            self.process = subprocess.Popen(
                [sys.executable, "-I", "-S", str(script), str(child_end.fileno())],
                stdin=subprocess.DEVNULL,
                pass_fds=[child_end.fileno()],
            )
        except OSError:
            self._socket.close()
            raise
        finally:
            child_end.close()

    def pass_socket(self, record, passed):
        """Write a record and pass a socket along with it.

        Raises:
            ChannelError: the process does not take it.
        """
        try:
            socket.send_fds(self._socket, [record], [passed.fileno()])
        except OSError:
            raise ChannelError("does not take subscribers") from None

    def write(self, data):
        """Write records.

        Raises:
            ChannelError: the process is gone, or has read nothing for TIMEOUT.
        """
        try:
            sent = self._socket.send(data, socket.MSG_DONTWAIT)
        except BlockingIOError:
            sent = 0
        except OSError:
            raise ChannelError("is gone") from None
        if sent < len(data):
            self._write_rest(memoryview(data)[sent:])

    def _write_rest(self, data):
        """Block until the relay has read the rest; it never blocks on a subscriber itself."""
        poller = select.poll()
        try:
            poller.register(self._socket, select.POLLOUT)
            while data:
                if not poller.poll(TIMEOUT * 1000):
                    raise ChannelError(f"took nothing for {TIMEOUT:g} s")
                try:
                    data = data[self._socket.send(data, socket.MSG_DONTWAIT) :]
                except BlockingIOError:
                    pass
        except ChannelError:
            raise
        except OSError:
            raise ChannelError("is gone") from None

    def numbers(self):
        """Yields the numbers that the process writes, until it ends."""
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

    def end(self):
        """End the process, which sends what it has read; kill it after TIMEOUT."""
        try:
            self._socket.shutdown(socket.SHUT_RDWR)
        except OSError:
            pass
        try:
            self.process.wait(TIMEOUT)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()

    def close(self):
        """Close the socket, after numbers() has ended."""
        self._socket.close()
