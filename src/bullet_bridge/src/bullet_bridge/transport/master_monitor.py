"""Monitors the ROS master: without it no new node can connect to the simulation."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import rosgraph
import rospy
from paddock_common.master import MasterMonitor, proxy

RESPONSE_TIMEOUT = 2.0  # [s] for a response
UNRESPONSIVE_TIME = 5.0  # [s] without a response before a warning
REFUSED_TIME = 3.0  # [s] of refused connections after which the master has exited


def master_pid(uri: str) -> int:
    """Process id of the master.

    Raises:
        paddock_common.master.ERRORS: it did not respond.
    """
    master: Any
    with proxy(uri, RESPONSE_TIMEOUT) as master:
        pid: int = master.getPid("/gazebo")[2]
    return pid


class ShutdownMonitor(MasterMonitor):
    """Monitors the master's process id; shuts down when the master has exited or was replaced.

    A master that is unresponsive but runs, as when it is stopped or its machine is suspended, is
    waited for without a time-out.

    Args:
        end: called once with the reason why the simulation has to shut down.
        uri: of the master; None: that of this node.
        warn: called with one line of text.
        identity, now: as of MasterMonitor.

    Attributes:
        reason: why the simulation has to shut down; '' as long as it need not.
    """

    def __init__(
        self,
        end: Callable[[str], None],
        uri: str | None = None,
        warn: Callable[[str], None] = rospy.logwarn,
        identity: Callable[[str], int] = master_pid,
        now: Callable[[], float] = time.monotonic,
    ) -> None:
        super().__init__(uri or rosgraph.get_master_uri(), identity, self._decide, now)
        self._end, self._warn = end, warn
        self._warned, self.reason = False, ""

    def _decide(self) -> None:
        if self.replaced:
            self._end_with(
                f"another ROS master runs at {self.uri} now, which does not know this simulation"
            )
        elif self.refused_for >= REFUSED_TIME:
            self._end_with(f"the ROS master at {self.uri} has exited")
        elif self._warned != (self.unresponsive_for >= UNRESPONSIVE_TIME):
            self._warned = not self._warned
            self._warn(
                f"the ROS master at {self.uri} does not respond; the simulation continues, new "
                "nodes cannot connect meanwhile"
                if self._warned
                else f"the ROS master at {self.uri} responds again"
            )

    def _end_with(self, reason: str) -> None:
        self.reason = reason
        self.close()
        self._end(f"{reason}: the simulation shuts down")
