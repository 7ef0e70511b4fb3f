"""./run world, stopped in each state by each signal: what is left, and how long it took."""

import os
import pathlib
import random
import signal
import statistics
import time

from figures import BenchError
from launching import BENCH, Observer
from usage import procfs

from soaking.limits import latest, violation
from soaking.process_under_test import ProcessesUnderTest
from soaking.session import START_LIMIT

LIMIT = 30.0  # [s] after which it is not waited for any more, see wait_ended()
ESCALATED = "escalating to SIGTERM"  # as roslaunch says
SIGNALS = ("SIGINT", "SIGTERM", "SIGHUP", "SIGKILL")
STATES = ("setting up", "spawning", "running", "paused", "stepping", "free running")


class World(ProcessesUnderTest):
    """One ./run world on a master of its own.

    Args:
        folder: pathlib.Path for logs and temporary files, emptied first.
    """

    def __init__(self, folder):
        super().__init__(folder, "world.log")
        self._operator = self.process = None

    def start(self):
        """Starts ./run world."""
        self.process = self.popen(str(BENCH.parent / "run"), "world")

    def reach(self, state, rng):
        """Brings it into a state.

        Raises:
            BenchError: It does not come up.
        """
        if state == "setting up":
            time.sleep(rng.uniform(0.05, 2.0))
            return
        end = time.monotonic() + START_LIMIT
        while "bridge" not in self.roles():
            if self.process.poll() is not None or time.monotonic() > end:
                raise BenchError("the world does not come up")
            time.sleep(0.1)
        if state == "spawning":
            time.sleep(rng.uniform(0.0, 5.0))
            return
        self._operator = Observer(self.environment, self._log, "soak.operator")
        self.ask(what="ready", namespaces=["/racecar"])
        if state in ("paused", "stepping"):
            self.ask(what="empty", service="pause_physics")
        if state == "stepping":
            self._operator.send(what="step", count=1_000_000)
            time.sleep(0.5)
        if state == "free running":
            self.ask(what="real_time_factor", factor=0.0)

    def ask(self, **question):
        """Makes the operator do something; returns its answer.

        Raises:
            BenchError: It could not.
        """
        return self._operator.request(limit=START_LIMIT, **question)

    def stop(self, name):
        """Sends a signal by its name; returns what wait_ended() does."""
        procfs.send(self.process.pid, getattr(signal, name))
        return self.wait_ended(LIMIT)

    def close(self):
        """Ends everything."""
        if self._operator is not None:
            self._operator.close()
        super().close()


def shared():
    """Names in /dev/shm."""
    return set(os.listdir("/dev/shm"))


def one(folder, state, name, seed):
    """One world, from start to stop.

    Returns:
        dict: state, signal, seconds, slowdown, lives (see Shutdown) and problem ('' when all limits
        were kept).
    """
    result = {"state": state, "signal": name, "seconds": 0.0, "slowdown": 1.0, "lives": []}
    before, world = shared(), World(pathlib.Path(folder))
    try:
        world.start()
        world.reach(state, random.Random(seed))
        found, files = world.stop(name)
    except BenchError as error:
        return {**result, "problem": str(error)}
    finally:
        world.close()
    problem = violation(found, () if name == "SIGKILL" else files)
    if not problem and ESCALATED in world.output():  # whatever the load: it waited 15 s for a node
        problem = f"took {found.seconds:.1f} s: roslaunch had to use SIGTERM; {latest(found.lives)}"
    new = sorted(shared() - before)
    if new and not problem:
        problem = f"left shared memory {new}"
    result.update(seconds=found.seconds, slowdown=found.slowdown, lives=found.lives)
    return {**result, "problem": problem}


def run(count, seed, folder, say):
    """Stops a number of worlds, each state and signal in turn.

    Args:
        folder: pathlib.Path for logs.
        say: Function of a line of progress.

    Returns:
        list of what one() gave.
    """
    cases = [(state, name) for name in SIGNALS for state in STATES]
    results = []
    for number in range(count):
        state, name = cases[number % len(cases)]
        results.append(one(folder / "stops" / str(number + 1), state, name, f"{seed}-{number}"))
        last = results[-1]
        text = f"{last['seconds']:.1f} s (x {last['slowdown']:.1f} by others)"
        text = f"FAILED {last['problem']}" if last["problem"] else text
        say(f"{number + 1:4} {state}, {name}: {text}; {latest(last['lives'], 2)}")
    return results


def table(results, signals):
    """Times by state and signal, in Markdown.

    Args:
        results: list of dict of state, signal, seconds, slowdown, lives and problem.

    Returns:
        Lines.
    """
    states = list(dict.fromkeys(result["state"] for result in results))
    lines = ["Median and longest time until nothing was left [s], by state and signal:", ""]
    lines += [f"| state | {' | '.join(signals)} | by others | ended last |"]
    lines += ["| --- |" + " --- |" * (len(signals) + 2)]
    for state in states:
        mine = [result for result in results if result["state"] == state and result["lives"]]
        cells = [_cell([r["seconds"] for r in mine if r["signal"] == name]) for name in signals]
        slow = f"x {statistics.median(r['slowdown'] for r in mine):.1f}" if mine else ""
        lines.append(f"| {state} | {' | '.join(cells)} | {slow} | {_last(mine)} |")
    return lines


def _cell(seconds):
    return f"{statistics.median(seconds):.1f}, {max(seconds):.1f}" if seconds else ""


def _last(results, count=4):
    """Median time of the roles that end last."""
    times = {}
    for result in results:
        for role, seconds in dict(result["lives"]).items():
            times.setdefault(role, []).append(seconds)
    medians = {role: statistics.median(found) for role, found in times.items()}
    order = sorted(medians, key=medians.get)[-count:]
    return ", ".join(f"{role} {medians[role]:.1f}" for role in order)
