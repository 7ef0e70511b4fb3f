"""Connections from outside: to a node's port for topics and services, and to that for XML-RPC.

rospy reads the header of a connection in the thread that accepts them: one that sends half of it
and no more keeps all others out. Here one thread waits for all headers at once. Each has to be
there HEADER_TIMEOUT after its connection; of more than MAX_WAITING the oldest is closed.

rospy's thread ends when accept() fails at the limit of open files, and nobody can reach the node
any more. Here connections are closed before it is reached, see `open_files`; when others have left,
new ones are accepted again.
"""

from __future__ import annotations

import errno
import functools
import logging
import selectors
import socket
import time
from typing import Any

from rosgraph.network import decode_ros_handshake_header
from rosgraph.xmlrpc import SilenceableXMLRPCRequestHandler, ThreadingXMLRPCServer
from rospy.impl import tcpros_base
from rospy.impl.tcpros_base import TCPServer

from paddock_common import open_files

HEADER_TIMEOUT = 5.0  # [s] wall time for the whole header of a connection
MAX_HEADER = 1 << 20  # [bytes] of a header; "POST" would be 1.4e9
MAX_WAITING = 128  # connections whose headers are not complete
REQUEST_TIMEOUT = 60.0  # [s] wall time for an XML-RPC request; roscpp keeps connections for 30 s

_log = logging.getLogger("rospy.closing")  # has no console handler


class _Header:
    """A connection whose header is being read."""

    def __init__(self, sock: socket.socket, address: Any) -> None:
        self.socket, self.address, self.data = sock, address, b""
        self.deadline = time.monotonic() + HEADER_TIMEOUT

    def read(self) -> bool:
        """Reads what is there, and nothing beyond the header; returns whether it is complete.

        Raises:
            OSError: the connection has failed, or begins with something else.
        """
        while True:
            needed = 4
            if len(self.data) >= 4:
                needed += int.from_bytes(self.data[:4], "little")
                if needed > 4 + MAX_HEADER:
                    raise OSError("begins with something else than a header")
                if needed == len(self.data):
                    return True
            try:
                data = self.socket.recv(needed - len(self.data))
            except BlockingIOError:
                return False
            if not data:
                raise OSError("was closed within its header")
            self.data += data


class _Acceptor:
    """Accepts connections and reads their headers, all in one thread.

    Args:
        server: rospy's TCPServer, to whose handler connections go with their header.
    """

    def __init__(self, server: Any) -> None:
        self._server, self._listening = server, server.server_sock
        self._selector = selectors.DefaultSelector()
        self._waiting: dict[socket.socket, _Header] = {}  # the oldest first
        self._next_report = 0.0

    def run(self) -> None:
        """Runs until the server is shut down."""
        self._listening.setblocking(False)
        self._listening.listen(socket.SOMAXCONN)
        self._selector.register(self._listening, selectors.EVENT_READ)
        while not self._server.is_shutdown:
            oldest = next(iter(self._waiting.values()), None)
            timeout = None if oldest is None else max(0.0, oldest.deadline - time.monotonic())
            for key, _ in self._selector.select(timeout):
                if key.data is None:
                    self._accept()
                elif key.fileobj in self._waiting:  # not closed meanwhile
                    self._read(key.data)
            self._close_late()
        self._selector.close()

    def _accept(self) -> None:
        try:
            sock, address = self._listening.accept()
        except OSError as error:
            if error.errno in open_files.EXHAUSTED:
                open_files.report()
                time.sleep(open_files.PAUSE)
            return
        if not open_files.is_room_for(sock):
            sock.close()
            return
        sock.setblocking(False)
        header = _Header(sock, address)
        self._waiting[sock] = header
        self._selector.register(sock, selectors.EVENT_READ, header)
        if len(self._waiting) > MAX_WAITING:
            self._close(next(iter(self._waiting.values())), "is the oldest of too many without one")
        self._read(header)  # it is often there already

    def _read(self, header: _Header) -> None:
        try:
            if not header.read():
                return
        except OSError as error:
            self._close(header, str(error))
            return
        self._forget(header)
        header.socket.setblocking(True)
        _read_headers[header.socket] = header.data
        try:
            self._server.inbound_handler(header.socket, header.address)
        except Exception as error:  # rospy logs its own
            _log.warning("a connection from %s fails: %s", header.address, error)
            header.socket.close()
        finally:
            _read_headers.pop(header.socket, None)

    def _close_late(self) -> None:
        now = time.monotonic()
        for header in [waiting for waiting in self._waiting.values() if waiting.deadline <= now]:
            self._close(header, f"has sent {len(header.data)} bytes in {HEADER_TIMEOUT:g} s")

    def _close(self, header: _Header, reason: str) -> None:
        self._forget(header)
        header.socket.close()
        now = time.monotonic()
        if now >= self._next_report:
            self._next_report = now + open_files.REPORT_PERIOD
            _log.warning("a connection from %s without a header %s", header.address, reason)

    def _forget(self, header: _Header) -> None:
        self._selector.unregister(header.socket)
        del self._waiting[header.socket]


_read_headers: dict[socket.socket, bytes] = {}  # of the connection that rospy's handler has
_read_header = tcpros_base.read_ros_handshake_header


@functools.wraps(_read_header)
def _header_of(sock: Any, buffer: Any, size: int) -> Any:
    data = _read_headers.get(sock)
    return _read_header(sock, buffer, size) if data is None else decode_ros_handshake_header(data)


def _serve(self: Any) -> None:
    """The thread of rospy's TCPServer."""
    self.is_shutdown = False
    _Acceptor(self).run()


_get_request = ThreadingXMLRPCServer.get_request


@functools.wraps(_get_request)
def _get_request_or_pause(self: Any) -> Any:
    """Accepts an XML-RPC connection; socketserver drops an OSError and tries again at once."""
    try:
        sock, address = _get_request(self)
    except OSError as error:
        if error.errno in open_files.EXHAUSTED:
            open_files.report()
            time.sleep(open_files.PAUSE)
        raise
    if not open_files.is_room_for(sock, open_files.RESERVED // 2):
        sock.close()
        raise OSError(errno.EMFILE, "too many open files")
    return sock, address


def accept_all() -> None:
    """Makes the node of this process accept connections whatever others do; before it starts."""
    open_files.raise_limit()
    tcpros_base.read_ros_handshake_header = _header_of
    TCPServer.run = _serve
    ThreadingXMLRPCServer.get_request = _get_request_or_pause
    SilenceableXMLRPCRequestHandler.timeout = REQUEST_TIMEOUT
