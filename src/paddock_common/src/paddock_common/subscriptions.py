"""Subscriptions that reconnect to publishers which rospy drops on busy machines.

- If two lists of a topic's publishers are pending, rospy uses the one that arrived last. The
  master's response to a new subscription may be older than its update about a new publisher, and
  arrive later.
- An update about a publisher is ignored while there is a connection to it, even when that
  connection is about to close because the publisher has closed the topic and opened it again.
- If two threads connect to one publisher, both do, and the second closes what the first receives.
- A connection whose handshake fails stays in the list forever if the publisher has exited
  meanwhile: rospy never connects to it again.
- Each update starts a thread for each publisher, as often as it has publishers, and one whose
  publisher accepts and does not answer tries for ever.

Here pending lists are merged; one thread connects to a publisher at a time, and tries no longer
when the master lists it no more; a connection whose publisher the master removes and adds again is
followed by a new one; and after a connection that ends otherwise the publishers are requested from
the master.
"""

from __future__ import annotations

import errno
import functools
import logging
import threading
import time
from collections.abc import Callable, Iterable
from typing import Any

import rosgraph
import rospy
from rospy.core import is_shutdown_requested, is_topic
from rospy.impl import masterslave, tcpros_pubsub
from rospy.impl.masterslave import ROSHandler, apivalidate, is_publishers_list
from rospy.impl.registration import RegManager, get_registration_listeners, get_topic_manager

from paddock_common.master import proxy

# [s] before each request about one publisher; after the last there is none until the master sends
# an update about it. A publisher that was killed stays in the master's list.
DELAYS = (0.1, 0.2, 0.4, 0.8, 1.6, 3.2, 6.4, 12.8)
RESPONSE_TIMEOUT = 10.0  # [s] for each response of the master
MAX_PUBLISHERS = 4096  # of a topic that are connected to
DRAIN_TIMEOUT = 2.0  # [s] for reading the rest of a connection that is replaced
_log = logging.getLogger("rospy.reconnecting")  # has no console handler


def connect(topic: str, uris: list[str]) -> None:
    """Makes rospy connect a subscription to the publishers that it has no connection to."""
    for listener in list(get_registration_listeners().listeners):
        if isinstance(listener, RegManager):
            listener.publisher_update(topic, uris)


def request_publishers(topics: Iterable[str]) -> dict[str, set[str]]:
    """Requests the publishers of topics from the master.

    Returns:
        Topic -> addresses of its publishers.

    Raises:
        paddock_common.master.ERRORS: The master did not respond in time, or not with XML-RPC.
    """
    caller = rospy.get_name()
    master: Any
    with proxy(rosgraph.get_master_uri(), RESPONSE_TIMEOUT) as master:
        publishers = dict(master.getSystemState(caller)[2][0])
        names = {name for topic in topics for name in publishers.get(topic, ())}
        nodes = {name: master.lookupNode(caller, name) for name in names}
    return {
        topic: {nodes[name][2] for name in publishers.get(topic, ()) if nodes[name][0] == 1}
        for topic in topics
    }


