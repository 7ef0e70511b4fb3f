"""A node that ends says nothing but that it ended.

rospy closes a node's topics before it says that the node is shut down. What a callback, a timer or
a service publishes in between raises, and is printed with a traceback. Here it is dropped, as rospy
itself drops what is published later. What callbacks, services and threads of a node raise after its
shutdown was requested goes to the log file alone. What is raised before is told as ever.
"""

import functools
import logging
import sys
import threading

import rospy
import rospy.exceptions
from rospy.core import is_shutdown_requested
from rospy.impl.tcpros_service import ServiceImpl
from rospy.topics import _PublisherImpl, _SubscriberImpl

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
