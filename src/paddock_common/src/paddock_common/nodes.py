"""The life of a node: it starts, or prints why it cannot, and ends silently at a signal.

A log that cannot be written must not stop a node: a full disk, a closed terminal or pipe. rospy's
handler of the console lets the error out into whoever logs, and Python's of files prints a
traceback for each line. Here a handler that fails is said once, and the node goes on.

The thread that answers a node's XML-RPC calls ends with the node. rospy closes that thread's socket
while it polls it. From then on poll() returns at once, and the thread takes a whole processor until
the process is gone: 0.2 to 0.5 s where others start or end beside it, as they do when a launch file
starts or ends.

A node that ends says nothing but that it ended. rospy closes a node's topics before it says that
the node is shut down. What a callback, a timer or a service publishes in between raises, and is
printed with a traceback. Here it is dropped, as rospy itself drops what is published later. What
callbacks, services and threads of a node raise after its shutdown was requested goes to the log
file alone. What is raised before is told as ever.

SIGINT and SIGTERM end a node, whatever it is doing. rospy's own handlers run the whole shutdown in
the main thread, between two of its instructions. If that thread has a lock which the shutdown
needs, both wait for ever: each call of the master takes one, so a node that is asked to end while
it starts may stay until roslaunch kills it 17 s later.
"""

import _thread
import atexit
import ctypes
import functools
import logging
import os
import signal
import sys
import threading
import time
from types import SimpleNamespace

import rospy
import rospy.exceptions
import rospy.impl.init
from rosgraph.roslogging import RosStreamHandler
from rosgraph.xmlrpc import XmlRpcNode
from rospy.core import is_shutdown_requested
from rospy.impl.tcpros_service import ServiceImpl
from rospy.topics import _PublisherImpl, _SubscriberImpl

from paddock_common import subscriptions
from paddock_common.process import StopRequest, end_with_roslaunch

_said = set()  # handlers that have failed


def bear_failures():
    """Changes the handlers of this process; to be called once, when the node starts."""
    logging.Handler.handleError = _failed
    if RosStreamHandler.emit is not _emit:
        RosStreamHandler.emit_or_raise = RosStreamHandler.emit
        RosStreamHandler.emit = _emit


def _emit(handler, record):
    try:
        handler.emit_or_raise(record)
    except (OSError, ValueError):  # ValueError: the stream is closed
        handler.handleError(record)


def _failed(handler, record):
    """Says once that a handler fails, wherever that can still be read."""
    error = sys.exc_info()[1]
    if handler in _said:
        return
    _said.add(handler)
    name = getattr(handler, "baseFilename", "the console")
    text = f"the log cannot be written to {name}: {error}; it is left out from now on"
    try:
        sys.stderr.write(f"{text}\n")
    except (OSError, ValueError):
        logging.getLogger("rosout").warning(text)


_upstream = XmlRpcNode.shutdown


@functools.wraps(_upstream)
def _shutdown(self, reason):
    server = self.server
    if server:
        _thread.start_new_thread(server.shutdown, ())  # it waits for the thread's end
    _upstream(self, reason)


def end_with_node():
    """Has the thread end when the node does, of all nodes of this process."""
    XmlRpcNode.shutdown = _shutdown


# What rospy raises because of a shutdown, wherever it is called.
INTERRUPTIONS = (rospy.ROSException, rospy.ServiceException, rospy.exceptions.TransportException)
_log = logging.getLogger("rospy.closing")  # has no console
_publish = _PublisherImpl.publish
_invoke = _SubscriberImpl._invoke_callback
_service_failed = ServiceImpl.error_handler


def end_silently():
    """Has the node of this process end so; may be called twice."""
    _PublisherImpl.publock = _Kept()
    _PublisherImpl.publish = _publish_unless_closed
    _SubscriberImpl._invoke_callback = _invoke_unless_failed
    ServiceImpl.error_handler = _tell_service_error
    if not isinstance(threading.excepthook, _Hook):
        threading.excepthook = _Hook(threading.excepthook, Exception)
    if not isinstance(sys.excepthook, _Hook):
        sys.excepthook = _Hook(sys.excepthook, INTERRUPTIONS)


class _Kept:
    """The lock of a publisher's topic, which rospy takes away when it closes the topic.

    A thread that has the lock then could not give it back, and one that waits for it waited on.
    """

    def __get__(self, topic, _kind=None):
        return self if topic is None else topic.__dict__.get("publock")

    def __set__(self, topic, lock):
        if lock is not None:
            topic.__dict__["publock"] = lock


@functools.wraps(_publish)
def _publish_unless_closed(self, message, connection_override=None):
    try:
        return _publish(self, message, connection_override)
    except Exception:
        if not (self.closed and is_shutdown_requested()):
            raise
        return None


