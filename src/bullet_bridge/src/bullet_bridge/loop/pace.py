"""Pace of the simulation: when steps are due in wall time, and how late they were."""

import collections
import time as wall

MAX_LAG = 0.25  # [s] lateness beyond which the pace restarts instead of catching up
WINDOW = 1.0  # [s] wall time over which the real time factor is measured
HISTORY = 4096  # batches whose lateness is stored


class Pace:
    """Wall time at which simulated times are due.

    Args:
        factor: simulated seconds per wall second; 0: as fast as possible.
        now: function that gives wall time [s].
        on_measured: called with the measured real time factor after each full WINDOW.

    Attributes:
        factor: as above.
    """

    def __init__(self, factor, now=wall.monotonic, on_measured=None):
        self.factor, self._now, self._on_measured = factor, now, on_measured
        self._late = collections.deque(maxlen=HISTORY)
        self._measured = 0.0
        self.anchor(0.0)

    def anchor(self, time):
        """Restart the pace: simulated time [s] is due now."""
        self._wall_start = self._mark_wall = self._now()
        self._sim_start = self._mark_sim = time

    def delay(self, time):
        """Wall time [s] until the step that follows simulated time [s] is due; 0: it is due."""
        now = self._now()
        if now - self._mark_wall >= WINDOW:
            self._measured = (time - self._mark_sim) / (now - self._mark_wall)
            self._mark_wall, self._mark_sim = now, time
            if self._on_measured is not None:
                self._on_measured(self._measured)
        if self.factor == 0:
            return 0.0
        delay = self._wall_start + (time - self._sim_start) / self.factor - now
        if delay > 0:
            return delay
        self._late.append(-delay)
        if delay < -MAX_LAG:
            self._wall_start, self._sim_start = now, time
        return 0.0

    def statistics(self):
        """Lateness of the last batches and the measured real time factor.

        Returns:
            dict of lateness_p50, lateness_p99, lateness_max [s] (wall time from when a batch was
            due to when it began; 0 when running free), batches (their number) and
            real_time_factor (over the last full WINDOW; 0: none yet).
        """
        late = sorted(self._late)
        pick = (
            (lambda share: late[min(int(share * len(late)), len(late) - 1)])
            if late
            else lambda share: 0.0
        )
        return {
            "lateness_p50": pick(0.5),
            "lateness_p99": pick(0.99),
            "lateness_max": pick(1.0),
            "batches": len(late),
            "real_time_factor": self._measured,
        }
