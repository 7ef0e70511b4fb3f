"""all_or_none: publishers made in it are unregistered when it fails."""

import threading
from types import SimpleNamespace

import pytest
from bullet_bridge.transport import publishing
from bullet_bridge.transport.publishing import all_or_none, publisher
from bullet_sim.errors import ModelError
from rosgraph_msgs.msg import Clock
from std_msgs.msg import String


class FakePublisher:
    def __init__(self, topic, _kind, **_):
        self.topic, self.closed = topic, 0

    def unregister(self):
        self.closed += 1


@pytest.fixture(autouse=True)
def _fake_publishers(monkeypatch):
    monkeypatch.setattr(publishing.rospy, "Publisher", FakePublisher)
    monkeypatch.setattr(publishing, "send_directly", lambda *_: None)


def test_publishers_stay_when_nothing_fails():
    with all_or_none():
        fake = publisher("/a", str)
    with pytest.raises(ZeroDivisionError), all_or_none():
        raise ZeroDivisionError
    assert fake.closed == 0


def test_a_failure_unregisters_the_publishers_made_in_the_context():
    before, publishers = publisher("/before", str), []
    with pytest.raises(OverflowError), all_or_none():
        publishers.append(publisher("/a", str))
        with all_or_none():
            publishers.append(publisher("/b", str))
        raise OverflowError("too large")
    assert [fake.closed for fake in publishers] == [1, 1]
    assert before.closed == 0 and publisher("/after", str).closed == 0


def test_publishers_of_other_threads_stay():
    publishers = []
    with pytest.raises(ValueError), all_or_none():
        other = threading.Thread(target=lambda: publishers.append(publisher("/a", str)))
        other.start()
        other.join()
        raise ValueError
    assert publishers[0].closed == 0


def test_a_topic_carries_one_type():
    """A second type was sent to the subscribers of the first, as garbage."""
    present = SimpleNamespace(data_class=Clock)
    publishing.check_type("/scan", String, lambda _: None)
    publishing.check_type("/scan", Clock, lambda _: present)
    message = "topic /scan carries rosgraph_msgs/Clock already, and cannot carry std_msgs/String"
    with pytest.raises(ModelError, match=message):
        publishing.check_type("/scan", String, {"/scan": present}.get)
