"""ROS time that passes, for a watchdog that stops a robot: it must not wait for a clock that jumps.

rospy's time is whatever the last message on /clock says. Where two nodes publish it, it jumps
between their times, and an age that is counted by it never grows.
"""

from __future__ import annotations

import time
from collections.abc import Callable

import rospy
from rosgraph_msgs.msg import Clock


class PassedTime:
    """Counts the time that passes, by each publisher of /clock for itself: the fastest counts.

    A time that goes back, as at a reset, adds nothing. Without simulated time it is wall time.

    Args:
        period: Longest time between two calls of `then` [s].
        then: Called without arguments while time passes.
    """

    def __init__(self, period: float, then: Callable[[], object]) -> None:
        self._then = then
        self._last: dict[str, float] = {}  # publisher -> its time [s]
        self._passed: dict[str, float] = {}
        self._simulated = bool(rospy.get_param("/use_sim_time", False))
        if self._simulated:
            self._subscriber = rospy.Subscriber("/clock", Clock, self._update)
        else:
            self._timer = rospy.Timer(rospy.Duration(period), lambda _: then(), reset=True)

    def __call__(self) -> float:
        """Time [s] since the construction, or since an earlier one."""
        return max(self._passed.values(), default=0.0) if self._simulated else time.monotonic()

    def _update(self, message: Clock) -> None:
        publisher, now = message._connection_header["callerid"], message.clock.to_sec()
        if publisher in self._last:
            self._passed[publisher] += max(0.0, now - self._last[publisher])
        else:
            self._passed[publisher] = 0.0
            if self._last:
                rospy.logwarn(
                    "%s publishes /clock, too, besides %s: times of all nodes jump between theirs",
                    publisher,
                    ", ".join(self._last),
                )
        self._last[publisher] = now
        self._then()
