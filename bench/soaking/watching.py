"""What is watched: memory, threads, descriptors, topics, the pace; and what may not grow."""

import os
import threading
import time
from dataclasses import dataclass

from figures import BenchError
from processes import memory_bytes

PERIOD = 2.0  # [s] between two samples
WARM_UP = 60.0  # [s] of a process's life before its growth counts
SPAN = 60.0  # [s] least time between the first and the last figures that are compared
ENDS = 20.0  # [s] over which the least value counts at either end: peaks are no growth
LIMITS = {"memory": (0.25, 40e6), "threads": (0.25, 12), "files": (0.25, 20)}  # share, absolute


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
    """(pid, memory [B], threads, open files) of a process, or None when it is gone."""
    try:
        files = len(os.listdir(f"/proc/{pid}/fd"))
        threads = len(os.listdir(f"/proc/{pid}/task"))
    except OSError:
        return None
    return pid, memory_bytes(pid), threads, files


def shared_bytes():
    """Bytes in use below /dev/shm."""
    try:
        return sum(entry.stat().st_size for entry in os.scandir("/dev/shm"))
    except OSError:
        return 0


class Watcher(threading.Thread):
    """Samples a session until it is stopped.

    Args:
        session: Session.
        begin: time.monotonic of the soak's begin.

    Attributes:
        samples: list of Sample.
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
                answer = self._session.watch.ask(what="sample")
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

    Args:
        samples: list of Sample of one session.

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


def neighbours(samples):
    """Pairs of samples one after the other, without those with a reset between them."""
    return [
        (before, after)
        for before, after in zip(samples, samples[1:])
        if after.simulated >= before.simulated
    ]


def pace(before, after):
    """Simulated seconds per wall second between two samples."""
    return (after.simulated - before.simulated) / (after.wall - before.wall)


def paces(samples):
    """(wall time, pace) of neighbours."""
    return [(after.wall, pace(before, after)) for before, after in neighbours(samples)]


def rates(samples, topic):
    """(wall time, messages per wall second) of a topic."""
    return [
        (after.wall, (after.counts[topic] - before.counts[topic]) / (after.wall - before.wall))
        for before, after in zip(samples, samples[1:])
    ]
