"""Messages and errors of a node are dropped while rospy closes it; before, they are logged."""

import subprocess
import sys
import threading

import pytest
import rospy
import rospy.core
import testing
from rospy.impl.tcpros_service import ServiceImpl
from rospy.topics import _PublisherImpl, _SubscriberImpl
from std_msgs.msg import String

from paddock_common import nodes

LIMIT = 60.0  # [s]


@pytest.fixture(autouse=True)
def suppressed(monkeypatch):
    """Suppresses errors of the shutdown, in this test only."""
    for owner, name in (
        (_PublisherImpl, "publish"),
        (_SubscriberImpl, "_invoke_callback"),
        (ServiceImpl, "error_handler"),
        (threading, "excepthook"),
        (sys, "excepthook"),
    ):
        monkeypatch.setattr(owner, name, getattr(owner, name))
    monkeypatch.setattr(_PublisherImpl, "publock", None, raising=False)
    nodes.suppress_shutdown_errors()
    nodes.suppress_shutdown_errors()


@pytest.fixture(params=[False, True], ids=["running", "ending"])
def ends(request, monkeypatch):
    """Whether the shutdown was requested; rospy does not report the node as shut down yet."""
    monkeypatch.setattr(rospy.core, "_in_shutdown", request.param)
    assert not rospy.is_shutdown()
    return request.param


@pytest.fixture
def topic():
    """A publisher's topic with one connection that accepts everything."""
    made = _PublisherImpl("/t", String)
    made.connections.append(type("", (), {"write_data": lambda *_: True, "close": lambda *_: None}))
    return made


def close_before(topic):
    topic.close()
    return String()


def close_while_it_checks_connections(topic):
    def has_connections():
        topic.close()
        return True

    topic.has_connections = has_connections
    return String()


def close_while_it_serializes(topic):
    class Closing(String):
        def serialize(self, buffer):
            topic.close()
            super().serialize(buffer)

    return Closing("a")


@pytest.mark.parametrize(
    "close", [close_before, close_while_it_checks_connections, close_while_it_serializes]
)
def test_publishing_to_a_topic_that_is_closed(topic, ends, close):
    message = close(topic)
    if ends:
        assert topic.publish(message) is None
    else:
        with pytest.raises((rospy.ROSException, AttributeError)):
            topic.publish(message)


def test_an_invalid_message_raises_also_during_shutdown(topic, ends):
    with pytest.raises(Exception, match="bytes|str|int"):
        topic.publish(String(data=3))


def test_an_open_topic_still_sends_during_shutdown(topic, monkeypatch):
    """As shutdown hooks do: the last zero command."""
    sent = []
    topic.connections[0].write_data = sent.append
    monkeypatch.setattr(rospy.core, "_in_shutdown", True)
    topic.publish(String("stop"))
    assert len(sent) == 1


def test_a_waiting_publish_continues_when_the_topic_is_closed(topic):
    topic.acquire()
    waits, done = threading.Event(), threading.Event()

    def publish():
        waits.set()
        topic.acquire()
        topic.release()
        done.set()

    threading.Thread(target=publish, daemon=True).start()
    assert waits.wait(LIMIT)
    topic.close()
    assert not done.is_set()
    topic.release()
    assert done.wait(LIMIT)


def test_a_callback_that_fails(ends, caplog):
    subscription = _SubscriberImpl("/t", String)
    received = []

    def fail(message, *arguments):
        received.append((message, *arguments))
        raise KeyError("wheel")

    subscription._invoke_callback("a", fail, None)
    subscription._invoke_callback("b", fail, 7)
    assert received == [("a",), ("b", 7)]
    logged = [record for record in caplog.records if record.name == "rosout"]
    assert len(logged) == (0 if ends else 2)
    if not ends:
        assert f"bad callback: {fail!r}" in logged[0].getMessage()
        assert "KeyError: 'wheel'" in logged[0].getMessage()
    else:
        assert [record.name for record in caplog.records] == ["rospy.closing"] * 2


def test_a_service_that_fails(ends, caplog):
    try:
        raise KeyError("wheel")
    except KeyError as error:
        ServiceImpl.error_handler(None, error, *sys.exc_info())
    logged = [record for record in caplog.records if record.name == "rosout"]
    assert len(logged) == (0 if ends else 1)


def test_a_thread_that_fails(ends, monkeypatch):
    printed = []
    monkeypatch.setattr(threading, "excepthook", nodes._Hook(printed.append, Exception))

    def fail():
        raise KeyError("wheel")

    thread = threading.Thread(target=fail)
    thread.start()
    thread.join(LIMIT)
    assert [args.exc_type for args in printed] == ([] if ends else [KeyError])


@pytest.mark.parametrize(
    "error, always_printed",
    [(rospy.ROSInterruptException, False), (rospy.ServiceException, False), (KeyError, True)],
)
def test_a_main_thread_that_fails(ends, error, always_printed):
    printed = []
    hook = nodes._Hook(lambda *args: printed.append(args[0]), nodes.INTERRUPTIONS)
    hook(error, error("a"), None)
    assert printed == ([error] if always_printed or not ends else [])


# All of it in a separate process: timer, thread and main loop during shutdown.
NODE = """
import threading, time
import rospy, rospy.core
from paddock_common import nodes
from std_msgs.msg import String
nodes.suppress_shutdown_errors()
rospy.core.set_initialized(True)
rospy.rostime.set_rostime_initialized(True)
topic = rospy.Publisher("/t", String, queue_size=1)
def publish(_event=None):
    topic.publish("a")
    print("published", flush=True)
def close(_reason):
    print("closing", flush=True)
    rospy.impl.registration.get_topic_manager().close_all()
    for _ in range(20):
        publish()
        time.sleep(0.02)
rospy.core.add_preshutdown_hook(close)
rospy.Timer(rospy.Duration(0.01), publish)
threading.Timer(0.3, lambda: rospy.signal_shutdown("test")).start()
while not rospy.is_shutdown():
    publish()
    time.sleep(0.01)
raise rospy.ROSInterruptException("in the main loop")
"""


def test_a_node_prints_nothing_while_its_topics_are_closed():
    done = subprocess.run(
        [sys.executable, "-c", NODE], capture_output=True, text=True, timeout=LIMIT
    )
    assert done.stderr == ""
    assert done.stdout.split("closing")[1].count("published") >= 20


READER = """
import contextlib, types
import rospy
from paddock_common import nodes
nodes.init_node("reader")
assert rospy.get_param_cached("/limit") == 1.5
told = lambda *words: print(*words, rospy.get_node_uri(), flush=True)
nodes.proxy = lambda *_: contextlib.nullcontext(types.SimpleNamespace(unsubscribeParam=told))
"""


def test_a_node_that_ends_unsubscribes_its_parameters():
    with testing.ros_master() as environment:
        subprocess.run(["rosparam", "set", "/limit", "1.5"], env=environment, check=True)
        done = subprocess.run(
            [sys.executable, "-c", READER],
            env=environment,
            capture_output=True,
            text=True,
            timeout=LIMIT,
        )
    name, address, parameter, own = done.stdout.split()
    assert (name, address, parameter) == ("/reader", own, "/limit") and done.stderr == ""
