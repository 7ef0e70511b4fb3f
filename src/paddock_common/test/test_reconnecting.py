"""What is asked of the master after a connection has ended, how often, and for what."""

import threading
import time

import pytest
from rospy.impl.registration import RegManager
from rospy.impl.tcpros_base import TCPROSTransport
from rospy.impl.tcpros_pubsub import TCPROSSub
from rospy.topics import _SubscriberImpl
from std_msgs.msg import String

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
        """A connection to a publisher that stands."""
        made = TCPROSTransport(TCPROSSub("/t", String), "/t")
        made.set_endpoint_id(uri)
        self.subscription.add_connection(made)
        return made


@pytest.fixture
def topics(monkeypatch):
    made = Topics()
    for module in (subscriptions, subscriptions):
        monkeypatch.setattr(module, "get_topic_manager", lambda: made)
    monkeypatch.setattr(subscriptions, "DELAYS", (0.01, 0.01, 0.01))
    monkeypatch.setattr(subscriptions, "PATIENCE", 0.2)
    return made


class Master:
    """A master that knows publishers of /t; counts the questions."""

    def __init__(self, *uris):
        self.uris, self.asked, self.connected = uris, 0, []

    def ask(self, topics):
        self.asked += 1
        if self.uris == ("silent",):
            raise ConnectionRefusedError
        return {topic: set(self.uris) for topic in topics}

    def connect(self, topic, uris):
        self.connected.append((topic, uris))


def settled(master, reconnecting_):
    """Waits until nothing is due any more."""
    end = time.monotonic() + LIMIT
    while True:
        before = master.asked
        time.sleep(0.1)
        if not reconnecting_._due and master.asked == before:
            return
        assert time.monotonic() < end


@pytest.mark.parametrize(
    "uris, asked, connected",
    [
        ((), 1, []),  # it is no publisher any more
        ((OTHER,), 1, []),
        ((URI, OTHER), 3, [("/t", [URI, OTHER])] * 3),  # it was killed: in vain
        (("silent",), 3, []),
    ],
)
def test_the_master_is_asked_some_times(topics, uris, asked, connected):
    master = Master(*uris)
    made = subscriptions.Reconnecting(master.ask, master.connect)
    made.lost("/t", URI, worked=True)
    settled(master, made)
    assert (master.asked, master.connected) == (asked, connected)


def test_a_connection_that_fails_again_and_again_is_given_up(topics):
    master = Master(URI)
    made = subscriptions.Reconnecting(master.ask, lambda *_: made.lost("/t", URI, worked=False))
    made.lost("/t", URI, worked=False)
    settled(master, made)
    assert master.asked == 3
    made.lost("/t", URI, worked=False)
    settled(master, made)
    assert master.asked == 3
    made.forgive("/t", URI)  # the master tells of it
    made.lost("/t", URI, worked=False)
    settled(master, made)
    assert master.asked == 6
    made.lost("/t", URI, worked=True)
    settled(master, made)
    assert master.asked == 9


def test_nothing_is_asked_for_what_is_connected_or_not_wanted(topics):
    topics.connect()
    master = Master(URI)
    made = subscriptions.Reconnecting(master.ask, master.connect)
    made.lost("/t", URI, worked=True)
    made.lost("/other", URI, worked=True)
    settled(master, made)
    assert master.asked == 0


def test_many_that_are_lost_together_are_asked_for_together(topics):
    begin, master = threading.Event(), Master()

    def ask(wanted):
        begin.wait(LIMIT)
        return master.ask(wanted)

    made = subscriptions.Reconnecting(ask, master.connect)
    made.lost("/t", "http://first:1/", worked=True)
    end = time.monotonic() + LIMIT
    while made._due:  # the thread asks for the first
        assert time.monotonic() < end
        time.sleep(0.001)
    for number in range(20):
        made.lost("/t", f"http://node:{number}/", worked=True)
    time.sleep(0.1)
    begin.set()
    settled(master, made)
    assert master.asked == 2


@pytest.fixture
def noted(topics, monkeypatch):
    """Connects that were asked for when connections ended; no thread."""
    made = []
    monkeypatch.setattr(subscriptions, "connect", lambda topic, uris: made.append(uris))
    quiet = type("", (), {"replace": made.append, "lost": lambda *a: made.append("lost")})()
    quiet.replace = lambda topic, uri: made.append("replace")
    quiet.forgive = lambda topic, uri: None
    monkeypatch.setattr(subscriptions, "_reconnecting", quiet)
    return made


@pytest.mark.parametrize(
    "lists, expected",
    [
        ([], ["lost"]),  # it ends for no reason that is known
        ([[URI]], ["lost"]),
        ([[]], []),  # it is no publisher any more
        ([[OTHER]], []),
        ([[], [URI]], ["replace", [URI], "lost"]),  # it was, and is again
        ([[], [URI], []], ["replace"]),
    ],
)
def test_what_the_master_has_told_says_what_an_end_means(topics, noted, lists, expected):
    connection = topics.connect()
    for publishers in lists:
        subscriptions._mark("/t", publishers)
    connection.close()
    subscriptions._ended(topics.subscription, connection, URI, worked=True)
    assert noted == expected


def test_connection_that_rospy_has_given_up_leaves_the_list(topics, noted):
    connection = topics.connect()
    connection.done = True  # as rospy does, without closing it
    subscriptions._ended(topics.subscription, connection, URI, worked=False)
    assert topics.subscription.connections == []


def test_connection_that_is_replaced_is_closed_after_a_while(topics, monkeypatch):
    master = Master(URI)
    made = subscriptions.Reconnecting(master.ask, master.connect)
    monkeypatch.setattr(subscriptions, "_reconnecting", made)
    connection = topics.connect()
    subscriptions._mark("/t", [])
    subscriptions._mark("/t", [URI])
    assert not connection.done
    settled(master, made)
    assert connection.done
    assert master.connected[0] == ("/t", [URI])


@pytest.mark.parametrize("lists", [([URI], []), ([], [URI]), ([OTHER], [URI]), ([URI], [URI])])
def test_no_list_of_publishers_that_waits_is_forgotten(monkeypatch, lists):
    """rospy takes the last and drops the others of its topic."""
    monkeypatch.setattr(RegManager, "publisher_update", subscriptions._join_updates)
    manager = RegManager(None)
    manager.publisher_update("/other", ["http://three:3/"])
    for uris in lists:
        manager.publisher_update("/t", uris)
    assert sorted(manager.updates[-1][1]) == sorted({uri for uris in lists for uri in uris})


def test_one_publisher_is_connected_to_by_one_thread_at_a_time(monkeypatch):
    within, most = [], []

    def connect(_handler, topic, _uri):
        within.append(topic)
        most.append(len(within))
        time.sleep(0.02)
        within.remove(topic)
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
    assert most == [1] * 5
    assert not subscriptions._locks


@pytest.mark.parametrize(
    "topic, publishers", [(7, []), ("/t", None), ("/t", [3, []]), (None, None)]
)
def test_nonsense_by_the_network_is_rospys_to_answer(topics, noted, monkeypatch, topic, publishers):
    monkeypatch.setattr(subscriptions, "_told", lambda *_: (-1, "ERROR", 0))
    assert subscriptions._note_update(None, "/x", topic, publishers) == (-1, "ERROR", 0)