class _Callback:
    """A subscriber's callback; looks like it in rospy's words about its errors."""

    __slots__ = ("_call",)

    def __init__(self, call):
        self._call = call

    def __repr__(self):
        return repr(self._call)

    def __call__(self, *args):
        try:
            self._call(*args)
        except Exception:
            if not is_shutdown_requested():
                raise
            _log.warning("while the node ends: bad callback: %s", self._call, exc_info=True)


@functools.wraps(_invoke)
def _invoke_unless_failed(self, msg, cb, cb_args):
    _invoke(self, msg, _Callback(cb), cb_args)


@functools.wraps(_service_failed)
def _tell_service_error(self, e, exc_type, exc_value, tb):
    if is_shutdown_requested():
        _log.warning("while the node ends: error of a service", exc_info=(exc_type, exc_value, tb))
    else:
        _service_failed(self, e, exc_type, exc_value, tb)


class _Hook:
    """Python's excepthook, of sys or of threading.

    Args:
        before: The hook that it takes the place of.
        kinds: Exceptions that are not printed while the node ends.
    """

    def __init__(self, before, kinds):
        self._before, self._kinds = before, kinds

    def __call__(self, *args):
        told = args if len(args) == 3 else args[0][:3]  # threading gives one tuple
        if is_shutdown_requested() and issubclass(told[0], self._kinds):
            _log.warning("while the node ends", exc_info=tuple(told))
        else:
            self._before(*args)


LOOK = 0.003  # [s] between two looks whether the master has registered the node
LARGEST_KEPT = 32 << 20  # [bytes] the most that glibc takes
M_TRIM_THRESHOLD, M_MMAP_THRESHOLD = -1, -3  # of malloc.h


def init_node(name, **options):
    """Calls rospy.init_node, which looks for its registration every 0.1 s: here it does so sooner.

    Every node of Paddock starts here: its subscriptions keep their publishers, and it ends without
    a word and without taking a processor.

    Args:
        name: Of the node.
        options: rospy.init_node's.
    """
    end_with_node()
    end_silently()
    subscriptions.keep()
    keep_freed_memory()
    clock = rospy.impl.init.time
    rospy.impl.init.time = SimpleNamespace(sleep=lambda seconds: time.sleep(min(seconds, LOOK)))
    try:
        rospy.init_node(name, **options)
    finally:
        rospy.impl.init.time = clock


def keep_freed_memory():
    """Has glibc keep what is freed for later, instead of giving each large block back.

    rospy receives every message into a block of 4 MB, and pictures are as large: each would be
    mapped and unmapped by the kernel, which doubles the processor time of a subscriber.
    """
    mallopt = getattr(ctypes.CDLL(None), "mallopt", None)
    if mallopt is not None:  # glibc
        mallopt(M_MMAP_THRESHOLD, LARGEST_KEPT)
        mallopt(M_TRIM_THRESHOLD, 2 * LARGEST_KEPT)


NUMBERS = (signal.SIGINT, signal.SIGTERM)
PATIENCE = 10.0  # longest wait at exit for a shutdown that is under way [s]


def init_interruptible(name, **options):
    """Calls rospy.init_node, of a node whose shutdown has a thread of its own.

    A signal that comes before the node is made ends the process at once.

    Args:
        name: Of the node.
        options: rospy.init_node's.
    """
    for number in NUMBERS:
        signal.signal(number, signal.SIG_DFL)
    init_node(name, disable_signals=True, **options)
    watch()


def watch():
    """Has SIGINT and SIGTERM shut the node down; main thread only."""
    reader, writer = os.pipe()
    os.set_blocking(writer, False)
    stop, done = StopRequest(NUMBERS, lambda: os.write(writer, b".")), threading.Event()

    def shut_down():
        os.read(reader, 1)
        rospy.signal_shutdown(f"signal-{int(stop.signal)}")
        done.set()

    def finish():
        if stop.requested():
            done.wait(PATIENCE)

    _thread.start_new_thread(shut_down, ())
    atexit.register(finish)


def start(name, make, errors=ValueError):
    """Starts a node.

    Args:
        name: Of the node.
        make: Class or function without arguments that connects.
        errors: Exceptions that tell what keeps it from starting: they are logged, and the process
            ends with exit status 1.

    Returns:
        What `make` gave.
    """
    bear_failures()
    init_interruptible(name)
    end_with_roslaunch()
    try:
        return make()
    except errors as error:
        rospy.logfatal("%s cannot start: %s", name, error)
        sys.exit(1)


def run(name, make, errors=ValueError):
    """Starts a node and waits until ROS shuts down; arguments as those of start."""
    node = start(name, make, errors)
    rospy.spin()
    return node
