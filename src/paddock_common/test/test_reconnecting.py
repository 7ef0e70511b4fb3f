"""Requests to the master after a connection has ended: which, and how often."""

import socket
import threading
import time
from types import SimpleNamespace

import pytest
from rospy.impl.masterslave import ROSHandler
from rospy.impl.registration import RegManager
from rospy.impl.tcpros_base import TCPROSTransport
from rospy.impl.tcpros_pubsub import TCPROSSub
from rospy.topics import _SubscriberImpl
from std_msgs.msg import String
from testing import wait_for

from paddock_common import subscriptions

LIMIT = 60.0  # [s]
URI, OTHER = "http://one:1/", "http://two:2/"


class Topics:
    """A topic manager with one subscription, to /t."""

    def __init__(self):
        self.subscription = _SubscriberImpl("/t", String)

    def get_subscriber_impl(self, topic):
        return self.subscription if topic == "/t" else None

    def connect(self, uri=URI):
        """Returns an established connection to a publisher."""
        made = TCPROSTransport(TCPROSSub("/t", String), "/t")
        made.set_endpoint_id(uri)
        self.subscription.add_connection(made)
        return made


@pytest.fixture
def topics(monkeypatch):
    made = Topics()
    monkeypatch.setattr(subscriptions, "get_topic_manager", lambda: made)
    monkeypatch.setattr(subscriptions, "DELAYS", (0.01, 0.01, 0.01))
    monkeypatch.setattr(subscriptions, "DRAIN_TIMEOUT", 0.2)
    return made


class Master:
    """A master that knows publishers of /t; counts the requests."""

    def __init__(self, *uris):
        self.uris, self.requests, self.connected = uris, 0, []

    def request(self, topics):
        self.requests += 1
        if self.uris == ("unresponsive",):
            raise ConnectionRefusedError
        return {topic: set(self.uris) for topic in topics}

    def connect(self, topic, uris):
        self.connected.append((topic, uris))


def wait_until_idle(master, reconnecting_):
    """Waits until no request is due."""
    end = time.monotonic() + LIMIT
    while True:
        before = master.requests
        time.sleep(0.3)  # it may be between two of its steps
        if not reconnecting_._due and master.requests == before:
            return
        assert time.monotonic() < end


@pytest.mark.parametrize(
    "uris, requests, connected",
    [
        ((), 1, []),  # it is no longer a publisher
        ((OTHER,), 1, []),
        ((URI, OTHER), 3, [("/t", [URI, OTHER])] * 3),  # it was killed: no success
        (("unresponsive",), 3, []),
    ],
)
def test_the_number_of_requests_is_limited(topics, uris, requests, connected):
    master = Master(*uris)
    made = subscriptions.Reconnecting(master.request, master.connect)
    made.connection_ended("/t", URI, worked=True)
    wait_until_idle(master, made)
    assert (master.requests, master.connected) == (requests, connected)


def test_a_master_that_does_not_respond_blocks_no_thread(topics, monkeypatch):
    monkeypatch.setattr(subscriptions, "RESPONSE_TIMEOUT", 0.1)
    made = subscriptions.Reconnecting()
    with socket.create_server(("127.0.0.1", 0)) as server:  # accepts and never responds
        server.settimeout(LIMIT)
        monkeypatch.setenv("ROS_MASTER_URI", f"http://127.0.0.1:{server.getsockname()[1]}")
        made.connection_ended("/t", URI, worked=True)
        requests = [server.accept()[0] for _ in subscriptions.DELAYS]
    for request in requests:
        request.close()


def test_a_connection_that_fails_again_and_again_is_abandoned(topics):
    master = Master(URI)
    made = subscriptions.Reconnecting(
        master.request, lambda *_: made.connection_ended("/t", URI, worked=False)
    )
    made.connection_ended("/t", URI, worked=False)
    wait_until_idle(master, made)
    assert master.requests == 3
    made.connection_ended("/t", URI, worked=False)
    wait_until_idle(master, made)
    assert master.requests == 3
    made.reset_attempts("/t", URI)  # the master sends an update about it
    made.connection_ended("/t", URI, worked=False)
    wait_until_idle(master, made)
    assert master.requests == 6
    made.connection_ended("/t", URI, worked=True)
    wait_until_idle(master, made)
    assert master.requests == 9


def test_no_request_for_connected_or_unknown_topics(topics):
    topics.connect()
    master = Master(URI)
    made = subscriptions.Reconnecting(master.request, master.connect)
    made.connection_ended("/t", URI, worked=True)
    made.connection_ended("/other", URI, worked=True)
    wait_until_idle(master, made)
    assert master.requests == 0


def test_connections_that_end_together_make_one_request(topics):
    start, master = threading.Event(), Master()

    def request(topics):
        start.wait(LIMIT)
        return master.request(topics)

    made = subscriptions.Reconnecting(request, master.connect)
    made.connection_ended("/t", "http://first:1/", worked=True)
    wait_for(lambda: not made._due, "the first request")
    for number in range(20):
        made.connection_ended("/t", f"http://node:{number}/", worked=True)
    time.sleep(0.1)
    start.set()
    wait_until_idle(master, made)
    assert master.requests == 2


