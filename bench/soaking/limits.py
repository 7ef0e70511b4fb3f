"""The limit of a shutdown, and by how much competing load extends it."""

import os

from usage import PROC

SHUTDOWN_LIMIT = 5.0  # [s] from the signal until nothing is left, without competing load
POLITE_LIMIT = 15.0  # [s] after which roslaunch uses SIGTERM: that is a fault on any machine


class CompetingLoad:
    """Counts at each sample the threads that run or wait for a processor and are not ours.

    Args:
        cores: Number of processors; None: as many as this process may use.
    """

    def __init__(self, proc=PROC, cores=None):
        self._proc, self._cores = proc, cores or len(os.sched_getaffinity(0))
        self._samples = []

    def sample(self, pids=()):
        """Counts now.

        Args:
            pids: Of our processes; this one is ours, too.
        """
        ready = self._ready() - 1 - sum(self._ready_of(pid) for pid in pids)
        self._samples.append(max(0, ready))

    def slowdown(self):
        """How much longer something takes that shares each processor with them: 1 with none."""
        if not self._samples:
            return 1.0
        return 1.0 + sum(self._samples) / len(self._samples) / self._cores

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


def violation(found, files=(), longest=SHUTDOWN_LIMIT):
    """Which limit a shutdown has broken, one message; '' when it has kept all.

    Args:
        files: Names of temporary files that are left and should not be.
        longest: Longest time [s] without competing load; with it longer by its slowdown.
    """
    if found.left:
        return f"left {found.left} after {found.seconds:.1f} s"
    limit = longest * found.slowdown
    if found.seconds > limit:
        return f"took {formatted(found)}, at most {limit:.1f} s; {latest(found.lives)}"
    if files:
        return f"left files in the temporary folder: {list(files)}"
    return ""


def formatted(found):
    """The time of a shutdown and by how much competing load has slowed it down."""
    if found.slowdown < 1.1:
        return f"{found.seconds:.1f} s"
    return f"{found.seconds:.1f} s (others slowed it down {found.slowdown:.1f} times)"


def latest(lives, count=4):
    """The last processes to end and when."""
    return "last came " + ", ".join(f"{role} {seconds:.1f} s" for role, seconds in lives[-count:])
