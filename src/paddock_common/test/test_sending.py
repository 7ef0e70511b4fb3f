"""flush: it waits for queued messages, and not forever."""

import threading
import time
from types import SimpleNamespace

from paddock_common.waiting import flush


def publisher(*queues):
    """As rospy.Publisher: connections with queues; the first has none, as without queue_size."""
    connections = [SimpleNamespace(), *(SimpleNamespace(_queue=queue) for queue in queues)]
    return SimpleNamespace(impl=SimpleNamespace(connections=connections))


def test_queues_are_waited_for():
    queue = [b"stop"]
    threading.Timer(0.2, queue.clear).start()
    assert flush(publisher([]), publisher([], queue), limit=60.0)
    assert not queue


def test_a_queue_that_does_not_empty_is_abandoned():
    start = time.monotonic()
    assert not flush(publisher([b"stop"]), limit=0.1)
    assert time.monotonic() - start >= 0.1


def test_a_closed_publisher_has_nothing_to_send():
    assert flush(SimpleNamespace(impl=None))