@pytest.fixture
def calls(topics, monkeypatch):
    """Calls that were made when connections ended; no thread."""
    made = []
    monkeypatch.setattr(subscriptions, "connect", lambda topic, uris: made.append(uris))
    fake = SimpleNamespace(
        connection_ended=lambda *_: made.append("ended"),
        replace=lambda *_: made.append("replace"),
        reset_attempts=lambda *_: None,
    )
    monkeypatch.setattr(subscriptions, "_reconnecting", fake)
    return made


@pytest.mark.parametrize(
    "lists, expected",
    [
        ([], ["ended"]),  # it ends for an unknown reason
        ([[URI]], ["ended"]),
        ([[]], []),  # it is no longer a publisher
        ([[OTHER]], []),
        ([[], [URI]], ["replace", [URI], "ended"]),  # it was, and is again
        ([[], [URI], []], ["replace"]),
    ],
)
def test_the_masters_updates_decide_on_reconnecting(topics, calls, lists, expected):
    connection = topics.connect()
    for publishers in lists:
        subscriptions._update_connections("/t", publishers)
    connection.close()
    subscriptions._handle_end(topics.subscription, connection, URI, worked=True)
    assert calls == expected


def test_connection_that_rospy_has_abandoned_leaves_the_list(topics, calls):
    connection = topics.connect()
    connection.done = True  # as rospy does, without closing it
    subscriptions._handle_end(topics.subscription, connection, URI, worked=False)
    assert topics.subscription.connections == []


def test_connection_that_is_replaced_is_closed_after_a_while(topics, monkeypatch):
    master = Master(URI)
    made = subscriptions.Reconnecting(master.request, master.connect)
    monkeypatch.setattr(subscriptions, "_reconnecting", made)
    connection = topics.connect()
    subscriptions._update_connections("/t", [])
    subscriptions._update_connections("/t", [URI])
    assert not connection.done
    wait_until_idle(master, made)
    assert connection.done
    assert master.connected[0] == ("/t", [URI])


@pytest.mark.parametrize("lists", [([URI], []), ([], [URI]), ([OTHER], [URI]), ([URI], [URI])])
def test_no_pending_list_of_publishers_is_dropped(monkeypatch, lists):
    """rospy uses the last and drops the others of its topic."""
    monkeypatch.setattr(RegManager, "publisher_update", subscriptions._join_updates)
    manager = RegManager(None)
    manager.publisher_update("/other", ["http://three:3/"])
    for uris in lists:
        manager.publisher_update("/t", uris)
    assert sorted(manager.updates[-1][1]) == sorted({uri for uris in lists for uri in uris})


def test_one_publisher_is_connected_to_by_one_thread_at_a_time(monkeypatch):
    active, counts = [], []

    def connect(_handler, topic, _uri):
        active.append(topic)
        counts.append(len(active))
        time.sleep(0.02)
        active.remove(topic)
        return 1, "", 0

    monkeypatch.setattr(subscriptions, "_connect", connect)
    threads = [
        threading.Thread(target=subscriptions._connect_once, args=(None, "/t", URI))
        for _ in range(5)
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(LIMIT)
    assert counts and set(counts) == {1}, "the last one sees what has changed meanwhile"
    assert not subscriptions._connecting


def test_a_publisher_that_does_not_answer_is_tried_as_long_as_it_is_listed(topics, monkeypatch):
    """Each update started a thread for each publisher and each of its lines, and none ended."""
    tries, handler = [], ROSHandler.__new__(ROSHandler)
    handler.reg_man = RegManager(None)

    def connect(_handler, topic, uri):
        for _ in range(5):
            subscriptions._api_while_listed(uri)
            tries.append(uri)
            subscriptions._note_update(handler, "/master", topic, [OTHER])

    monkeypatch.setattr(subscriptions, "_connect", connect)
    assert subscriptions._note_update(handler, "/master", "/t", 2000 * [URI] + [OTHER])[0] == 1
    assert handler.reg_man.updates == [("/t", [URI, OTHER])]
    assert "not listed" in subscriptions._connect_once(handler, "/t", URI)[1]
    assert tries == [URI]


def test_a_new_subscription_is_told_its_publishers_in_place_of_an_older_list(topics, monkeypatch):
    """Of a registration: an older update said that there are none, which ended a second try."""
    monkeypatch.setitem(subscriptions._listed, "/t", set())
    subscriptions._join_updates(RegManager(None), "/t", [URI])
    assert subscriptions._listed["/t"] == {URI}


@pytest.mark.parametrize(
    "topic, publishers", [(7, []), ("/t", None), ("/t", [3, []]), (None, None), ("/t", ["x"])]
)
def test_invalid_updates_are_refused(topics, topic, publishers):
    handler = ROSHandler.__new__(ROSHandler)
    assert subscriptions._note_update(handler, "/x", topic, publishers)[0] == -1
