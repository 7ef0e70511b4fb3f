"""The life cycle of a node: it starts, or logs why it cannot, and shuts down cleanly at a signal.

A log that cannot be written must not stop a node: a full disk, a closed terminal or pipe. rospy's
console handler raises the error in the thread that logs, and Python's file handlers print a
traceback for each line. Here a failing handler is reported once, and the node continues.

The thread that serves a node's XML-RPC calls stops with the node. rospy closes that thread's socket
while it is being polled. From then on poll() returns immediately, and the thread uses a full CPU
until the process exits: 0.2 to 0.5 s in which other nodes start or stop, as they do when a launch
file starts or stops.

A node that shuts down logs no follow-up errors. rospy closes a node's topics before it reports the
node as shut down. Messages that a callback, a timer or a service publishes in between raise an
error, printed with a traceback. Here they are dropped, as rospy itself drops messages that are
published later. Errors of a node's callbacks, services and threads after the shutdown request go to
the log file only. Earlier errors are logged as usual.

A node ignores a shutdown request that is meant for another one. The master sends such a request to
the address where a node of the same name was registered. If that process has died, the kernel may
have given its port to any other node, also of another master.

A node leaves nothing behind at the master. rospy subscribes to a parameter for /rosout and never
unsubscribes, so that the master keeps every node that has ended, and sends such a shutdown request
to its old address as soon as a node of the same name starts. Another process may have that port by
then: a node in C++ shuts down, and a node whose port for topics and services it is waits in vain
for the rest of a header that begins with POST. Here parameters are unsubscribed; `inbound` closes
a connection that does not begin with a header.

SIGINT and SIGTERM shut a node down at any time. rospy's own handlers run the complete shutdown in
the main thread, between two of its instructions. If that thread holds a lock which the shutdown
needs, it deadlocks: each call of the master takes one, so a node that is stopped while it starts
may remain until roslaunch kills it 17 s later.
"""

from __future__ import annotations

import _thread
import atexit
import contextlib
import ctypes
import functools
import logging
import os
import re
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from types import SimpleNamespace
from typing import Any, NoReturn, Tuple, Type, TypeVar, Union

import rospy
import rospy.exceptions
import rospy.impl.init
from rosgraph.roslogging import RosStreamHandler
from rosgraph.xmlrpc import XmlRpcNode
from rospy.core import _shutdown_lock as shutdown_lock
from rospy.core import is_shutdown_requested
from rospy.impl.masterslave import ROSHandler
from rospy.impl.paramserver import get_param_server_cache
from rospy.impl.registration import RegManager
from rospy.impl.tcpros_service import ServiceImpl
from rospy.topics import _PublisherImpl, _SubscriberImpl

from paddock_common import inbound, subscriptions
from paddock_common.master import ERRORS, proxy
from paddock_common.process import StopRequest, exit_with_roslaunch

LONGEST_MESSAGE = 20_000  # characters of a message in the log
MASTER_TIMEOUT = 2.0  # [s] for a response of the master
T = TypeVar("T")
Errors = Union[Type[Exception], Tuple[Type[Exception], ...]]
_reported: set[logging.Handler] = set()  # handlers that have failed


def tolerate_log_errors() -> None:
    """Makes the log handlers of this process tolerate errors; called when the node starts."""
    logging.Handler.handleError = _failed  # type: ignore[assignment]
    logger = logging.getLogger("rosout")
    if _shorten not in logger.filters:
        logger.addFilter(_shorten)
    if RosStreamHandler.emit is not _emit:
        RosStreamHandler.emit_or_raise = RosStreamHandler.emit
        RosStreamHandler.emit = _emit


def _shorten(record: logging.LogRecord) -> bool:
    """Takes the middle out of a message that is too long, as with a name of megabytes in it."""
    text = record.getMessage()
    if len(text) > LONGEST_MESSAGE:
        half = LONGEST_MESSAGE // 2
        left_out = len(text) - LONGEST_MESSAGE
        record.msg = f"{text[:half]} ... [{left_out} characters] ... {text[-half:]}"
        record.args = ()
    return True


