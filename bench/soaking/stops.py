"""./run world, stopped in each state by each signal: what is left, and how long it took."""

import os
import pathlib
import random
import signal
import time

from figures import BenchError

from soaking.marked import send
from soaking.observer import Observer
from soaking.session import BENCH, START_LIMIT
from soaking.subject import Subject

PROMISE = 5.0  # [s] from the signal until nothing is left, on a machine with nothing else to do
LIMIT = 30.0  # [s] after which it is not waited for any more
SIGNALS = ("SIGINT", "SIGTERM", "SIGHUP", "SIGKILL")
STATES = ("setting up", "spawning", "running", "paused", "stepping", "free running")


class World(Subject):
    """One ./run world on a master of its own.

    Args:
        folder: pathlib.Path for logs and temporary files, made anew.

    Attributes:
        process: subprocess.Popen of ./run.
    """

    def __init__(self, folder):
        super().__init__(folder, "world.log")
        self._hands = self.process = None

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
        self._hands = Observer("soak_hands", self.environment, self._log)
        self.ask(what="ready", namespaces=["/racecar"])
        if state in ("paused", "stepping"):
            self.ask(what="empty", service="pause_physics")
        if state == "stepping":
            self._hands.tell(what="step", count=1_000_000)
            time.sleep(0.5)
        if state == "free running":
            self.ask(what="pace", factor=0.0)

    def ask(self, **question):
        """Has the hands do something; returns their answer.

        Raises:
            BenchError: They could not.
        """
        answer = self._hands.ask(limit=START_LIMIT, **question)
        if "error" in answer:
            raise BenchError(answer["error"])
        return answer

    def stop(self, name):
        """Sends a signal by its name; returns what is left, see ended()."""
        send(self.process.pid, getattr(signal, name))
        return self.ended(time.monotonic(), LIMIT)

    def close(self):
        """Ends everything."""
        if self._hands is not None:
            self._hands.close()
        super().close()


def shared():
    """Names in /dev/shm."""
    return set(os.listdir("/dev/shm"))


def promise():
    """Longest time to end [s]: longer where every processor has more than one process to run."""
    return PROMISE * max(1.0, os.getloadavg()[0] / len(os.sched_getaffinity(0)))


def one(folder, state, name, seed):
    """One world, from start to stop.

    Returns:
        dict: state, signal, seconds, left, files, shared (names that are new in /dev/shm) and
        problem ('' when all was kept).
    """
    before, world = shared(), World(pathlib.Path(folder))
    try:
        world.start()
        world.reach(state, random.Random(seed))
        found = world.stop(name)
    except BenchError as error:
        return {"state": state, "signal": name, "seconds": 0.0, "problem": str(error)}
    finally:
        world.close()
    found.update(state=state, signal=name, shared=sorted(shared() - before), problem="")
    if found["left"]:
        found["problem"] = f"left {found['left']}"
    elif found["seconds"] > promise():
        found["problem"] = f"took {found['seconds']:.1f} s"
    elif found["files"] and name != "SIGKILL":
        found["problem"] = f"left files {found['files']}"
    elif found["shared"]:
        found["problem"] = f"left shared memory {found['shared']}"
    return found


def run(count, seed, folder, say):
    """Stops a number of worlds, each state and signal in turn.

    Args:
        count: How many.
        seed: Of the moments.
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
        words = f"FAILED {last['problem']}" if last["problem"] else f"{last['seconds']:.1f} s"
        say(f"{number + 1:4} {state}, {name}: {words}")
    return results
