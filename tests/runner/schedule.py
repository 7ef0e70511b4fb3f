"""Which job starts next, and how many run side by side."""

import os
from pathlib import Path

CPU_QUOTA = Path("/sys/fs/cgroup/cpu.max")  # "QUOTA PERIOD" [us], or "max PERIOD"


class Schedule:
    """Jobs that wait for free slots: those that need several first, then the longest first.

    Args:
        jobs: Jobs.
        slots: How many jobs of one slot may run side by side.
        seconds: Dict of a job's key -> expected wall time [s].
    """

    def __init__(self, jobs, slots, seconds):
        self.slots = slots
        self._free = slots
        self._waiting = sorted(
            jobs, key=lambda job: (-max(1, job.slots), -seconds.get(job.key, 0.0), job.key)
        )

    def _need(self, job):
        return min(job.slots, self.slots) if self.slots > 1 else 1

    def take(self):
        """Gives the next job that fits beside those that run, or None."""
        for job in self._waiting:
            if self._need(job) <= self._free:
                self._waiting.remove(job)
                self._free -= self._need(job)
                return job
        return None

    def give_back(self, job):
        """Frees the slots of a job that has ended."""
        self._free += self._need(job)


def cores(quota=CPU_QUOTA):
    """Gives the number of cores that this process may use, at least 1.

    Args:
        quota: File with the control group's limit (cgroup v2), which a container may have.
    """
    count = len(os.sched_getaffinity(0))
    try:
        limit, period = quota.read_text().split()
        count = min(count, round(int(limit) / int(period)))
    except (OSError, ValueError):  # no such file, or "max": no limit
        pass
    return max(1, count)


def slack(side_by_side, available):
    """Gives the factor by which deadlines grow with what runs on a core, 1 or more.

    Args:
        side_by_side: How many jobs run at once.
        available: Number of cores.
    """
    return 1.0 + side_by_side / available