def _emit(handler: Any, record: logging.LogRecord) -> None:
    try:
        handler.emit_or_raise(record)
    except (OSError, ValueError):  # ValueError: the stream is closed
        handler.handleError(record)


def _failed(handler: logging.Handler, record: logging.LogRecord) -> None:
    """Reports a failing handler once, on stderr or in the log."""
    error = sys.exc_info()[1]
    if handler in _reported:
        return
    _reported.add(handler)
    name = getattr(handler, "baseFilename", "the console")
    text = f"the log cannot be written to {name}: {error}; it is skipped from now on"
    try:
        sys.stderr.write(f"{text}\n")
    except (OSError, ValueError):
        logging.getLogger("rosout").warning(text)


_upstream = XmlRpcNode.shutdown


@functools.wraps(_upstream)
def _shutdown(self: Any, reason: str) -> None:
    server = self.server
    if server:
        _thread.start_new_thread(server.shutdown, ())  # it waits for the thread
    _upstream(self, reason)


def close_server_with_node() -> None:
    """Makes the XML-RPC thread of each node of this process stop with the node."""
    XmlRpcNode.shutdown = _shutdown


# What rosmaster sends to a node.
REPLACED = re.compile(r"\[(/\S*)\] Reason: new node registered with same name")
_obey_shutdown = ROSHandler.shutdown


@functools.wraps(_obey_shutdown)
def _shutdown_if_addressed(self: Any, caller_id: str, msg: str = "") -> Any:
    replaced = REPLACED.fullmatch(str(msg))
    if replaced is None or replaced[1] == rospy.get_name():
        return _obey_shutdown(self, caller_id, msg)
    _log.warning("ignored a shutdown request for %s, whose port this node has now", replaced[1])
    return 0, f"this is {rospy.get_name()}", 0


def ignore_shutdown_of_others() -> None:
    """Makes the node of this process ignore the master's shutdown requests for other nodes."""
    ROSHandler.shutdown = _shutdown_if_addressed


_cleanup = RegManager.cleanup


@functools.wraps(_cleanup)
def _cleanup_with_parameters(self: Any, reason: str) -> None:
    _cleanup(self, reason)
    keys = list(_leaves("", get_param_server_cache().d or {}))
    if not keys or not self.master_uri:
        return
    master: Any
    try:
        with proxy(self.master_uri, MASTER_TIMEOUT) as master:
            for key in keys:
                master.unsubscribeParam(rospy.get_name(), self.uri, key)
    except ERRORS:
        _log.warning("parameters are not unsubscribed", exc_info=True)


def _leaves(name: str, tree: dict[str, Any]) -> Iterator[str]:
    """Names of all values of a tree of parameters."""
    for key, value in tree.items():
        if isinstance(value, dict) and value:  # an unset one is {}
            yield from _leaves(f"{name}/{key}", value)
        else:
            yield f"{name}/{key}"


def unsubscribe_parameters() -> None:
    """Makes the node of this process unsubscribe its parameters when it shuts down."""
    RegManager.cleanup = _cleanup_with_parameters


# What rospy's functions raise because of a shutdown.
INTERRUPTIONS = (rospy.ROSException, rospy.ServiceException, rospy.exceptions.TransportException)
_log = logging.getLogger("rospy.closing")  # has no console handler
_publish = _PublisherImpl.publish
_invoke = _SubscriberImpl._invoke_callback
_service_failed = ServiceImpl.error_handler


def suppress_shutdown_errors() -> None:
    """Makes the node of this process shut down without such errors; may be called twice."""
    _PublisherImpl.publock = _PersistentLock()
    _PublisherImpl.publish = _publish_unless_closed
    _SubscriberImpl._invoke_callback = _invoke_unless_failed
    ServiceImpl.error_handler = _log_service_error
    if not isinstance(threading.excepthook, _Hook):
        threading.excepthook = _Hook(threading.excepthook, Exception)
    if not isinstance(sys.excepthook, _Hook):
        sys.excepthook = _Hook(sys.excepthook, INTERRUPTIONS)


