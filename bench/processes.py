"""What processes, threads and the machine spend, read from /proc.

All functions take the folder that /proc is mounted on; times are seconds. A process that has gone
reads as nothing rather than as an error: it may end at any time.
"""

import os
import pathlib
from dataclasses import dataclass

PROC = pathlib.Path("/proc")
TICK = os.sysconf("SC_CLK_TCK")  # of the times in /proc [1/s]


def _text(path):
    try:
        return path.read_text(errors="replace")
    except OSError:
        return ""


def _stat(pid, proc=PROC):
    """Fields of /proc/PID/stat from the state on (field 3 of proc(5)); empty when it is gone."""
    return _text(proc / str(pid) / "stat").rpartition(")")[2].split()


def cpu_seconds(pid, proc=PROC):
    """User and system time of all threads of a process [s]; 0 when it is gone."""
    fields = _stat(pid, proc)
    return (int(fields[11]) + int(fields[12])) / TICK if fields else 0.0


def memory_bytes(pid, proc=PROC):
    """Proportional set size of a process (shared pages count by their share); 0 when gone."""
    for line in _text(proc / str(pid) / "smaps_rollup").splitlines():
        if line.startswith("Pss:"):
            return int(line.split()[1]) * 1024
    return 0


def arguments_of(pid, proc=PROC):
    """Command line of a process as a list; empty when it is gone."""
    return _text(proc / str(pid) / "cmdline").split("\0")[:-1]


def descendants(pid, proc=PROC):
    """Pids of the children of a process and theirs."""
    children = {}
    for entry in os.listdir(proc):
        fields = _stat(entry, proc) if entry.isdigit() else []
        if fields:
            children.setdefault(int(fields[1]), []).append(int(entry))
    found, open_ends = [], [pid]
    while open_ends:
        new = children.get(open_ends.pop(), [])
        found += new
        open_ends += new
    return found


@dataclass(frozen=True)
class Machine:
    """Processor time of the whole machine since it started [s], over all processors.

    Attributes:
        busy: of all processes and the kernel, without what was stolen.
        stolen: that another virtual machine had while a process here was ready to run.
    """

    busy: float
    stolen: float

    @classmethod
    def read(cls, proc=PROC):
        """Read /proc/stat.

        Raises:
            ValueError: its first line is not the sum over processors.
        """
        first = _text(proc / "stat").partition("\n")[0].split()
        if len(first) < 9 or first[0] != "cpu":
            raise ValueError(
                f"{proc}/stat begins with {' '.join(first)!r}, not with the nine times of 'cpu'"
            )
        user, nice, system, _idle, _iowait, irq, soft, stolen = map(int, first[1:9])
        return cls((user + nice + system + irq + soft) / TICK, stolen / TICK)


@dataclass(frozen=True)
class Thread:
    """Of one thread since it started.

    Attributes:
        cpu: time on a processor [s].
        waited: time it was ready to run while others had the processors [s].
        voluntary: context switches when it waited for something.
        involuntary: context switches when something else took its processor.
    """

    cpu: float
    waited: float
    voluntary: int
    involuntary: int

    @classmethod
    def read(cls, pid, tid, proc=PROC):
        """Read /proc/PID/task/TID; None when it is gone, or the kernel keeps no schedstat."""
        folder = proc / str(pid) / "task" / str(tid)
        counts = dict(
            line.split(":", 1) for line in _text(folder / "status").splitlines() if ":" in line
        )
        times = _text(folder / "schedstat").split()
        if len(times) < 2 or "voluntary_ctxt_switches" not in counts:
            return None
        return cls(
            int(times[0]) * 1e-9,
            int(times[1]) * 1e-9,
            int(counts["voluntary_ctxt_switches"]),
            int(counts["nonvoluntary_ctxt_switches"]),
        )
