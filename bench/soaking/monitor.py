"""What is monitored: memory, threads, files, topics, the real-time factor, the log."""

import os
import re
import threading
import time
from dataclasses import dataclass

import psutil
from figures import BenchError

CONTEXT = 40  # most lines of a traceback that are shown
_COLORS = re.compile(r"\x1b(\[[0-9;]*m|\][^\x07]*\x07)")
_MARKS = ("Traceback (most recent call last)", "Segmentation fault", "core dumped", "MemoryError")
# Of roslaunch, of rospy while a master is gone, and of the master's own log on a full disk.
_THEIRS = ("roslaunch", "rosmaster", "xmlrpc/client.py", "rosgraph/xmlrpc.py", "logging/")
PERIOD = 2.0  # [s] between two samples
WARM_UP = 60.0  # [s] of a process's life before its growth counts
SPAN = 60.0  # [s] least time between the first and the last figures that are compared
ENDS = 20.0  # [s] over which the least value counts at either end: peaks are no growth
LIMITS = {"memory": (0.25, 40e6), "threads": (0.25, 12), "files": (0.25, 20)}  # share, absolute


def problems(text, known=_THEIRS):
    """Tracebacks and crashes in a log.

    Args:
        known: Words of tracebacks that are not ours.

    Returns:
        Excerpts, each once.
    """
    lines, found = _COLORS.sub("", text).splitlines(), {}
    for number, line in enumerate(lines):
        if any(mark in line for mark in _MARKS):
            excerpt = "\n".join(_excerpt(lines[number : number + CONTEXT]))
            if not any(word in excerpt for word in known):
                found.setdefault(excerpt, None)
    return list(found)


def _excerpt(lines):
    """A traceback: its first line, the indented ones, and the error."""
    end = 1
    while end < len(lines) and lines[end].startswith(" "):
        end += 1
    return lines[: end + 1] if end > 1 else lines[:1]


@dataclass
class Sample:
    """One moment.

    Attributes:
        wall: [s] since the soak began.
        simulated: [s].
        counts: dict of topic -> messages so far.
        processes: dict of role -> (pid, memory [B], threads, open files).
        shared: bytes in /dev/shm and of memfds.
        calm: whether no fault was going on.
    """

    wall: float
    simulated: float
    counts: dict
    processes: dict
    shared: int
    calm: bool


def read_process(pid):
    """(pid, memory [B], threads, open files) of a process, or None when it has ended."""
    try:
        process = psutil.Process(pid)
        memory = process.memory_full_info().pss
        return pid, memory, process.num_threads(), process.num_fds()
    except psutil.Error:
        return None


def shared_bytes():
    """Bytes in use below /dev/shm."""
    try:
        return sum(entry.stat().st_size for entry in os.scandir("/dev/shm"))
    except OSError:
        return 0


class Sampler(threading.Thread):
    """Samples a session until it is stopped.

    Args:
        begin: time.monotonic of the soak's begin.

    Attributes:
        calm: set by the soak while no fault is going on.
    """

    def __init__(self, session, begin):
        super().__init__(daemon=True)
        self._session, self._begin = session, begin
        self._end = threading.Event()
        self.samples, self.calm, self.error = [], True, ""

    def run(self):
        """Until stop()."""
        while not self._end.wait(PERIOD):
            calm = self.calm
            try:
                answer = self._session.monitor.request(what="sample")
            except BenchError as error:
                if not self._end.is_set():
                    self.error = str(error)
                return
            processes = {}
            for role, pids in self._session.roles().items():
                found = read_process(pids[-1])
                if found is not None:
                    processes[role] = found
            self.samples.append(
                Sample(
                    time.monotonic() - self._begin,
                    answer["simulated"],
                    answer["counts"],
                    processes,
                    shared_bytes(),
                    calm and self.calm,
                )
            )

    def stop(self):
        """Ends the thread."""
        self._end.set()
        self.join()


def growth(samples):
    """What has grown beyond its limits between a process's warm-up and its end.

    Returns:
        Sentences.
    """
    lives = {}
    for sample in samples:
        for role, (pid, *values) in sample.processes.items():
            lives.setdefault((role, pid), []).append((sample.wall, *values))
    found = []
    for (role, pid), readings in lives.items():
        first = [row for row in readings if row[0] >= readings[0][0] + WARM_UP]
        if not first or first[-1][0] - first[0][0] < SPAN:
            continue
        early = [row for row in first if row[0] <= first[0][0] + ENDS]
        late = [row for row in first if row[0] >= first[-1][0] - ENDS]
        for column, (name, (share, least)) in enumerate(LIMITS.items(), 1):
            before, after = (min(row[column] for row in rows) for rows in (early, late))
            if after > before * (1.0 + share) + least:
                found.append(f"{name} of {role} (pid {pid}) grew from {before:g} to {after:g}")
    return found


def neighbors(samples):
    """Pairs of samples one after the other, without those with a reset between them."""
    return [
        (before, after)
        for before, after in zip(samples, samples[1:])
        if after.simulated >= before.simulated
    ]


def real_time_factor(before, after):
    """Simulated seconds per wall second between two samples."""
    return (after.simulated - before.simulated) / (after.wall - before.wall)


def real_time_factors(samples):
    """(wall time, real-time factor) of neighbors."""
    return [(after.wall, real_time_factor(before, after)) for before, after in neighbors(samples)]


def rates(samples, topic):
    """(wall time, messages per wall second) of a topic."""
    return [
        (after.wall, (after.counts[topic] - before.counts[topic]) / (after.wall - before.wall))
        for before, after in zip(samples, samples[1:])
    ]
