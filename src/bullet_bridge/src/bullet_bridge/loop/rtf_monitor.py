"""Says in words that the simulation is slower than asked for, and why."""

import math
import time
from collections.abc import Callable
from typing import Any

import rospy

SLOW, RECOVERED = 0.9, 0.97  # shares of the pace asked for
PATIENCE = 5  # measurements, about one a second, until something is said
SILENCE = 300.0  # [s] of wall time between two warnings
MOSTLY = 0.5  # share of the rest of the time that makes others the reason
BUSY = 0.85  # share of a processor beyond which the simulation thread is the bottleneck


def thread_times() -> tuple[float, float]:
    """Times of the calling thread [s]: on a processor, and ready for one that others had."""
    try:
        with open("/proc/thread-self/schedstat", encoding="ascii") as file:
            used, waited = file.read().split()[:2]
    except (OSError, ValueError):  # a kernel without these figures
        return time.thread_time(), 0.0
    return 1e-9 * int(used), 1e-9 * int(waited)


class Slowness:
    """Watches the measured real time factor and what the calling thread does meanwhile.

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
        self._said, self._slow = -math.inf, False
        self.restart()

    def restart(self) -> None:
        """Begin anew, as after a pause or another pace."""
        self._count = 0
        self._mark: Any = None  # start [s], times then, sum of the measured factors

    def measured(self, factor: float, wanted: float, time_step: float) -> None:
        """Take a measurement.

        Args:
            factor: simulated seconds per wall second over the last second.
            wanted: the real time factor asked for; 0: none.
            time_step: physics step [s].
        """
        if wanted == 0.0:
            self.restart()
            self._slow = False
            return
        slow = factor < (RECOVERED if self._slow else SLOW) * wanted
        if slow == self._slow:
            self.restart()
        if self._mark is None:
            self._mark = self._now(), self._times(), 0.0
        begin, times, simulated = self._mark
        if slow == self._slow:
            return
        self._count += 1
        self._mark = begin, times, simulated + factor
        if self._count < PATIENCE:
            return
        self._slow = slow
        if slow and self._now() - self._said >= SILENCE:
            self._said = self._now()
            self._warn(self._words(wanted, time_step))
        elif not slow and self._said > -math.inf:
            self._info(f"real-time factor {factor:.2f}: the pace is kept again")
        self.restart()

    def _words(self, wanted: float, time_step: float) -> str:
        begin, before, simulated = self._mark
        wall = max(self._now() - begin, 1e-9)
        share, waited = ((now - then) / wall for now, then in zip(self._times(), before))
        mean = simulated / self._count
        text = f"real-time factor {mean:.2f} instead of {wanted:g}: "
        if share >= BUSY:
            needed = share * time_step / max(mean, 1e-9)
            return text + (
                f"physics and sensors need {1e3 * needed:.2g} ms of a processor for each step of "
                f"{1e3 * time_step:g} ms. Fewer contacts or rays, a longer step, or a smaller "
                "real_time_factor help"
            )
        if waited >= (1.0 - share) * MOSTLY:
            return text + (
                f"other processes leave the simulation {share:.0%} of a processor; time falls "
                "behind evenly, and rates in simulated time stay"
            )
        return text + (
            f"the simulation thread waits {1.0 - share:.0%} of the time for something else than a "
            "processor: pictures (every_picture), or the node's own services and topics"
        )
