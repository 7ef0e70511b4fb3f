"""Subscriptions that rospy loses on busy machines, kept.

Subscriptions keep their publishers; rospy loses some.

- Of two lists of a topic's publishers that wait, rospy takes the one that came last. The master's
  answer to a new subscription may be older than its word of a new publisher, and come later.
- A publisher that is told while the connection to it is there is left out, also when that
  connection is about to close because the publisher has closed the topic and opened it again.
- Two threads that connect to one publisher both do, and the second closes what the first receives.
- A connection whose handshake fails stays in the list for ever when the publisher is gone then:
  rospy never connects to it again.

Here waiting lists are joined; threads connect one after the other; a connection that the master
calls off and on again is followed by another; and after a connection that ends otherwise the master
is asked for the publishers.
"""

import functools
import logging
import threading
import time
import weakref
import xmlrpc.client

import rosgraph
import rospy
from rospy.core import is_shutdown_requested
from rospy.impl import tcpros_pubsub
from rospy.impl.masterslave import ROSHandler
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


LASTING = 1.0  # [s] a connection that has stood so long was more than an attempt
_update = RegManager.publisher_update
_told = ROSHandler.publisherUpdate
_connect = ROSHandler._connect_topic
_receive = tcpros_pubsub.robust_connect_subscriber
_reconnecting = Reconnecting()
_locks, _locking = weakref.WeakValueDictionary(), threading.Lock()  # (topic, address) -> lock


def keep():
    """Has all subscriptions of this process keep their publishers; may be called twice.

    starting.init_node calls it; connections that are there already are not looked after.
    """
    RegManager.publisher_update = _join_updates
    ROSHandler.publisherUpdate = _note_update
    ROSHandler._connect_topic = _connect_once
    tcpros_pubsub.robust_connect_subscriber = _receive_and_reconnect


@functools.wraps(_update)
def _join_updates(self, resolved_name, uris):
    with self.cond:  # a lock that may be taken twice
        waiting = [uri for topic, known in self.updates if topic == resolved_name for uri in known]
        _update(self, resolved_name, list(dict.fromkeys([*uris, *waiting])))


@functools.wraps(_connect)
def _connect_once(self, topic, pub_uri):
    with _locking:
        lock = _locks.setdefault((topic, pub_uri), threading.Lock())
    with lock:  # then rospy sees the connection of the thread before
        return _connect(self, topic, pub_uri)


@functools.wraps(_told)
def _note_update(self, caller_id, topic, publishers):
    if isinstance(topic, str) and isinstance(publishers, list):
        _mark(topic, [uri for uri in publishers if isinstance(uri, str)])
    return _told(self, caller_id, topic, publishers)


def _mark(topic, publishers):
    """Marks a topic's connections by the master's newest list of its publishers."""
    subscription = get_topic_manager().get_subscriber_impl(topic)
    for connection in subscription.connections if subscription else ():
        listed = connection.endpoint_id in publishers
        if listed and getattr(connection, "called_off", False):
            connection.replaced = time.monotonic()
            _reconnecting.replace(topic, connection.endpoint_id)
        connection.called_off = not listed
    for uri in publishers:
        _reconnecting.forgive(topic, uri)


@functools.wraps(_receive)
def _receive_and_reconnect(conn, dest_addr, dest_port, pub_uri, receive_cb, resolved_topic_name):
    begin = time.monotonic()
    try:
        _receive(conn, dest_addr, dest_port, pub_uri, receive_cb, resolved_topic_name)
    finally:
        subscription = getattr(receive_cb, "__self__", None)
        now = get_topic_manager().get_subscriber_impl(resolved_topic_name)
        if subscription is now is not None and not is_shutdown_requested():
            shook_hands = conn.md5sum is not None
            worked = shook_hands and time.monotonic() - begin > LASTING
            _ended(subscription, conn, pub_uri, worked)


def _ended(subscription, connection, uri, worked):
    """Sees to it that a subscription gets a publisher again whose connection has ended."""
    if connection in subscription.connections:  # rospy has given it up and left it there
        connection.done = False
        connection.close()
    if getattr(connection, "called_off", False):
        return  # the master tells when it comes again
    if getattr(connection, "replaced", None):
        connect(subscription.resolved_name, [uri])
    _reconnecting.lost(subscription.resolved_name, uri, worked)
