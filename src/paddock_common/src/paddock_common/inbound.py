"""Connections from outside: to a node's port for topics and services, and to that for XML-RPC.

rospy reads the header of a connection in the thread that accepts them: one that sends half of it
and no more keeps all others out. Here one thread waits for all headers at once. Each has to be
there HEADER_TIMEOUT after its connection; of more than MAX_WAITING the oldest is closed.

rospy's thread ends when accept() fails at the limit of open files, and nobody can reach the node
any more. Here connections are closed before it is reached, see `open_files`; when others have left,
new ones are accepted again.

rospy stores whatever arrives, up to the 4 GB that a message can tell of itself. Here a connection
is closed when a message tells of more than MAX_MESSAGE or MAX_DATA; an XML-RPC call of more than
MAX_CALL is refused. What a client does wrong, one line in the log tells, with its name: an answer
that it did not wait for, a request that cannot be read.
"""

from __future__ import annotations

import errno
import functools
import io
import logging
import selectors
import socket
import time
from typing import Any

from genpy import DeserializationError
from rosgraph.network import decode_ros_handshake_header
from rosgraph.xmlrpc import SilenceableXMLRPCRequestHandler, ThreadingXMLRPCServer
from rospy.core import is_shutdown
from rospy.exceptions import TransportException, TransportTerminated
from rospy.impl import tcpros_base
from rospy.impl.tcpros_base import TCPROSTransport, TCPROSTransportProtocol, TCPServer
from rospy.impl.tcpros_service import ServiceImpl, convert_return_to_response
from rospy.msg import serialize_message
from rospy.service import ServiceException

from paddock_common import open_files

HEADER_TIMEOUT = 5.0  # [s] wall time for the whole header of a connection
MAX_HEADER = 1 << 20  # [bytes] of a header; "POST" would be 1.4e9
MAX_WAITING = 128  # connections whose headers are not complete
MAX_MESSAGE = 64 << 20  # [bytes] of a message or a request, and ...
MAX_DATA = 1_000_000_000  # ... of one whose data are bytes, as an image; roscpp's limit of each
MAX_CALL = 8 << 20  # [bytes] of an XML-RPC call; Python takes a second for numbers of as many
REPORT_PERIOD = 10.0  # [s] between two lines about one client of a topic or service
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


_do_post = SilenceableXMLRPCRequestHandler.do_POST


@functools.wraps(_do_post)
def _do_short_post(self: Any) -> None:
    size = self.headers.get("content-length", "")
    if size.isdigit() and int(size) <= MAX_CALL:
        _do_post(self)
        return
    self.close_connection = True
    self.send_error(413)
    _report(self.client_address[0], "XML-RPC", f"a call of {size or 'unknown'} bytes is refused")


_read_messages = TCPROSTransportProtocol.read_messages
_receive_once = TCPROSTransport.receive_once


@functools.wraps(_read_messages)
def _read_short_messages(self: Any, buffer: Any, messages: list[Any], sock: Any) -> None:
    _read_messages(self, buffer, messages, sock)
    if buffer.tell() < 4:
        return
    with buffer.getbuffer() as left:  # a message that is not complete
        size = int.from_bytes(left[:4], "little")
    kinds = getattr(self.recv_data_class, "_slot_types", ["int8[]"])  # of AnyMsg: any
    limit = MAX_DATA if any("int8[]" in kind for kind in kinds) else MAX_MESSAGE
    if size > limit:
        raise _Refused(f"a message of {size} bytes is refused, {limit} are possible")


class _Refused(TransportTerminated):
    """A message that is not read; the connection is closed."""


@functools.wraps(_receive_once)
def _receive_and_report(self: Any) -> Any:
    try:
        return _receive_once(self)
    except _Refused as error:
        _report(_client(self), self.name, str(error))
        raise
    except TransportException as error:  # also of a connection that this node has closed
        if isinstance(error.__context__, DeserializationError):
            _report(_client(self), self.name, f"its message cannot be read: {error.__context__}")
        raise


def _client(transport: Any) -> str:
    name = (transport.header or {}).get("callerid") or str(transport.endpoint_id)
    return "".join(sign if sign.isprintable() else "?" for sign in name[:200])


_reported: dict[tuple[str, str], float] = {}  # when the next line is due [s]


def _report(client: str, name: str, text: str) -> None:
    """Logs what another node at a topic or service has done, now and then."""
    now = time.monotonic()
    if now < _reported.get((client, name), 0.0):
        return
    if len(_reported) >= 1000:
        _reported.clear()
    _reported[client, name] = now + REPORT_PERIOD
    logging.getLogger("rosout").warning("%s, at %s: %s", client, name, text)


def _serve_client(self: Any, transport: Any, header: Any) -> None:
    """The thread of a service's client."""
    persistent = header.get("persistent", "").lower() in ("1", "true")
    try:
        while header.get("probe") != "1" and not is_shutdown():
            for request in transport.receive_once():
                _answer(self, transport, request)
            if not persistent:
                return
    except (OSError, TransportException) as error:
        has_left = isinstance(error, (OSError, TransportTerminated))
        if has_left and not persistent and not isinstance(error, _Refused):  # else it is reported
            _report(_client(transport), self.resolved_name, f"it left within a call ({error})")
    finally:
        transport.close()


def _answer(service: Any, transport: Any, request: Any) -> None:
    """Answers one request.

    Raises:
        OSError, TransportTerminated: The client has left.
    """
    data = io.BytesIO(b"\1")  # it has succeeded
    data.seek(1)
    try:
        answer = service.handler(request)
        response = convert_return_to_response(answer, service.response_class)
        service.seq += 1
        serialize_message(data, service.seq, response)
    except ServiceException as error:
        service._write_service_error(transport, f"service cannot process request: {error}")
        return
    except Exception as error:
        service.error_handler(error, type(error), error, error.__traceback__)
        service._write_service_error(transport, f"error processing request: {error}")
        return
    transport.write_data(data.getvalue())


def accept_all() -> None:
    """Makes the node of this process accept connections whatever others do; before it starts."""
    open_files.raise_limit()
    TCPROSTransportProtocol.read_messages = _read_short_messages
    TCPROSTransport.receive_once = _receive_and_report
    ServiceImpl.handle = _serve_client
    SilenceableXMLRPCRequestHandler.do_POST = _do_short_post
    tcpros_base.read_ros_handshake_header = _header_of
    TCPServer.run = _serve
    ThreadingXMLRPCServer.get_request = _get_request_or_pause
    SilenceableXMLRPCRequestHandler.timeout = REQUEST_TIMEOUT