class Reconnecting:
    """Reconnects subscriptions to publishers whose connections have ended.

    It does so in a thread, which starts with the first ended connection.

    Args:
        request: Like request_publishers.
        connect: Like the function of that name.
    """

    def __init__(
        self,
        request: Callable[[Iterable[str]], dict[str, set[str]]] = request_publishers,
        connect: Callable[[str, list[str]], object] = connect,
    ) -> None:
        self._request, self._connect = request, connect
        self._changed = threading.Condition()
        # Both by (topic, address): time of the next check [s], number of failed attempts.
        self._due: dict[tuple[str, str], float] = {}
        self._attempts: dict[tuple[str, str], int] = {}
        self._thread: threading.Thread | None = None

    def connection_ended(self, topic: str, uri: str, worked: bool) -> None:
        """Schedules a new connection after one has ended.

        Args:
            topic: Resolved name.
            worked: Whether the connection had been established.
        """
        with self._changed:
            if worked:
                self._attempts.pop((topic, uri), None)
            attempts = self._attempts.get((topic, uri), 0)
            if attempts < len(DELAYS):
                self._schedule((topic, uri), DELAYS[attempts])

    def replace(self, topic: str, uri: str) -> None:
        """Schedules a second connection to a publisher that was removed and registered again."""
        with self._changed:
            self._schedule((topic, uri), DRAIN_TIMEOUT)

    def reset_attempts(self, topic: str, uri: str) -> None:
        """Clears the failed attempts: the master has sent an update about the publisher."""
        with self._changed:
            self._attempts.pop((topic, uri), None)

    def _schedule(self, key: tuple[str, str], delay: float) -> None:
        """Sets the time of the next check; with the lock held."""
        self._due[key] = time.monotonic() + delay
        if self._thread is None:
            self._thread = threading.Thread(target=self._run, name="reconnecting", daemon=True)
            self._thread.start()
        self._changed.notify()

    def _run(self) -> None:
        while not is_shutdown_requested():
            with self._changed:
                now = time.monotonic()
                keys = [key for key, due in self._due.items() if due <= now]
                if not keys:
                    self._changed.wait(min(self._due.values()) - now if self._due else None)
                    continue
                for key in keys:
                    del self._due[key]
            self._reconnect([key for key in keys if self._is_missing(*key)])

    def _is_missing(self, topic: str, uri: str) -> bool:
        """Returns whether a connection to a publisher is missing; closes one that is replaced."""
        subscription = get_topic_manager().get_subscriber_impl(topic)
        if subscription is None or subscription.closed:
            return False
        for connection in subscription.connections:
            if connection.endpoint_id != uri:
                continue
            since = getattr(connection, "replaced", None)
            if since is None or connection.removed:
                return False
            if time.monotonic() - since < DRAIN_TIMEOUT:
                with self._changed:
                    self._schedule((topic, uri), DRAIN_TIMEOUT)
                return False
            connection.close()
        return True

    def _reconnect(self, missing: list[tuple[str, str]]) -> None:
        """Requests the publishers of all missing connections at once and connects to them."""
        if not missing:
            return
        try:
            known = self._request({topic for topic, _ in missing})
        except Exception:  # any response of another process; a later one may be valid
            known = None
            _log.warning("the publishers cannot be requested from the master", exc_info=True)
        for topic, uri in missing:
            with self._changed:
                if known is not None and uri not in known[topic]:
                    self._attempts.pop((topic, uri), None)
                    continue
                attempts = self._attempts[topic, uri] = self._attempts.get((topic, uri), 0) + 1
                if attempts < len(DELAYS):
                    self._schedule((topic, uri), DELAYS[attempts])
            if known is not None:
                self._connect(topic, sorted(known[topic]))


MIN_LIFETIME = 1.0  # [s] after which a connection counts as established
_update = RegManager.publisher_update
_connect = ROSHandler._connect_topic
_receive = tcpros_pubsub.robust_connect_subscriber
_reconnecting = Reconnecting()
_api = masterslave.xmlrpcapi
_connecting: dict[tuple[str, str], bool] = {}  # (topic, address) -> whether to connect once more
_listed: dict[str, set[str]] = {}  # by topic: publishers of the master's newest list
_locking = threading.Lock()  # of _connecting
_attempt = threading.local()  # .key of _connecting, .tried: of the thread that connects


def enable_reconnecting() -> None:
    """Makes all subscriptions of this process reconnect to their publishers; may be called twice.

    nodes.init_node calls it; existing connections are not covered.
    """
    RegManager.publisher_update = _join_updates
    ROSHandler.publisherUpdate = _note_update
    ROSHandler._connect_topic = _connect_once
    tcpros_pubsub.robust_connect_subscriber = _receive_and_reconnect
    masterslave.xmlrpcapi = _api_while_listed


