"""Waiting in wall time: for conditions, services, and messages to be sent."""

import time

import rosgraph
import rospy

POLL_PERIOD = 0.05  # [s]


class WaitTimeout(Exception):
    """The awaited condition did not hold in time."""


def wait_until(check, timeout, what, poll_period=POLL_PERIOD, ended=None):
    """Polls until a check holds.

    Args:
        check: callable; anything true ends the wait and is returned.
        timeout: wall-clock limit [s]; None waits without limit.
        what: the awaited condition, for the error text.
        poll_period: wall-clock time between two checks [s].
        ended: callable; whether a shutdown was requested; None: rospy.is_shutdown.

    Returns:
        What check returned.

    Raises:
        WaitTimeout: the limit passed.
        rospy.ROSInterruptException: the node was asked to end meanwhile.
    """
    deadline = None if timeout is None else time.monotonic() + timeout
    ended = ended or rospy.is_shutdown
    while not ended():
        result = check()
        if result:
            return result
        if deadline is not None and time.monotonic() >= deadline:
            raise WaitTimeout(f"{what} did not come within {timeout:g} s")
        time.sleep(poll_period)
    raise rospy.ROSInterruptException(f"shut down while waiting for {what}")


def wait_for_service(name, timeout, ended=None):
    """Waits until a service is advertised and responds to a probe.

    Args:
        name: service name, resolved against this node's namespace.
        timeout: wall-clock limit [s].
        ended: callable; whether a shutdown was requested; None: rospy.is_shutdown.

    Raises:
        WaitTimeout: the limit passed.
        rospy.ROSInterruptException: the node was asked to end meanwhile.
    """
    resolved = rospy.resolve_name(name)
    master = rosgraph.Master(rospy.get_name())
    start = time.monotonic()

    def _registered():
        try:
            return master.lookupService(resolved)
        except (rosgraph.MasterException, OSError):
            return None

    what = f"service {resolved}"
    wait_until(_registered, timeout, what, ended=ended)
    try:
        rospy.wait_for_service(resolved, max(0.5, timeout - (time.monotonic() - start)))
    except rospy.ROSInterruptException:
        raise
    except rospy.ROSException:
        raise WaitTimeout(f"{what} is registered but did not answer within {timeout:g} s") from None


LIMIT = 2.0  # [s]
MARGIN = 0.15  # [s] for what a thread has taken from its queue and not written yet
PERIOD = 0.005  # [s]


def flush(*publishers, limit=LIMIT):
    """Waits until rospy's threads have taken what was published.

    On a busy machine they start late, and what is still queued when a node ends is lost.

    Args:
        publishers: rospy.Publisher.
        limit: Longest wait [s].

    Returns:
        Whether all was taken.
    """
    end = time.monotonic() + limit
    while any(_is_queued(publisher) for publisher in publishers):
        if time.monotonic() > end:
            return False
        time.sleep(PERIOD)
    time.sleep(MARGIN)
    return True


def _is_queued(publisher):
    connections = list(getattr(getattr(publisher, "impl", None), "connections", ()))
    return any(getattr(connection, "_queue", ()) for connection in connections)
