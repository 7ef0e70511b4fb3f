"""Direct sending: nothing lost while a subscriber keeps up, no blocking if it does not."""

import socket
import threading
import time

import pytest
from bullet_bridge.transport import publishing
from bullet_bridge.transport.connections import DirectConnection
from rospy.exceptions import TransportTerminated
from testing import wait_for

SIZE = 50000  # [B]


class Transport:
    """Fake of a rospy transport, over a pair of connected sockets."""

    def __init__(self):
        server = socket.create_server(("127.0.0.1", 0))
        self.far = socket.create_connection(server.getsockname())
        self.socket = server.accept()[0]
        server.close()
        self.socket.settimeout(60.0)  # as rospy's default
        self.done, self.callback, self.endpoint_id = False, None, "/far"
        self.stat_bytes = self.stat_num_msg = 0

    def set_cleanup_callback(self, callback):
        self.callback = callback

    def close(self):
        if not self.done:
            self.done = True
            self.socket.close()
            self.callback(self)

    def read(self, size):
        self.far.settimeout(90.0)
        got = bytearray()
        while len(got) < size:
            piece = self.far.recv(size - len(got))
            if not piece:
                break
            got += piece
        return bytes(got)


@pytest.fixture(name="transport")
def _transport():
    transport = Transport()
    yield transport
    transport.far.close()
    if transport.callback:
        transport.close()


def message(number, size=SIZE):
    """Bytes from which the number can be read."""
    return bytes([number % 256]) * size


def senders():
    """The threads that send to slow subscribers."""
    return [each for each in threading.enumerate() if each.name == "slow-subscriber"]


def test_small_messages_are_sent_at_once_without_a_thread(transport):
    wait_for(lambda: not senders(), "the end of the last test's thread")
    connection = DirectConnection(transport, 10)
    for number in range(100):
        assert connection.write_data(message(number, 100))
    assert transport.read(10000) == b"".join(message(n, 100) for n in range(100))
    assert not senders()
    assert (transport.stat_bytes, transport.stat_num_msg) == (10000, 100)
    assert transport.socket.getsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY)


def test_other_attributes_are_those_of_the_transport(transport):
    assert DirectConnection(transport, 10).endpoint_id == "/far"


def test_a_large_message_arrives_complete(transport):
    connection = DirectConnection(transport, 10)
    data = bytes(range(256)) * 100000
    connection.write_data(data)
    connection.write_data(b"end")
    assert transport.read(len(data) + 3) == data + b"end"


def test_a_stalled_subscriber_loses_the_oldest_messages_and_does_not_block(transport):
    connection = DirectConnection(transport, 5)
    start = time.monotonic()
    for number in range(1000):
        connection.write_data(message(number))
    assert time.monotonic() - start < 50.0  # with the subscriber it would never end
    got = b""
    transport.far.settimeout(1.0)
    try:
        while True:
            piece = transport.far.recv(1 << 20)
            got += piece
    except socket.timeout:
        pass
    assert len(got) % SIZE == 0 and len(got) < 1000 * SIZE
    pieces = [got[i : i + SIZE] for i in range(0, len(got), SIZE)]
    assert all(piece == piece[:1] * SIZE for piece in pieces), "messages are complete"
    numbers = [piece[0] for piece in pieces]
    assert numbers[0] == 0 and numbers[-5:] == [n % 256 for n in range(995, 1000)]
    connection.write_data(b"next")
    assert transport.read(4) == b"next"


def test_in_lockstep_a_slow_subscriber_gets_all_messages(transport):
    connection = DirectConnection(transport, None)
    writer = threading.Thread(
        target=lambda: [connection.write_data(message(number)) for number in range(400)]
    )
    writer.start()
    writer.join(0.5)
    assert writer.is_alive(), "it waits for the subscriber"
    assert transport.read(400 * SIZE) == b"".join(message(n) for n in range(400))
    writer.join(90.0)
    assert not writer.is_alive()


@pytest.mark.parametrize("limit", [10, None])
def test_a_closed_subscriber_ends_the_connection(transport, limit):
    connection = DirectConnection(transport, limit)
    transport.far.close()
    with pytest.raises(TransportTerminated):
        for number in range(1000):
            connection.write_data(message(number))
            time.sleep(0.001)
    assert transport.done
    with pytest.raises(TransportTerminated):
        connection.write_data(b"x")


def test_the_thread_of_a_stalled_subscriber_ends_with_it(transport):
    wait_for(lambda: not senders(), "the end of the last test's thread")
    connection = DirectConnection(transport, 5)
    for number in range(200):
        connection.write_data(message(number))
    assert len(senders()) == 1
    transport.far.close()
    wait_for(lambda: not senders(), "the end of the thread")


class Impl:
    """Fake of rospy's topic."""

    closed = False

    def __init__(self):
        self.connections, self.resolved_name = [], "/topic"

    def add_connection(self, connection):
        self.connections.append(connection)
        return True


@pytest.mark.parametrize("lockstep, limit", [(True, None), (False, publishing.QUEUE_SIZE)])
def test_publishers_send_directly(monkeypatch, transport, lockstep, limit):
    impl = Impl()

    class Publisher:
        def __init__(self, *_, **options):
            assert options["queue_size"] is None
            self.impl = impl

    monkeypatch.setattr(publishing.rospy, "Publisher", Publisher)
    monkeypatch.setattr(publishing, "_in_lockstep", lockstep)
    publishing.publisher("/topic", str)
    publishing.publisher("/topic", str)
    assert impl.add_connection(transport)
    [connection] = impl.connections
    assert isinstance(connection, DirectConnection) and connection._limit == limit
    assert connection._connection is transport, "not wrapped twice"
