"""The relay: order, slow and failing subscribers, and the end of either process."""

import os
import random
import signal
import socket
import struct
import textwrap
import threading
import time
from types import SimpleNamespace

import pytest
from bullet_bridge.transport import publishing
from bullet_bridge.transport import relay as module
from bullet_bridge.transport.connections import DirectConnection
from bullet_bridge.transport.relay import Relay, RelayedConnection
from bullet_bridge.transport.relay_process import Subscriber
from rospy.exceptions import TransportTerminated
from test_direct import SIZE, Impl, Transport, message
from testing import pid_from_killed, wait_ended, wait_for

DEADLINE = 90.0  # [s]
NUMBERED = struct.Struct("<II")  # number of a message, bytes that follow


@pytest.fixture(name="failures")
def _failures():
    return []


@pytest.fixture(name="relay", params=[False, True], ids=["blocking", "polling"])
def _relay(failures, request, monkeypatch):
    monkeypatch.setattr(module, "TIMEOUT", DEADLINE)  # its start, on a busy machine, is in it
    relay = Relay(failures.append, lambda: failures.append("reconnected"))
    relay.set_polling(request.param)
    yield relay
    relay.close()
    assert relay.process.returncode is not None


@pytest.fixture(name="transports")
def _transports():
    made = []
    yield lambda: made.append(Transport()) or made[-1]
    for transport in made:
        transport.far.close()
        if transport.callback:
            transport.close()


def numbers_of(data):
    """Numbers of complete messages."""
    assert len(data) % SIZE == 0
    pieces = [data[i : i + SIZE] for i in range(0, len(data), SIZE)]
    assert all(piece == piece[:1] * SIZE for piece in pieces), "messages are complete"
    return [piece[0] for piece in pieces]


def descriptors(relay):
    """Number of files that the process has open."""
    return len(os.listdir(f"/proc/{relay.process.pid}/fd"))


def test_every_subscriber_gets_its_messages_in_order(relay, transports):
    first, second = transports(), transports()
    connections = [relay.add_subscriber(first, 10), relay.add_subscriber(second, 10)]
    for number in range(100):
        for connection in connections[: 1 if number % 2 else 2]:
            assert connection.write_data(message(number, 100))
    assert first.read(10000) == b"".join(message(n, 100) for n in range(100))
    assert second.read(5000) == b"".join(message(n, 100) for n in range(0, 100, 2))
    assert (connections[0].stat_bytes, connections[0].stat_num_msg) == (10000, 100)
    assert connections[0].endpoint_id == "/far"


def test_what_is_read_at_once_arrives_complete_and_in_order(relay, transports):
    first, second = transports(), transports()
    connections = [relay.add_subscriber(each, 10) for each in (first, second)]
    relay.begin_batch()
    for number in range(200):
        for connection, size in zip(connections, (100, 50)):
            connection.write_data(message(number, size))
    relay.end_batch()
    for transport, size in ((first, 100), (second, 50)):
        assert transport.read(200 * size) == b"".join(message(n, size) for n in range(200))


def test_the_end_of_one_subscriber_is_no_end_of_others_that_are_sent_at_once(relay, transports):
    ended, other = transports(), transports()
    connections = [relay.add_subscriber(each, 10) for each in (ended, other)]
    ended.far.close()
    relay.begin_batch()
    for number in range(100):
        for connection in connections:
            connection.write_data(message(number, 100))
    relay.end_batch()
    assert other.read(10000) == b"".join(message(n, 100) for n in range(100))


@pytest.mark.parametrize("limit", [1, 2, 6])
@pytest.mark.parametrize("seed", range(12))
def test_what_is_sent_in_parts_arrives_whole_and_in_order(seed, limit):
    """A subscriber that reads now and then loses messages, but no part of one, and has the last."""
    chance, count, got = random.Random(seed), 0, b""
    near, far = socket.socketpair()
    with near, far:
        near.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, 4096)
        far.setblocking(False)
        subscriber = Subscriber(near, limit)
        for _ in range(chance.randint(5, 60)):
            messages = []
            for _ in range(chance.randint(1, 8)):
                size = chance.choice([12, 50, 700, 3000, 9000])
                messages.append(
                    memoryview(NUMBERED.pack(count, size) + bytes([count % 251]) * size)
                )
                count += 1
            assert subscriber.send(messages) == (not subscriber.queue)
            if chance.random() < 0.5:
                got += received(far, chance.choice([10, 1000, 100000]))
            if chance.random() < 0.4:
                subscriber.flush()
        while not subscriber.flush():
            got += received(far)
        while more := received(far):
            got += more
    start, numbers = 0, []
    while start < len(got):
        number, size = NUMBERED.unpack_from(got, start)
        start += NUMBERED.size + size
        assert got[start - size : start] == bytes([number % 251]) * size
        numbers.append(number)
    assert numbers == sorted(set(numbers))
    assert numbers[-min(limit, count) :] == list(range(count))[-limit:]


