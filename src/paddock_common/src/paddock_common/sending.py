"""Last messages of a node: rospy sends from threads, and an end does not wait for them."""

import time

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
