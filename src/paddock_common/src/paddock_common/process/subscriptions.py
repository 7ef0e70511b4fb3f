"""Subscriptions keep their publishers; rospy loses some.

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
import threading
import time
import weakref

from rospy.core import is_shutdown_requested
from rospy.impl import tcpros_pubsub
from rospy.impl.masterslave import ROSHandler
from rospy.impl.registration import RegManager, get_topic_manager

from paddock_common.process.reconnecting import Reconnecting, connect

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