def received(sock, size=1 << 20):
    """What a socket has; nothing is b""."""
    try:
        return sock.recv(size)
    except BlockingIOError:
        return b""


def test_after_drain_all_messages_are_sent(relay, transports):
    transport = transports()
    connection = relay.add_subscriber(transport, 10)
    for number in range(50):
        connection.write_data(message(number, 100))
        relay.drain()
        assert transport.read(100) == message(number, 100)
    os.kill(relay.process.pid, signal.SIGKILL)
    relay.drain()  # nothing to wait for


def test_a_batch_is_sent_when_it_ends(relay, transports):
    transport = transports()
    connection = relay.add_subscriber(transport, 10)
    transport.far.settimeout(0.2)
    relay.begin_batch()
    connection.write_data(b"one")
    with pytest.raises(socket.timeout):
        transport.far.recv(1)
    connection.write_data(b"two")
    relay.end_batch()
    assert transport.read(6) == b"onetwo"
    connection.write_data(b"now")
    assert transport.read(3) == b"now"


def test_large_messages_arrive_complete(relay, transports):
    transport = transports()
    connection = relay.add_subscriber(transport, 10)
    data = bytes(range(256)) * 100000
    connection.write_data(data)
    connection.write_data(b"end")
    assert transport.read(len(data) + 3) == data + b"end"


def test_a_stalled_subscriber_loses_the_oldest_messages_and_blocks_no_other(relay, transports):
    stalled, other = transports(), transports()
    slow, quick = relay.add_subscriber(stalled, 5), relay.add_subscriber(other, 5)
    got, reader = [], threading.Thread(target=lambda: got.append(other.read(1000 * SIZE)))
    reader.start()
    for number in range(1000):
        slow.write_data(message(number))
        quick.write_data(message(number))
        if number % 4 == 0:
            time.sleep(0.001)  # the other subscriber can keep up
    quick.write_data(b"x" * 996 * SIZE)  # enough to end a reader that lost some messages
    reader.join(DEADLINE)
    assert not reader.is_alive()
    data, last = b"", b"".join(message(n) for n in range(995, 1000))
    stalled.far.settimeout(DEADLINE)
    while not data.endswith(last):
        data += stalled.far.recv(1 << 20)
    numbers = numbers_of(data)
    assert len(numbers) < 1000 and numbers[0] == 0
    slow.write_data(b"next")
    assert stalled.read(4) == b"next"


def test_a_closed_subscriber_ends_only_its_own_connection(relay, transports):
    gone, stays = transports(), transports()
    connections = [relay.add_subscriber(gone, 10), relay.add_subscriber(stays, 10)]
    connections[1].write_data(b"a")
    assert stays.read(1) == b"a"
    before = descriptors(relay)
    gone.far.close()

    def closed():
        try:
            connections[0].write_data(b"x")
        except TransportTerminated:
            return gone.done
        return False

    wait_for(closed, "the end of the connection")
    connections[1].write_data(b"b")
    assert stays.read(1) == b"b"
    assert descriptors(relay) == before - 1


def test_closing_a_connection_closes_the_socket_in_the_relay(relay, transports):
    transport = transports()
    relay.add_subscriber(transport, 10).write_data(b"last")
    assert transport.read(4) == b"last"
    before = descriptors(relay)
    transport.close()
    transport.far.settimeout(DEADLINE)
    assert transport.far.recv(1) == b"", "no process has the socket open"
    assert descriptors(relay) == before - 1


def test_when_the_relay_dies_its_connections_are_closed(relay, failures, transports):
    transport = transports()
    connection = relay.add_subscriber(transport, 10)
    os.kill(relay.process.pid, signal.SIGKILL)
    wait_for(lambda: failures, "the failure message")
    assert f"pid {relay.process.pid}" in failures[0] and "sends directly" in failures[0]
    assert transport.done and not relay.alive
    wait_for(lambda: failures[1:] == ["reconnected"], "the reconnection")
    with pytest.raises(TransportTerminated):
        connection.write_data(b"x")
    relay.put(b"harmless")
    assert relay.add_subscriber(transports(), 10) is None


