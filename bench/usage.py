"""Who had the processors between two moments: our processes by role, the others, the thief."""

import functools
import operator
import os
import statistics
import time
from dataclasses import dataclass

from processes import PROC, Machine, Thread, arguments_of, cpu_seconds

ROLES = {"gazebo": "bridge", "relay_process": "relay", "worker": "render_worker"}


def role_of(arguments):
    """A process's role by its command line: its node, module, script or program.

    Args:
        arguments: the command line as a list.
    """
    for argument in arguments:
        if argument.startswith("__name:="):
            name = argument.removeprefix("__name:=")
            break
    else:
        if "-m" in arguments[:-1]:
            name = arguments[arguments.index("-m") + 1].rpartition(".")[2]
        else:
            names = [
                os.path.basename(argument) for argument in arguments if not argument.startswith("-")
            ]
            programs = [name for name in names if not name.startswith("python")]
            name = (programs or names or ["unknown"])[0].removesuffix(".py")
    return ROLES.get(name, name)


def roles_of(pids, proc=PROC):
    """Sort processes by role.

    Returns:
        dict of role -> list of pids. Processes that are gone, or never had a command line, are
        left out.
    """
    found = {}
    for pid in pids:
        arguments = arguments_of(pid, proc)
        if arguments:
            found.setdefault(role_of(arguments), []).append(pid)
    return found


@dataclass(frozen=True)
class Reading:
    """One moment.

    Attributes:
        time: wall time [s].
        machine: Machine.
        cpu: dict of role -> processor time [s].
        threads: dict of name -> Thread, or None where one is gone.
    """

    time: float
    machine: Machine
    cpu: dict
    threads: dict


class Watch:
    """Reads what some processes and the machine have spent.

    Args:
        roles: dict of role -> list of pids.
        threads: dict of name -> (pid, tid) of threads to look at.
        proc: folder of /proc.
        now: clock [s].
    """

    def __init__(self, roles, threads=(), proc=PROC, now=time.monotonic):
        self._roles, self._threads, self._proc, self._now = roles, dict(threads), proc, now

    def read(self):
        """Returns a Reading."""
        threads = {name: Thread.read(*ids, proc=self._proc) for name, ids in self._threads.items()}
        return Reading(
            self._now(),
            Machine.read(self._proc),
            {
                role: sum(cpu_seconds(pid, self._proc) for pid in pids)
                for role, pids in self._roles.items()
            },
            threads,
        )


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


def summarise(turns):
    """Medians over turns of what between() gave, and the most of others and stolen.

    Args:
        turns: list of what between() gave, with the same roles and threads; not empty.
    """

    first = turns[0]
    summary = {"cpu": {role: _median(turns, "cpu", role) for role in first["cpu"]}}
    for name in ("others", "stolen"):
        summary[name] = _median(turns, name)
        summary[f"{name}_most"] = max(turn[name] for turn in turns)
    summary["threads"] = {
        thread: {name: _median(turns, "threads", thread, name) for name in values}
        for thread, values in first["threads"].items()
        if all(thread in turn["threads"] for turn in turns)
    }
    return summary


def _median(turns, *keys):
    """The median of one value that lies in each turn under keys within keys."""
    return statistics.median(functools.reduce(operator.getitem, keys, turn) for turn in turns)
