"""Counting messages on subscribed topics, so that a step can wait for its commands.

TCPROS acknowledges nothing: a publisher cannot know when its message was taken. The counter tells.
"""

import threading
import time

import rospy


class Arrivals:
    """Messages that came on each subscribed topic since the last step that was asked for.

    Where several listen to one topic a message has come when all of them have it.
    """

    def __init__(self):
        self._changed = threading.Condition()
        self._counts = {}  # resolved topic -> {listener: messages since the last take}
        self._clears = 0

    def subscribe(self, topic, kind, callback, **options):
        """A rospy.Subscriber whose messages are counted once `callback` has returned.

        Without a queue size every message of a burst is handed over, so that each one counts.

        Args:
            topic, kind, callback: as for rospy.Subscriber.
            options: of rospy.Subscriber.

        Returns:
            The subscriber; its unregister() ends the counting, too.
        """
        return _Counted(self, topic, kind, callback, options)

    def add(self, topic, listener=None):
        """Count a topic for a listener (any key) from now on."""
        with self._changed:
            self._counts.setdefault(topic, {})[listener] = 0

    def drop(self, topic, listener=None):
        """Forget a listener, with the last one the topic; who waits for it learns it."""
        with self._changed:
            listeners = self._counts.get(topic, {})
            listeners.pop(listener, None)
            if not listeners:
                self._counts.pop(topic, None)
            self._changed.notify_all()

    def report(self, topic, listener=None):
        """A message has come to a listener and lies where the next step finds it."""
        with self._changed:
            if listener in self._counts.get(topic, ()):
                self._counts[topic][listener] += 1
                self._changed.notify_all()

    def clear(self):
        """Count all topics from 0 again: what came is dropped, as by a reset."""
        with self._changed:
            self._clears += 1
            self._start_again()

    def give_back(self, taken):
        """Count again what a take() returned, unless clear() was called since."""
        clears, counts = taken
        with self._changed:
            if clears != self._clears:
                return
            for topic, listeners in counts.items():
                mine = self._counts.get(topic, {})
                for listener in listeners.keys() & mine.keys():
                    mine[listener] += listeners[listener]
            self._changed.notify_all()

    def _start_again(self):
        self._counts = {
            topic: dict.fromkeys(listeners, 0) for topic, listeners in self._counts.items()
        }

    def _came(self, topic):
        return min(self._counts[topic].values())

    def topics(self):
        """Names of all counted topics, sorted."""
        with self._changed:
            return sorted(self._counts)

    def take(self, wanted, timeout, now=time.monotonic):
        """Wait until enough messages came on every topic, then count all topics from 0 again.

        Args:
            wanted: mapping of resolved topic -> least number of messages.
            timeout: wall time [s].

        Returns:
            What was counted, for give_back().

        Raises:
            ValueError: a topic is not subscribed here.
            TimeoutError: too few came; the counts stay, so that a second try may succeed.
        """
        deadline = now() + timeout
        with self._changed:
            while True:
                for topic in wanted:
                    if topic not in self._counts:
                        known = ", ".join(sorted(self._counts)) or "(none)"
                        raise ValueError(
                            f"topic '{topic}' is not subscribed by the simulation; "
                            f"topics are {known}"
                        )
                missing = [topic for topic in wanted if self._came(topic) < wanted[topic]]
                if not missing:
                    taken = self._clears, self._counts
                    self._start_again()
                    return taken
                left = deadline - now()
                if left <= 0 or rospy.is_shutdown():
                    raise TimeoutError(
                        f"not all commands came within {timeout:g} s: "
                        + ", ".join(
                            f"{topic}: {self._came(topic)} of {wanted[topic]}" for topic in missing
                        )
                    )
                self._changed.wait(min(left, 0.5))


class _Counted:
    """A subscriber and its place in the count."""

    def __init__(self, arrivals, topic, kind, callback, options):
        self._arrivals, self._topic = arrivals, rospy.resolve_name(topic)
        arrivals.add(self._topic, self)

        def count(message):
            callback(message)
            arrivals.report(self._topic, self)

        try:
            self._subscriber = rospy.Subscriber(topic, kind, count, **options)
        except BaseException:
            arrivals.drop(self._topic, self)
            raise

    def get_num_connections(self):
        """Number of publishers connected."""
        return self._subscriber.get_num_connections()

    def unregister(self):
        """End the subscription."""
        self._subscriber.unregister()
        self._arrivals.drop(self._topic, self)