def test_a_relay_that_hangs_is_killed(relay, failures, transports, monkeypatch):
    monkeypatch.setattr(module, "TIMEOUT", 0.3)
    transport = transports()
    connection = relay.add_subscriber(transport, 10)
    os.kill(relay.process.pid, signal.SIGSTOP)
    try:
        for number in range(100):
            connection.write_data(message(number))
    except TransportTerminated:
        pass
    wait_for(lambda: failures, "the failure message")
    assert "read nothing for 0.3 s" in failures[0] and transport.done


def test_a_relay_that_hangs_while_nothing_is_sent_is_killed_by_drain(relay, failures, monkeypatch):
    monkeypatch.setattr(module, "TIMEOUT", 0.3)
    os.kill(relay.process.pid, signal.SIGSTOP)
    begin = time.monotonic()
    relay.drain()
    assert time.monotonic() - begin < DEADLINE and not relay.alive
    wait_for(lambda: failures, "the failure message")
    assert "did not respond for 0.3 s" in failures[0]


def test_a_connection_closes_without_waiting_for_a_sender(relay, transports):
    transport, other = transports(), transports()
    relay.add_subscriber(transport, 10).write_data(b"last")
    assert transport.read(4) == b"last"
    before = descriptors(relay)
    with relay._lock:  # as by a thread that a signal handler interrupted
        closer = threading.Thread(target=transport.close)
        closer.start()
        closer.join(DEADLINE)
        assert not closer.is_alive()
    relay.add_subscriber(other, 10).write_data(b"x")  # the next write passes it to the relay
    assert other.read(1) == b"x" and descriptors(relay) == before


def test_a_flush_within_a_flush_keeps_records_complete(relay, transports, monkeypatch):
    transport, other = transports(), transports()
    connection, _ = relay.add_subscriber(transport, 10), relay.add_subscriber(other, 10)
    original = relay._channel.write

    def interrupted(data):
        if not other.done:
            other.close()  # what rospy's signal handler does
            relay.put(b"")
        original(data)

    monkeypatch.setattr(relay._channel, "write", interrupted)
    connection.write_data(b"entire")
    assert transport.read(6) == b"entire"
    other.far.settimeout(DEADLINE)
    assert other.far.recv(1) == b""


def test_a_topic_unregistered_during_a_connection_closes_it(relay, transports):
    class Unregistered(Impl):
        """Closed in the meantime."""

        closed = True

        def add_connection(self, connection):
            """Fails as rospy's does then."""
            raise TypeError("NoneType")

    impl, transport = Unregistered(), transports()
    publishing.send_directly(SimpleNamespace(impl=impl), 10, relay)
    with pytest.raises(TypeError):
        impl.add_connection(transport)
    transport.far.settimeout(DEADLINE)
    assert transport.far.recv(1) == b"" and transport.done


def test_close_sends_what_is_buffered(failures, transports):
    relay, transport = Relay(failures.append), transports()
    connection = relay.add_subscriber(transport, 10)
    for number in range(20):
        connection.write_data(message(number, 100))
    relay.close()
    assert transport.read(2000) == b"".join(message(n, 100) for n in range(20))
    assert relay.process.returncode == 0 and not failures


def test_sigint_does_not_end_the_relay(relay, transports):
    transport = transports()
    connection = relay.add_subscriber(transport, 10)
    connection.write_data(b"a")
    assert transport.read(1) == b"a"
    os.kill(relay.process.pid, signal.SIGINT)
    connection.write_data(b"b")
    assert transport.read(1) == b"b"


def test_the_relay_ends_with_the_bridge():
    code = textwrap.dedent("""
        import time
        from bullet_bridge.transport.relay import Relay
        print(Relay(print).process.pid, flush=True)
        time.sleep(60)""")
    wait_ended(pid_from_killed(code), DEADLINE)


@pytest.mark.parametrize(
    "relayed, alive, kind",
    [
        (True, True, RelayedConnection),
        (False, True, DirectConnection),
        (True, False, DirectConnection),
    ],
)
def test_publishers_use_the_relay_while_it_is_alive(
    monkeypatch, failures, transports, relayed, alive, kind
):
    impl, relay = Impl(), Relay(failures.append)

    class Publisher:
        def __init__(self, *_, **__):
            self.impl = impl

    monkeypatch.setattr(publishing.rospy, "Publisher", Publisher)
    monkeypatch.setattr(publishing, "_relay", relay)
    if not alive:
        relay.close()
    publishing.publisher("/topic", str, relayed=relayed)
    assert impl.add_connection(transports())
    assert isinstance(impl.connections[0], kind)
    relay.close()
