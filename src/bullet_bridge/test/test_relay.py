"""The relay: one write for all subscribers, nobody held up, nothing left behind."""

import os
import signal
import subprocess
import sys
import textwrap
import threading
import time
from types import SimpleNamespace

import pytest
from bullet_bridge.transport import direct, publishing
from bullet_bridge.transport import relay as module
from bullet_bridge.transport.direct import DirectConnection
from bullet_bridge.transport.relay import Relay, RelayedConnection
from rospy.exceptions import TransportTerminated
from test_direct import SIZE, Impl, Transport, message

DEADLINE = 90.0  # [s]


def wait(condition, what):
    """Until a condition holds."""
    deadline = time.monotonic() + DEADLINE
    while not condition():
        assert time.monotonic() < deadline, f"{what} within {DEADLINE} s"
        time.sleep(0.005)


@pytest.fixture(name="said")
def _said():
    return []


@pytest.fixture(name="relay", params=[False, True], ids=["woken", "in a hurry"])
def _relay(said, request):
    relay = Relay(said.append, lambda: said.append("called back"))
    relay.hurry(request.param)
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
    """Numbers of whole messages."""
    assert len(data) % SIZE == 0
    pieces = [data[i : i + SIZE] for i in range(0, len(data), SIZE)]
    assert all(piece == piece[:1] * SIZE for piece in pieces), "messages are whole"
    return [piece[0] for piece in pieces]


def descriptors(relay):
    """Number of files that the process has open."""
    return len(os.listdir(f"/proc/{relay.process.pid}/fd"))


def test_every_subscriber_gets_its_messages_in_order(relay, transports):
    first, second = transports(), transports()
    connections = [relay.serve(first, 10), relay.serve(second, 10)]
    for number in range(100):
        for connection in connections[: 1 if number % 2 else 2]:
            assert connection.write_data(message(number, 100))
    assert first.read(10000) == b"".join(message(n, 100) for n in range(100))
    assert second.read(5000) == b"".join(message(n, 100) for n in range(0, 100, 2))
    assert (connections[0].stat_bytes, connections[0].stat_num_msg) == (10000, 100)
    assert connections[0].endpoint_id == "/far"


def test_after_catching_up_all_is_sent(relay, transports):
    transport = transports()
    connection = relay.serve(transport, 10)
    transport.far.setblocking(False)
    for number in range(50):
        connection.write_data(message(number, 100))
        relay.catch_up()
        assert transport.far.recv(1000) == message(number, 100)
    os.kill(relay.process.pid, signal.SIGKILL)
    relay.catch_up()  # nothing to wait for


def test_what_is_gathered_goes_when_all_is_there(relay, transports):
    transport = transports()
    connection = relay.serve(transport, 10)
    transport.far.settimeout(0.2)
    relay.gather()
    connection.write_data(b"one")
    with pytest.raises(TimeoutError):
        transport.far.recv(1)
    connection.write_data(b"two")
    relay.release()
    assert transport.read(6) == b"onetwo"
    connection.write_data(b"now")
    assert transport.read(3) == b"now"


def test_big_messages_arrive_whole(relay, transports):
    transport = transports()
    connection = relay.serve(transport, 10)
    data = bytes(range(256)) * 100000
    connection.write_data(data)
    connection.write_data(b"end")
    assert transport.read(len(data) + 3) == data + b"end"


def test_a_stalled_subscriber_holds_nobody_up_and_loses_the_oldest(relay, transports):
    stalled, other = transports(), transports()
    slow, quick = relay.serve(stalled, 5), relay.serve(other, 5)
    got, reader = [], threading.Thread(target=lambda: got.append(other.read(1000 * SIZE)))
    reader.start()
    for number in range(1000):
        slow.write_data(message(number))
        quick.write_data(message(number))
        if number % 4 == 0:
            time.sleep(0.001)  # the other one can follow
    quick.write_data(b"x" * 996 * SIZE)  # enough for a reader that lost a few
    reader.join(DEADLINE)
    assert not reader.is_alive()
    data = b""
    stalled.far.settimeout(1.0)
    try:
        while True:
            data += stalled.far.recv(1 << 20)
    except TimeoutError:
        pass
    numbers = numbers_of(data)
    assert len(numbers) < 1000
    assert numbers[0] == 0 and numbers[-5:] == [n % 256 for n in range(995, 1000)]
    slow.write_data(b"next")
    assert stalled.read(4) == b"next"


def test_a_subscriber_that_is_gone_ends_its_connection_alone(relay, transports):
    gone, stays = transports(), transports()
    connections = [relay.serve(gone, 10), relay.serve(stays, 10)]
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

    wait(closed, "the end of the connection")
    connections[1].write_data(b"b")
    assert stays.read(1) == b"b"
    assert descriptors(relay) == before - 1


def test_a_connection_closed_here_is_closed_there(relay, transports):
    transport = transports()
    relay.serve(transport, 10).write_data(b"last")
    assert transport.read(4) == b"last"
    before = descriptors(relay)
    transport.close()
    transport.far.settimeout(DEADLINE)
    assert transport.far.recv(1) == b"", "nobody has the socket any more"
    assert descriptors(relay) == before - 1


