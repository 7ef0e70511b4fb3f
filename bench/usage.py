"""Who had the processors between two moments: our processes by role, the others, the steal time.

Times are seconds. A process that has ended reads as nothing rather than as an error: it may end at
any time.
"""

import functools
import operator
import pathlib
import statistics
import sys
import time
from dataclasses import dataclass

import psutil

sys.path.append(str(pathlib.Path(__file__).resolve().parents[1]))

from commands import procfs  # noqa: E402

PROC = pathlib.Path("/proc")
ROLES = {"gazebo": "bridge", "relay_process": "relay", "worker": "render_worker"}


def cpu_seconds(pid):
    """User and system time of all threads of a process [s]; 0 when it has ended."""
    try:
        times = psutil.Process(pid).cpu_times()
    except psutil.Error:
        return 0.0
    return times.user + times.system


def memory_bytes(pid):
    """Proportional set size of a process (shared pages count by their fraction); 0 when ended."""
    try:
        return psutil.Process(pid).memory_full_info().pss
    except psutil.Error:
        return 0


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
    def read(cls):
        """Read it now."""
        now = psutil.cpu_times()
        return cls(now.user + now.nice + now.system + now.irq + now.softirq, now.steal)


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
        """Read /proc/PID/task/TID; None when it has ended, or the kernel has no schedstat."""
        folder = proc / str(pid) / "task" / str(tid)
        try:
            lines = (folder / "status").read_text(errors="replace").splitlines()
            times = (folder / "schedstat").read_text().split()
        except OSError:
            return None
        counts = dict(line.split(":", 1) for line in lines if ":" in line)
        if len(times) < 2 or "voluntary_ctxt_switches" not in counts:
            return None
        return cls(
            int(times[0]) * 1e-9,
            int(times[1]) * 1e-9,
            int(counts["voluntary_ctxt_switches"]),
            int(counts["nonvoluntary_ctxt_switches"]),
        )


def role_of(arguments):
    """A process's role by its command line: its node, module, script or program."""
    name = procfs.program(arguments) or "unknown"
    return ROLES.get(name, name)


def roles_of(pids):
    """Sort processes by role.

    Returns:
        dict of role -> list of pids. Processes that have ended, or never had a command line, are
        left out.
    """
    found = {}
    for pid in pids:
        arguments = procfs.arguments(pid)
        if arguments:
            found.setdefault(role_of(arguments), []).append(pid)
    return found


@dataclass(frozen=True)
class Reading:
    """One moment.

    Attributes:
        time: wall time [s].
        cpu: dict of role -> processor time [s].
        threads: dict of name -> Thread, or None where one has ended.
    """

    time: float
    machine: Machine
    cpu: dict
    threads: dict


class Monitor:
    """Reads what some processes and the machine have spent.

    Args:
        roles: dict of role -> list of pids.
        threads: dict of name -> (pid, tid) of threads to look at.
        now: clock [s].
    """

    def __init__(self, roles, threads=(), now=time.monotonic):
        self._roles, self._threads, self._now = roles, dict(threads), now

    def read(self):
        """Returns a Reading."""
        threads = {name: Thread.read(*ids) for name, ids in self._threads.items()}
        cpu = {role: sum(map(cpu_seconds, pids)) for role, pids in self._roles.items()}
        return Reading(self._now(), Machine.read(), cpu, threads)


def between(before, after):
    """What was spent from one Reading to the next.

    Returns:
        dict of seconds (wall time), cpu (role -> processors, 1 is one whole processor), others
        and stolen (processors), threads: name -> cpu, waited (processors) and switched_off,
        gave_up (involuntary and voluntary context switches per second).
    """
    seconds = after.time - before.time
    cpu = {role: (after.cpu[role] - before.cpu[role]) / seconds for role in after.cpu}
    busy = (after.machine.busy - before.machine.busy) / seconds
    return {
        "seconds": seconds,
        "cpu": cpu,
        "others": max(0.0, busy - sum(cpu.values())),
        "stolen": (after.machine.stolen - before.machine.stolen) / seconds,
        "threads": {
            name: _of_thread(before.threads[name], thread, seconds)
            for name, thread in after.threads.items()
            if thread is not None and before.threads[name] is not None
        },
    }


def _of_thread(before, after, seconds):
    return {
        "cpu": (after.cpu - before.cpu) / seconds,
        "waited": (after.waited - before.waited) / seconds,
        "switched_off": (after.involuntary - before.involuntary) / seconds,
        "gave_up": (after.voluntary - before.voluntary) / seconds,
    }


def spent_within(monitor, begin, seconds):
    """Wait for a window and return what was spent in it, as summarise() gives it of one round.

    Args:
        monitor: Monitor.
        begin: of the window, as of time.monotonic() [s]; it lasts some seconds.
    """
    time.sleep(max(0.0, begin - time.monotonic()))
    reading = monitor.read()
    time.sleep(max(0.0, begin + seconds - time.monotonic()))
    return summarise([between(reading, monitor.read())])


def summarise(rounds):
    """Medians over rounds of what between() gave, and the most of others and stolen.

    Args:
        rounds: list of what between() gave, with the same roles and threads; not empty.
    """

    first = rounds[0]
    summary = {"cpu": {role: _median(rounds, "cpu", role) for role in first["cpu"]}}
    for name in ("others", "stolen"):
        summary[name] = _median(rounds, name)
        summary[f"{name}_most"] = max(one_round[name] for one_round in rounds)
    summary["threads"] = {
        thread: {name: _median(rounds, "threads", thread, name) for name in values}
        for thread, values in first["threads"].items()
        if all(thread in one_round["threads"] for one_round in rounds)
    }
    return summary


def _median(rounds, *keys):
    """The median of one value that lies in each round under keys within keys."""
    return statistics.median(
        functools.reduce(operator.getitem, keys, one_round) for one_round in rounds
    )