@functools.wraps(_update)
def _join_updates(self: Any, resolved_name: str, uris: list[str]) -> None:
    if get_topic_manager().get_subscriber_impl(resolved_name) is not None:
        _listed[resolved_name] = set(uris)  # also of a new subscription, which no update tells
    with self.cond:  # a reentrant lock
        pending = [uri for topic, known in self.updates if topic == resolved_name for uri in known]
        _update(self, resolved_name, list(dict.fromkeys([*uris, *pending])))


@functools.wraps(_connect)
def _connect_once(self: Any, topic: str, pub_uri: str) -> Any:
    key = _attempt.key = topic, pub_uri
    with _locking:
        if key in _connecting:
            _connecting[key] = True  # the other thread looks again when it is done
            return 0, "another thread connects", 0
        _connecting[key] = False
    while True:
        _attempt.tried = False
        try:
            result = _connect(self, topic, pub_uri)
        except Exception as error:  # rospy's thread ends with it
            result = 0, str(error), 0
        with _locking:
            if not _connecting[key]:
                del _connecting[key]
                return result
            _connecting[key] = False


@functools.wraps(_api)
def _api_while_listed(uri: str, cache: bool = True) -> Any:
    topic, publisher = getattr(_attempt, "key", ("", ""))
    if uri == publisher:
        if _attempt.tried and publisher not in _listed.get(topic, {publisher}):
            raise ConnectionRefusedError(errno.ECONNREFUSED, "it is not listed any more")
        _attempt.tried = True
    return _api(uri, cache)


@apivalidate(-1, (is_topic("topic"), is_publishers_list("publishers")))
def _note_update(self: Any, caller_id: str, topic: str, publishers: list[str]) -> Any:
    listed = list(dict.fromkeys(publishers))[:MAX_PUBLISHERS]
    _update_connections(topic, listed)
    if self.reg_man:
        self.reg_man.publisher_update(topic, listed)
    return 1, "", 0


def _update_connections(topic: str, publishers: list[str]) -> None:
    """Sets flags of a topic's connections by the master's newest list of its publishers."""
    subscription = get_topic_manager().get_subscriber_impl(topic)
    if subscription is None:
        return
    _listed[topic] = set(publishers)
    for connection in subscription.connections:
        listed = connection.endpoint_id in publishers
        if listed and getattr(connection, "removed", False):
            connection.replaced = time.monotonic()
            _reconnecting.replace(topic, connection.endpoint_id)
        connection.removed = not listed
    for uri in publishers:
        _reconnecting.reset_attempts(topic, uri)


@functools.wraps(_receive)
def _receive_and_reconnect(
    conn: Any,
    dest_addr: str,
    dest_port: int,
    pub_uri: str,
    receive_cb: Any,
    resolved_topic_name: str,
) -> None:
    start = time.monotonic()
    try:
        _receive(conn, dest_addr, dest_port, pub_uri, receive_cb, resolved_topic_name)
    finally:
        subscription = getattr(receive_cb, "__self__", None)
        current = get_topic_manager().get_subscriber_impl(resolved_topic_name)
        if subscription is current is not None and not is_shutdown_requested():
            handshake_done = conn.md5sum is not None
            worked = handshake_done and time.monotonic() - start > MIN_LIFETIME
            _handle_end(subscription, conn, pub_uri, worked)


def _handle_end(subscription: Any, connection: Any, uri: str, worked: bool) -> None:
    """Reconnects a subscription to a publisher whose connection has ended."""
    if connection in subscription.connections:  # rospy has abandoned it and left it in the list
        connection.done = False
        connection.close()
    if getattr(connection, "removed", False):
        return  # the master sends an update when it registers again
    if getattr(connection, "replaced", None):
        connect(subscription.resolved_name, [uri])
    _reconnecting.connection_ended(subscription.resolved_name, uri, worked)