class _PersistentLock:
    """The lock of a publisher's topic, which rospy removes when it closes the topic.

    Without it a thread that holds the lock cannot release it, and a waiting one waits forever.
    """

    def __get__(self, topic: Any, _owner: type | None = None) -> Any:
        return self if topic is None else topic.__dict__.get("publock")

    def __set__(self, topic: Any, lock: Any) -> None:
        if lock is not None:
            topic.__dict__["publock"] = lock


@functools.wraps(_publish)
def _publish_unless_closed(self: Any, message: Any, connection_override: Any = None) -> Any:
    try:
        return _publish(self, message, connection_override)
    except Exception:
        if not (self.closed and is_shutdown_requested()):
            raise
        return None


class _Callback:
    """Wrapper of a subscriber's callback with its repr, which rospy puts into error messages."""

    __slots__ = ("_call",)

    def __init__(self, call: Callable[..., object]) -> None:
        self._call = call

    def __repr__(self) -> str:
        return repr(self._call)

    def __call__(self, *args: Any) -> None:
        try:
            self._call(*args)
        except Exception:
            if not is_shutdown_requested():
                raise
            _log.warning("during shutdown: bad callback: %s", self._call, exc_info=True)


@functools.wraps(_invoke)
def _invoke_unless_failed(self: Any, msg: Any, cb: Callable[..., object], cb_args: Any) -> None:
    _invoke(self, msg, _Callback(cb), cb_args)


@functools.wraps(_service_failed)
def _log_service_error(self: Any, e: Exception, exc_type: Any, exc_value: Any, tb: Any) -> None:
    if is_shutdown_requested():
        _log.warning("during shutdown: error of a service", exc_info=(exc_type, exc_value, tb))
    else:
        _service_failed(self, e, exc_type, exc_value, tb)


class _Hook:
    """Wrapper of Python's excepthook, of sys or of threading.

    Args:
        original: The hook that it replaces.
        errors: Exceptions that are not printed during shutdown.
    """

    def __init__(self, original: Callable[..., object], errors: type | tuple[type, ...]) -> None:
        self._original, self._errors = original, errors

    def __call__(self, *args: Any) -> None:
        error: Any = args if len(args) == 3 else tuple(args[0][:3])  # threading: one tuple
        if is_shutdown_requested() and issubclass(error[0], self._errors):
            _log.warning("during shutdown", exc_info=error)
        else:
            self._original(*args)


POLL_PERIOD = 0.003  # [s] between two checks whether the master has registered the node
MAX_THRESHOLD = 32 << 20  # [bytes] the maximum that glibc accepts
M_TRIM_THRESHOLD, M_MMAP_THRESHOLD = -1, -3  # of malloc.h


def init_node(name: str, **options: Any) -> None:
    """Calls rospy.init_node, which checks its registration every 0.1 s, with a shorter period.

    Every node of Paddock starts here: its subscriptions reconnect to their publishers, and it shuts
    down without follow-up errors, without using a full CPU, and not at another node's request.
    """
    close_server_with_node()
    suppress_shutdown_errors()
    ignore_shutdown_of_others()
    unsubscribe_parameters()
    inbound.accept_all()
    subscriptions.enable_reconnecting()
    retain_freed_memory()
    clock = rospy.impl.init.time
    rospy.impl.init.time = SimpleNamespace(
        sleep=lambda seconds: time.sleep(min(seconds, POLL_PERIOD))
    )
    try:
        rospy.init_node(name, **options)
    finally:
        rospy.impl.init.time = clock


