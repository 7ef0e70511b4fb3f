"""Warns that the simulation is slower than requested, and why; that many calls wait for it."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from typing import Any

import rospy

SLOW, RECOVERED = 0.9, 0.97  # of the requested real time factor
MIN_COUNT = 5  # measurements, about one a second, before a message is logged
MIN_GAP = 300.0  # [s] of wall time between two warnings
CROWD, CROWDED_TIME = 16, 5.0  # calls that wait all the time, for so long [s]: a warning
MOSTLY = 0.5  # fraction of the rest of the time that makes other processes the reason
BUSY = 0.85  # fraction of a processor beyond which the simulation thread is the bottleneck


def thread_times() -> tuple[float, float]:
    """Times of the calling thread [s]: on a processor, and ready while others used it."""
    try:
        with open("/proc/thread-self/schedstat", encoding="ascii") as file:
            used, waited = file.read().split()[:2]
    except (OSError, ValueError):  # a kernel without these figures
        return time.thread_time(), 0.0
    return 1e-9 * int(used), 1e-9 * int(waited)


class RealTimeFactorMonitor:
    """Monitors the real time factor and how the calling thread spends its time.

    Args:
        warn, info: called with one line of text.
        now: clock [s].
        times: as thread_times.
    """

    def __init__(
        self,
        warn: Callable[[str], None] = rospy.logwarn,
        info: Callable[[str], None] = rospy.loginfo,
        now: Callable[[], float] = time.monotonic,
        times: Callable[[], tuple[float, float]] = thread_times,
    ) -> None:
        self._warn, self._info, self._now, self._times = warn, info, now, times
        self._logged, self._slow = -math.inf, False
        self.restart()

    def restart(self) -> None:
        """Restart, as after a pause or a change of the real time factor."""
        self._count = 0
        self._since: Any = None  # start [s], times then, sum of the measured factors

    def measured(self, factor: float, target: float, time_step: float) -> None:
        """Take a measurement.

        Args:
            factor: simulated seconds per wall second over the last second.
            target: the requested real time factor; 0: none.
            time_step: physics step [s].
        """
        if target == 0.0:
            self.restart()
            self._slow = False
            return
        slow = factor < (RECOVERED if self._slow else SLOW) * target
        if slow == self._slow:
            self.restart()
        if self._since is None:
            self._since = self._now(), self._times(), 0.0
        start, times, simulated = self._since
        if slow == self._slow:
            return
        self._count += 1
        self._since = start, times, simulated + factor
        if self._count < MIN_COUNT:
            return
        self._slow = slow
        if slow and self._now() - self._logged >= MIN_GAP:
            self._logged = self._now()
            self._warn(self._text(target, time_step))
        elif not slow and self._logged > -math.inf:
            self._info(f"real-time factor {factor:.2f}: back at the requested speed")
        self.restart()

    def _text(self, target: float, time_step: float) -> str:
        start, before, simulated = self._since
        wall = max(self._now() - start, 1e-9)
        used, waited = ((now - then) / wall for now, then in zip(self._times(), before))
        mean = simulated / self._count
        text = f"real-time factor {mean:.2f} instead of {target:g}: "
        if used >= BUSY:
            needed = used * time_step / max(mean, 1e-9)
            return text + (
                f"physics and sensors need {1e3 * needed:.2g} ms of a processor for each step of "
                f"{1e3 * time_step:g} ms. Fewer contacts or rays, a longer step, or a smaller "
                "real_time_factor (or PADDOCK_REAL_TIME_FACTOR in the environment) help"
            )
        if waited >= (1.0 - used) * MOSTLY:
            return text + (
                f"other processes leave the simulation {used:.0%} of a processor; time falls "
                "behind evenly, and rates in simulated time stay"
            )
        return text + (
            f"the simulation thread waits {1.0 - used:.0%} of the time for something else than a "
            "processor: images (every_picture), or the node's own services and topics"
        )


class CallMonitor:
    """Monitors how many calls of services wait for the simulation thread.

    Args:
        warn: called with one line of text.
        now: clock [s].
    """

    def __init__(
        self,
        warn: Callable[[str], None] = rospy.logwarn,
        now: Callable[[], float] = time.monotonic,
    ) -> None:
        self._warn, self._now = warn, now
        self._since: Any = None  # start [s] of the crowd, answers until then
        self._logged = -math.inf

    def measured(self, waiting: int, answered: int) -> None:
        """Take how many calls wait, and how many have been answered so far."""
        if waiting < CROWD:
            self._since = None
            return
        now = self._now()
        if self._since is None:
            self._since = now, answered
        start, before = self._since
        if now - start < CROWDED_TIME or now - self._logged < MIN_GAP:
            return
        self._logged = now
        self._warn(
            f"{waiting} calls of services wait for their answers, of which the simulation gives "
            f"{(answered - before) / (now - start):.0f} a second beside its steps: clients that "
            "poll should do it less often, or subscribe to topics"
        )
