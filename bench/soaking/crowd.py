"""How many threads of others wanted the processors meanwhile: what a time limit may grow by."""

import os

from processes import PROC


class Crowd:
    """Counts at each look the threads that run or wait for a processor and are not ours.

    Args:
        proc: Folder of /proc.
        cores: Number of processors; None: as many as this process may use.
    """

    def __init__(self, proc=PROC, cores=None):
        self._proc, self._cores = proc, cores or len(os.sched_getaffinity(0))
        self._looks = []

    def look(self, pids=()):
        """Counts now.

        Args:
            pids: Of our processes; this one is ours, too.
        """
        ready = self._ready() - 1 - sum(self._ready_of(pid) for pid in pids)
        self._looks.append(max(0, ready))

    def slowdown(self):
        """How much longer something takes that shares each processor with them: 1 with nobody."""
        if not self._looks:
            return 1.0
        return 1.0 + sum(self._looks) / len(self._looks) / self._cores

    def _ready(self):
        for line in (self._proc / "stat").read_text().splitlines():
            if line.startswith("procs_running "):
                return int(line.split()[1])
        return 1

    def _ready_of(self, pid):
        """Threads of a process that run or wait for a processor; none where it has ended."""
        count = 0
        for path in (self._proc / str(pid) / "task").glob("*/stat"):
            try:
                count += path.read_text(errors="replace").rpartition(")")[2].split()[0] == "R"
            except (OSError, IndexError):
                continue
        return count