def test_when_it_dies_its_subscribers_are_let_go(relay, said, transports):
    transport = transports()
    connection = relay.serve(transport, 10)
    os.kill(relay.process.pid, signal.SIGKILL)
    wait(lambda: said, "a report")
    assert f"pid {relay.process.pid}" in said[0] and "sends by itself" in said[0]
    assert transport.done and not relay.alive
    wait(lambda: said[1:] == ["called back"], "the call to the subscribers")
    with pytest.raises(TransportTerminated):
        connection.write_data(b"x")
    relay.put(b"harmless")
    assert relay.serve(transports(), 10) is None


def test_when_it_hangs_it_is_given_up(relay, said, transports, monkeypatch):
    monkeypatch.setattr(module, "PATIENCE", 0.3)
    transport = transports()
    connection = relay.serve(transport, 10)
    os.kill(relay.process.pid, signal.SIGSTOP)
    try:
        for number in range(100):
            connection.write_data(message(number))
    except TransportTerminated:
        pass
    wait(lambda: said, "a report")
    assert "took nothing for 0.3 s" in said[0] and transport.done


def test_one_that_hangs_while_nothing_is_sent_is_given_up_when_it_is_waited_for(
    relay, said, monkeypatch
):
    monkeypatch.setattr(module, "PATIENCE", 0.3)
    os.kill(relay.process.pid, signal.SIGSTOP)
    begin = time.monotonic()
    relay.catch_up()
    assert time.monotonic() - begin < DEADLINE and not relay.alive
    wait(lambda: said, "a report")
    assert "did not answer for 0.3 s" in said[0]


def test_a_connection_ends_without_waiting_for_whoever_sends(relay, transports):
    transport, other = transports(), transports()
    relay.serve(transport, 10).write_data(b"last")
    assert transport.read(4) == b"last"
    before = descriptors(relay)
    with relay._lock:  # as by a thread that a signal handler interrupted
        closer = threading.Thread(target=transport.close)
        closer.start()
        closer.join(DEADLINE)
        assert not closer.is_alive()
    relay.serve(other, 10).write_data(b"x")  # the next write tells the relay
    assert other.read(1) == b"x" and descriptors(relay) == before


def test_a_flush_within_a_flush_tears_no_record(relay, transports, monkeypatch):
    transport, other = transports(), transports()
    connection, _ = relay.serve(transport, 10), relay.serve(other, 10)
    plain = relay._write

    def interrupted(data):
        if not other.done:
            other.close()  # what rospy's signal handler does
            relay.put(b"")
        plain(data)

    monkeypatch.setattr(relay, "_write", interrupted)
    connection.write_data(b"whole")
    assert transport.read(5) == b"whole"
    other.far.settimeout(DEADLINE)
    assert other.far.recv(1) == b""


def test_a_topic_that_is_withdrawn_while_somebody_connects_lets_them_go(relay, transports):
    class Withdrawn(Impl):
        """Closed meanwhile."""

        closed = True

        def add_connection(self, connection):
            """As rospy's fails then."""
            raise TypeError("NoneType")

    impl, transport = Withdrawn(), transports()
    direct.send_directly(SimpleNamespace(impl=impl), 10, relay)
    with pytest.raises(TypeError):
        impl.add_connection(transport)
    transport.far.settimeout(DEADLINE)
    assert transport.far.recv(1) == b"" and transport.done


def test_its_end_sends_what_it_has(said, transports):
    relay, transport = Relay(said.append), transports()
    connection = relay.serve(transport, 10)
    for number in range(20):
        connection.write_data(message(number, 100))
    relay.close()
    assert transport.read(2000) == b"".join(message(n, 100) for n in range(20))
    assert relay.process.returncode == 0 and not said


def test_ctrl_c_is_left_to_the_bridge(relay, transports):
    transport = transports()
    connection = relay.serve(transport, 10)
    connection.write_data(b"a")
    assert transport.read(1) == b"a"
    os.kill(relay.process.pid, signal.SIGINT)
    connection.write_data(b"b")
    assert transport.read(1) == b"b"


def test_it_ends_with_the_bridge():
    code = textwrap.dedent("""
        import time
        from bullet_bridge.transport.relay import Relay
        print(Relay(print).process.pid, flush=True)
        time.sleep(60)""")
    parent = subprocess.Popen(
        [sys.executable, "-c", code],
        stdout=subprocess.PIPE,
        text=True,
        env=dict(os.environ, PYTHONPATH=os.pathsep.join(sys.path)),
    )
    with parent:
        pid = int(parent.stdout.readline())
        parent.kill()

    def ended():
        try:
            with open(f"/proc/{pid}/stat", encoding="ascii") as file:
                return file.read().rsplit(")", 1)[1].split()[0] == "Z"
        except FileNotFoundError:
            return True

    wait(ended, "its end")


@pytest.mark.parametrize(
    "relayed, alive, kind",
    [
        (True, True, RelayedConnection),
        (False, True, DirectConnection),
        (True, False, DirectConnection),
    ],
)
def test_publishers_use_it_while_it_lives(monkeypatch, said, transports, relayed, alive, kind):
    impl, relay = Impl(), Relay(said.append)

    class Publisher:
        """Stands in for rospy.Publisher."""

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
