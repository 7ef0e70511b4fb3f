"""Counting messages on subscribed topics, so that a step can wait for its commands.

TCPROS acknowledges nothing: a publisher cannot know when its message was taken. The counter tells.
"""

import threading
import time

import rospy


class Arrivals:
    """Messages that came on each subscribed topic since the last step that was asked for."""

    def __init__(self):
        self._changed = threading.Condition()
        self._counts = {}       # resolved topic -> messages since the last take
        self._users = {}        # resolved topic -> number of subscribers here

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

    def add(self, topic):
        """Count a topic from now on."""
        with self._changed:
            self._users[topic] = self._users.get(topic, 0) + 1
            self._counts.setdefault(topic, 0)

    def drop(self, topic):
        """Forget a topic that one subscriber less listens to; who waits for it learns it."""
        with self._changed:
            self._users[topic] -= 1
            if not self._users[topic]:
                del self._users[topic], self._counts[topic]
            self._changed.notify_all()

    def report(self, topic):
        """A message has come and lies where the next step finds it."""
        with self._changed:
            if topic in self._counts:
                self._counts[topic] += 1
                self._changed.notify_all()

    def topics(self):
        """Names of all counted topics, sorted."""
        with self._changed:
            return sorted(self._counts)

    def take(self, wanted, timeout, now=time.monotonic):
        """Wait until enough messages came on every topic, then count all topics from 0 again.

        Args:
            wanted: mapping of resolved topic -> least number of messages.
            timeout: wall time [s].

        Raises:
            ValueError: a topic is not subscribed here.
            TimeoutError: too few came; the counts stay, so that a second try may succeed.
        """
        deadline = now() + timeout
        with self._changed:
            while True:
                for topic in wanted:
                    if topic not in self._counts:
                        known = ', '.join(sorted(self._counts)) or '(none)'
                        raise ValueError(f"topic '{topic}' is not subscribed by the simulation; "
                                         f'topics are {known}')
                missing = [topic for topic in wanted if self._counts[topic] < wanted[topic]]
                if not missing:
                    self._counts = dict.fromkeys(self._counts, 0)
                    return
                left = deadline - now()
                if left <= 0 or rospy.is_shutdown():
                    raise TimeoutError(f'not all commands came within {timeout:g} s: ' + ', '.join(
                        f'{topic}: {self._counts[topic]} of {wanted[topic]}' for topic in missing))
                self._changed.wait(min(left, 0.5))


class _Counted:
    """A subscriber and its place in the count."""

    def __init__(self, arrivals, topic, kind, callback, options):
        self._arrivals, self._topic = arrivals, rospy.resolve_name(topic)
        arrivals.add(self._topic)

        def count(message):
            callback(message)
            arrivals.report(self._topic)
        self._subscriber = rospy.Subscriber(topic, kind, count, **options)

    def get_num_connections(self):
        """Number of publishers connected."""
        return self._subscriber.get_num_connections()

    def unregister(self):
        """End the subscription."""
        self._subscriber.unregister()
        self._arrivals.drop(self._topic)
