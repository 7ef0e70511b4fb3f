"""Messages are counted per topic, from one step to the next."""

import threading
import time

import pytest
from bullet_bridge.loop import received as module
from bullet_bridge.loop.received import ReceivedCounts


class FakeSubscriber:
    def __init__(self, name, kind, call, **options):
        self.name, self.kind, self.call, self.options, self.closed = name, kind, call, options, 0

    def unregister(self):
        self.closed += 1


@pytest.fixture(name="received")
def _received(monkeypatch):
    monkeypatch.setattr(module.rospy, "Subscriber", FakeSubscriber)
    monkeypatch.setattr(module.rospy, "is_shutdown", lambda: False)
    return ReceivedCounts()


def fake(counted):
    return counted._subscriber


def test_counts_are_per_topic_and_start_again_when_taken(received):
    one = received.subscribe("/one", str, lambda _: None)
    received.subscribe("/two", str, lambda _: None)
    for _ in range(3):
        fake(one).call("x")
    received.take({"/one": 3, "/two": 0}, 0.0)
    with pytest.raises(TimeoutError, match="/one: 0 of 1"):
        received.take({"/one": 1}, 0.0)


def test_a_failed_wait_names_what_is_missing_and_keeps_the_counts(received):
    one = received.subscribe("/one", str, lambda _: None)
    received.subscribe("/two", str, lambda _: None)
    fake(one).call("x")
    with pytest.raises(TimeoutError) as error:
        received.take({"/one": 2, "/two": 1}, 0.01)
    assert str(error.value) == "not all commands came within 0.01 s: /one: 1 of 2, /two: 0 of 1"
    fake(one).call("x")
    received.take({"/one": 2}, 0.0)


def test_a_message_counts_after_its_callback(received):
    messages = []

    def callback(message):
        with pytest.raises(TimeoutError):
            received.take({"/one": 1}, 0.0)
        messages.append(message)

    fake(received.subscribe("/one", str, callback)).call("x")
    received.take({"/one": 1}, 0.0)
    assert messages == ["x"]


def test_no_message_of_a_burst_is_dropped(received):
    assert "queue_size" not in fake(received.subscribe("/one", str, print)).options


def test_waiting_ends_when_the_message_comes(received):
    one = received.subscribe("/one", str, lambda _: None)
    done = []
    waiter = threading.Thread(target=lambda: done.append(received.take({"/one": 2}, 90.0)))
    waiter.start()
    for _ in range(2):
        time.sleep(0.01)
        assert not done
        fake(one).call("x")
    waiter.join(90.0)
    assert len(done) == 1


@pytest.mark.parametrize("requested", ["/none", "one"])
def test_an_unknown_topic_is_an_error_at_once(received, requested):
    received.subscribe("/one", str, lambda _: None)
    with pytest.raises(
        ValueError, match=f"topic '{requested}' is not subscribed .*; topics are /one"
    ):
        received.take({requested: 1}, 90.0)


def test_a_topic_is_known_until_its_last_subscriber_goes(received):
    first, second = (received.subscribe("/one", str, lambda _: None) for _ in range(2))
    first.unregister()
    assert sorted(received._counts) == ["/one"] and fake(first).closed == 1
    second.unregister()
    assert sorted(received._counts) == []
    fake(second).call("late")
    assert sorted(received._counts) == []


def test_waiting_for_a_topic_that_is_unregistered_fails(received):
    one = received.subscribe("/one", str, lambda _: None)
    errors = []

    def wait():
        try:
            received.take({"/one": 1}, 90.0)
        except ValueError as error:
            errors.append(str(error))

    waiter = threading.Thread(target=wait)
    waiter.start()
    time.sleep(0.01)
    one.unregister()
    waiter.join(90.0)
    assert errors and "'/one' is not subscribed" in errors[0]


def test_a_message_to_two_subscribers_counts_once(received):
    first, second = (received.subscribe("/one", str, lambda _: None) for _ in range(2))
    fake(first).call("x")
    with pytest.raises(TimeoutError, match="/one: 0 of 1"):  # the second has not received it yet
        received.take({"/one": 1}, 0.0)
    fake(second).call("x")
    with pytest.raises(TimeoutError, match="/one: 1 of 2"):
        received.take({"/one": 2}, 0.0)
    received.take({"/one": 1}, 0.0)


def test_an_unregistered_subscriber_is_not_waited_for(received):
    first, second = (received.subscribe("/one", str, lambda _: None) for _ in range(2))
    fake(first).call("x")
    second.unregister()
    received.take({"/one": 1}, 0.0)


def test_clear_counts_from_0(received):
    one = received.subscribe("/one", str, lambda _: None)
    fake(one).call("x")
    received.clear()
    with pytest.raises(TimeoutError, match="/one: 0 of 1"):
        received.take({"/one": 1}, 0.0)
    fake(one).call("x")
    received.take({"/one": 1}, 0.0)


def test_restored_counts_count_again_unless_cleared_since(received):
    one = received.subscribe("/one", str, lambda _: None)
    fake(one).call("x")
    taken = received.take({"/one": 1}, 0.0)
    fake(one).call("x")
    received.restore(taken)
    taken = received.take({"/one": 2}, 0.0)
    received.clear()
    received.restore(taken)
    with pytest.raises(TimeoutError, match="/one: 0 of 1"):
        received.take({"/one": 1}, 0.0)


def test_a_topic_that_cannot_be_subscribed_is_not_counted(received, monkeypatch):
    def refuse(*_, **__):
        raise ValueError("bad name")

    monkeypatch.setattr(module.rospy, "Subscriber", refuse)
    with pytest.raises(ValueError):
        received.subscribe("/one", str, lambda _: None)
    assert sorted(received._counts) == []
