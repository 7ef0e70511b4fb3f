"""Counting messages on subscribed topics, so that a step can wait for its commands.

TCPROS has no acknowledgement: a publisher cannot know when its message was received. The count on
the subscriber's side can be waited for.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Mapping
from typing import Any, Dict, Tuple

import rospy

Taken = Tuple[int, Dict[str, Dict[Any, int]]]  # number of clears, the counts


class ReceivedCounts:
    """Messages received on each subscribed topic since the last requested step.

    A message on a topic with several subscribers counts when all of them have received it.
    """

    def __init__(self) -> None:
        self._changed = threading.Condition()
        # resolved topic -> {subscriber: messages since the last take}
        self._counts: dict[str, dict[Any, int]] = {}
        self._clears = 0

    def subscribe(
        self, topic: str, message_type: type, callback: Callable[[Any], None], **options: Any
    ) -> Counted:
        """A rospy.Subscriber whose messages are counted once `callback` has returned.

        It has no queue size, so that no message of a burst is dropped and each one counts.

        Args:
            topic, message_type, callback: as for rospy.Subscriber.
            options: of rospy.Subscriber.

        Returns:
            The subscriber; its unregister() also ends the counting.
        """
        return Counted(self, topic, message_type, callback, options)

    def add(self, topic: str, subscriber: Any = None) -> None:
        """Count a topic's messages for a subscriber (any key) from now on."""
        with self._changed:
            self._counts.setdefault(topic, {})[subscriber] = 0

    def remove(self, topic: str, subscriber: Any = None) -> None:
        """Remove a subscriber, and a topic without one; a take() that waits for it then fails."""
        with self._changed:
            subscribers = self._counts.get(topic, {})
            subscribers.pop(subscriber, None)
            if not subscribers:
                self._counts.pop(topic, None)
            self._changed.notify_all()

    def count(self, topic: str, subscriber: Any = None) -> None:
        """Count a message that a subscriber has processed: the next step uses it."""
        with self._changed:
            if subscriber in self._counts.get(topic, ()):
                self._counts[topic][subscriber] += 1
                self._changed.notify_all()

    def clear(self) -> None:
        """Count all topics from 0 again: a reset dropped the messages."""
        with self._changed:
            self._clears += 1
            self._start_again()

    def restore(self, taken: Taken) -> None:
        """Restore the counts that a take() returned, unless clear() was called since."""
        clears, counts = taken
        with self._changed:
            if clears != self._clears:
                return
            for topic, subscribers in counts.items():
                current = self._counts.get(topic, {})
                for subscriber in subscribers.keys() & current.keys():
                    current[subscriber] += subscribers[subscriber]
            self._changed.notify_all()

    def _start_again(self) -> None:
        self._counts = {
            topic: dict.fromkeys(subscribers, 0) for topic, subscribers in self._counts.items()
        }

    def _received(self, topic: str) -> int:
        return min(self._counts[topic].values())

    def take(
        self, required: Mapping[str, int], timeout: float, now: Callable[[], float] = time.monotonic
    ) -> Taken:
        """Wait until every topic has enough messages, then count all topics from 0 again.

        Args:
            required: resolved topic -> minimum number of messages.
            timeout: wall time [s].

        Returns:
            The counts, for restore().

        Raises:
            ValueError: a topic is not subscribed here.
            TimeoutError: too few messages; the counts are unchanged, and another call may succeed.
        """
        deadline = now() + timeout
        with self._changed:
            while True:
                for topic in required:
                    if topic not in self._counts:
                        known = ", ".join(sorted(self._counts)) or "(none)"
                        raise ValueError(
                            f"topic '{topic}' is not subscribed by the simulation; "
                            f"topics are {known}"
                        )
                missing = [topic for topic in required if self._received(topic) < required[topic]]
                if not missing:
                    taken = self._clears, self._counts
                    self._start_again()
                    return taken
                left = deadline - now()
                if left <= 0 or rospy.is_shutdown():
                    raise TimeoutError(
                        f"not all commands came within {timeout:g} s: "
                        + ", ".join(
                            f"{topic}: {self._received(topic)} of {required[topic]}"
                            for topic in missing
                        )
                    )
                self._changed.wait(min(left, 0.5))


class Counted:
    """A rospy.Subscriber whose messages are counted; `topic` is its resolved name."""

    def __init__(
        self,
        counts: ReceivedCounts,
        topic: str,
        message_type: type,
        callback: Callable[[Any], None],
        options: dict[str, Any],
    ) -> None:
        self._counts, self.topic = counts, rospy.resolve_name(topic)
        counts.add(self.topic, self)

        def counted(message: Any) -> None:
            callback(message)
            counts.count(self.topic, self)

        try:
            self._subscriber = rospy.Subscriber(topic, message_type, counted, **options)
        except BaseException:
            counts.remove(self.topic, self)
            raise

    def get_num_connections(self) -> int:
        return self._subscriber.get_num_connections()

    def unregister(self) -> None:
        self._subscriber.unregister()
        self._counts.remove(self.topic, self)
