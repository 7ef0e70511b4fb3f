"""Waits in wall time: for conditions, services, and messages to be sent."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import TypeVar

import rosgraph
import rospy

from paddock_common.master import find_service

POLL_PERIOD = 0.05  # [s]
RESPONSE_TIMEOUT = 10.0  # [s] for one where there is no limit
MIN_TIMEOUT = 0.5  # [s] for a response of the master, and for a service that is registered
T = TypeVar("T")


class WaitTimeout(Exception):
    """The condition did not become true in time."""


def wait_until(
    check: Callable[[], T],
    timeout: float | None,
    label: str,
    poll_period: float = POLL_PERIOD,
    is_shutdown: Callable[[], bool] | None = None,
) -> T:
    """Polls until a check holds.

    Args:
        check: a true value ends the wait and is returned.
        timeout: wall-clock limit [s]; None waits without limit.
        label: name of the condition in the error message.
        poll_period: wall-clock time between two checks [s].
        is_shutdown: whether a shutdown was requested; None: rospy.is_shutdown.

    Raises:
        WaitTimeout: the time limit was exceeded.
        rospy.ROSInterruptException: a shutdown was requested meanwhile.
    """
    deadline = None if timeout is None else time.monotonic() + timeout
    is_shutdown = is_shutdown or rospy.is_shutdown
    while not is_shutdown():
        result = check()
        if result:
            return result
        if deadline is not None and time.monotonic() >= deadline:
            raise WaitTimeout(f"{label} did not come within {timeout:g} s")
        time.sleep(poll_period)
    raise rospy.ROSInterruptException(f"shut down while waiting for {label}")


def wait_for_service(
    name: str, timeout: float | None, is_shutdown: Callable[[], bool] | None = None
) -> None:
    """Waits until a service is advertised and responds to a probe.

    Args:
        name: service name, resolved against this node's namespace.
        timeout: wall-clock limit [s]; None waits without limit.
        is_shutdown: whether a shutdown was requested; None: rospy.is_shutdown.

    Raises:
        WaitTimeout: the time limit was exceeded.
        rospy.ROSInterruptException: a shutdown was requested meanwhile.
    """
    resolved, start = rospy.resolve_name(name), time.monotonic()

    def _left() -> float:
        if timeout is None:
            return RESPONSE_TIMEOUT
        return max(MIN_TIMEOUT, timeout - (time.monotonic() - start))

    def _registered() -> str | None:
        return find_service(rosgraph.get_master_uri(), rospy.get_name(), resolved, _left())

    label = f"service {resolved}"
    wait_until(_registered, timeout, label, is_shutdown=is_shutdown)
    try:
        rospy.wait_for_service(resolved, _left())
    except rospy.ROSInterruptException:
        raise
    except rospy.ROSException:
        if timeout is None:
            wait_for_service(name, None, is_shutdown)
            return
        raise WaitTimeout(
            f"{label} is registered but did not respond within {timeout:g} s"
        ) from None


LIMIT = 2.0  # [s]
MARGIN = 0.15  # [s] for messages that a thread has taken from its queue and not written yet
PERIOD = 0.005  # [s]


def flush(*publishers: rospy.Publisher, limit: float = LIMIT) -> bool:
    """Waits until rospy's threads have sent the published messages.

    On a busy machine they start late, and messages still queued when a node exits are dropped.

    Args:
        limit: Longest wait [s].

    Returns:
        Whether the queues are empty.
    """
    end = time.monotonic() + limit
    while any(_is_queued(publisher) for publisher in publishers):
        if time.monotonic() > end:
            return False
        time.sleep(PERIOD)
    time.sleep(MARGIN)
    return True


def _is_queued(publisher: rospy.Publisher) -> bool:
    connections = list(getattr(getattr(publisher, "impl", None), "connections", ()))
    return any(getattr(connection, "_queue", ()) for connection in connections)
