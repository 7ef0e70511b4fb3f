"""Asks the master for the publishers of topics whose connection has ended, and connects again."""

import logging
import threading
import time
import xmlrpc.client

import rosgraph
import rospy
from rospy.core import is_shutdown_requested
from rospy.impl.registration import RegManager, get_registration_listeners, get_topic_manager

# [s] before each question about one publisher; after the last nothing is asked until the master
# tells of it. A publisher that was killed stays in the master's list.
DELAYS = (0.1, 0.2, 0.4, 0.8, 1.6, 3.2, 6.4, 12.8)
PATIENCE = 2.0  # [s] for a connection that is replaced to be read to its end
_log = logging.getLogger("rospy.reconnecting")  # has no console


def connect(topic, uris):
    """Has rospy connect a subscription to the publishers that it has no connection to."""
    for listener in list(get_registration_listeners().listeners):
        if isinstance(listener, RegManager):
            listener.publisher_update(topic, uris)


def ask_master(topics):
    """Asks the master for the publishers of topics.

    Returns:
        Dict of topic -> set of their addresses.
    """
    caller = rospy.get_name()
    with xmlrpc.client.ServerProxy(rosgraph.get_master_uri()) as master:
        publishers = dict(master.getSystemState(caller)[2][0])
        names = {name for topic in topics for name in publishers.get(topic, ())}
        found = {name: master.lookupNode(caller, name) for name in names}
    return {
        topic: {found[name][2] for name in publishers.get(topic, ()) if found[name][0] == 1}
        for topic in topics
    }


class Reconnecting:
    """Connects subscriptions again to publishers that they have lost.

    A thread does it, which starts with the first loss.

    Args:
        ask: As ask_master.
        connect: As the function of that name.
    """

    def __init__(self, ask=ask_master, connect=connect):
        self._ask, self._connect = ask, connect
        self._changed = threading.Condition()
        self._due = {}  # (topic, address) -> time of the next look [s]
        self._asked = {}  # (topic, address) -> how often in vain
        self._thread = None

    def lost(self, topic, uri, worked):
        """A connection has ended.

        Args:
            topic: Resolved name.
            uri: Address of the publisher.
            worked: Whether it was more than an attempt.
        """
        with self._changed:
            if worked:
                self._asked.pop((topic, uri), None)
            asked = self._asked.get((topic, uri), 0)
            if asked < len(DELAYS):
                self._look((topic, uri), DELAYS[asked])

    def replace(self, topic, uri):
        """The publisher of a connection has gone and come again: another has to follow it."""
        with self._changed:
            self._look((topic, uri), PATIENCE)

    def forgive(self, topic, uri):
        """The master tells of a publisher: what failed before does not count any more."""
        with self._changed:
            self._asked.pop((topic, uri), None)

    def _look(self, key, delay):
        """Sets the next look; with the lock held."""
        self._due[key] = time.monotonic() + delay
        if self._thread is None:
            self._thread = threading.Thread(target=self._run, name="reconnecting", daemon=True)
            self._thread.start()
        self._changed.notify()

    def _run(self):
        while not is_shutdown_requested():
            with self._changed:
                now = time.monotonic()
                keys = [key for key, due in self._due.items() if due <= now]
                if not keys:
                    self._changed.wait(min(self._due.values()) - now if self._due else None)
                    continue
                for key in keys:
                    del self._due[key]
            self._see_to([key for key in keys if self._is_missing(*key)])

    def _is_missing(self, topic, uri):
        """Whether a subscription has no connection to a publisher; closes one that is replaced."""
        subscription = get_topic_manager().get_subscriber_impl(topic)
        if subscription is None or subscription.closed:
            return False
        for connection in subscription.connections:
            if connection.endpoint_id != uri:
                continue
            since = getattr(connection, "replaced", None)
            if since is None or connection.called_off:
                return False
            if time.monotonic() - since < PATIENCE:
                with self._changed:
                    self._look((topic, uri), PATIENCE)
                return False
            connection.close()
        return True

    def _see_to(self, missing):
        """Asks the master once for all that are missing."""
        if not missing:
            return
        try:
            known = self._ask({topic for topic, _ in missing})
        except Exception:  # whatever another process answers; it may do better the next time
            known = None
            _log.warning("the master gives no publishers", exc_info=True)
        for topic, uri in missing:
            with self._changed:
                if known is not None and uri not in known[topic]:
                    self._asked.pop((topic, uri), None)
                    continue
                asked = self._asked[topic, uri] = self._asked.get((topic, uri), 0) + 1
                if asked < len(DELAYS):
                    self._look((topic, uri), DELAYS[asked])
            if known is not None:
                self._connect(topic, sorted(known[topic]))