def retain_freed_memory() -> None:
    """Makes glibc retain freed memory instead of returning each large block to the kernel.

    rospy receives every message into a block of 4 MB, and images are as large: the kernel would map
    and unmap each of them, which doubles the CPU time of a subscriber.
    """
    mallopt = getattr(ctypes.CDLL(None), "mallopt", None)
    if mallopt is not None:  # glibc
        mallopt(M_MMAP_THRESHOLD, MAX_THRESHOLD)
        mallopt(M_TRIM_THRESHOLD, 2 * MAX_THRESHOLD)


SIGNALS = (signal.SIGINT, signal.SIGTERM)
SHUTDOWN_TIMEOUT = 10.0  # longest wait at exit for a running shutdown [s]


def init_interruptible(name: str, **options: Any) -> None:
    """Calls rospy.init_node for a node whose shutdown runs in its own thread.

    A signal before the node is initialized terminates the process immediately.
    """
    for number in SIGNALS:
        signal.signal(number, signal.SIG_DFL)
    init_node(name, disable_signals=True, **options)
    handle_signals()


def handle_signals() -> None:
    """Makes SIGINT and SIGTERM shut the node down; main thread only."""
    reader, writer = os.pipe()
    os.set_blocking(writer, False)
    stop, done = StopRequest(SIGNALS, lambda: os.write(writer, b".")), threading.Event()
    # the number, also while the main thread is within C, where it runs no handler
    signal.set_wakeup_fd(writer, warn_on_full_buffer=False)

    def shut_down() -> None:
        while os.read(reader, 1)[0] not in (*SIGNALS, ord(".")):
            pass  # another signal's
        rospy.signal_shutdown(f"signal-{stop.signal or 0:d}")
        done.set()

    def finish() -> None:
        if stop.requested():
            done.wait(SHUTDOWN_TIMEOUT)
        if is_shutdown_requested() and shutdown_lock.acquire(timeout=SHUTDOWN_TIMEOUT):
            shutdown_lock.release()  # the hooks are over, also of a shutdown that the master wants

    _thread.start_new_thread(shut_down, ())
    atexit.register(finish)


def end_at_latest(limit: float, status: Callable[[], int]) -> threading.Event:
    """Ends the process some time after a shutdown has begun, whatever its main thread does then,
    such as reading a large file.

    Args:
        limit: [s] of wall time.
        status: Function that returns the exit status.

    Returns:
        To be set by the main thread when it ends by itself.
    """
    ended = threading.Event()

    def watch() -> None:
        if not ended.wait(limit):
            rospy.logwarn("the work of the main thread is broken off")
            os._exit(status())

    rospy.on_shutdown(lambda: _thread.start_new_thread(watch, ()))
    return ended


def leave(status: int) -> NoReturn:
    """Ends the process as sys.exit does, but at once: what is registered for the end still runs.

    Python's own end stops threads where they are, and one within OpenCV then aborts the process.
    """
    atexit._run_exitfuncs()
    for stream in filter(None, (sys.stdout, sys.stderr)):  # None: closed before the start
        with contextlib.suppress(OSError, ValueError):  # closed, or nobody reads
            stream.flush()
    os._exit(status)


def start(name: str, make: Callable[[], T], errors: Errors = ValueError, **options: Any) -> T:
    """Starts a node.

    Args:
        make: Class or function without arguments that connects the node.
        errors: Exceptions that prevent the start: they are logged, and the process exits with
            status 1.
        options: Options of rospy.init_node.

    Returns:
        The result of `make`.
    """
    tolerate_log_errors()
    init_interruptible(name, **options)
    exit_with_roslaunch()
    try:
        return make()
    except errors as error:
        rospy.logfatal("%s cannot start: %s", name, error)
        sys.exit(1)


def run(
    name: str, make: Callable[[], object], errors: Errors = ValueError, **options: Any
) -> NoReturn:
    """Starts a node, waits until ROS shuts down and leaves; arguments as those of start."""
    _node = start(name, make, errors, **options)  # kept: it may hold its subscribers
    rospy.spin()
    leave(0)
