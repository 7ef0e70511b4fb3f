"""Actions a second of the learner's environments, over bare stepping and bare images; no ROS.

The car drives round a ring by one action that never changes. Bare stepping is that of the same
engine with the same car on the same circle: nothing but the solver's steps. Eight worlds in one
process, by as many threads as there are processors, are beside one environment; and beside that of
another checkout, if the environment variable PADDOCK_BEFORE is its folder, built. Where ./run train
has installed its packages, trainings as of ./run train first are timed.
"""

import importlib.util
import json
import math
import os
import pathlib
import subprocess
import sys
import tempfile

import numpy as np
from figures import BenchError
from pairs import alternate, pairs_of, rate_of_work
from report import Row, ratio_row
from usage import Monitor

from commands.subcommands import train

RADIUS, WIDTH = 2.0, 1.4  # of the ring [m]
SPEED = 1.5  # [m/s]
SECONDS = 1.0  # of a round
ACTIONS = 20  # a call
KINDS = {
    "state": {"observation": "state"},
    "lidar_64_rays": {"observation": "lidar", "walls": True},
    "camera_160x120": {"observation": "camera"},
}
CHILD = "import sys; from sections.learning import child; child(*sys.argv[1:])"
WORLDS = 8  # side by side
SEEDS = range(10, 15)  # of trainings; the settings were found with others
# An environment of any version: its actions a second, by the lines of its input. It needs nothing
# of this folder, so that another checkout's can be compared.
BEFORE = f"""
import json, math, sys, time
import gymnasium, paddock_gym
options = json.loads(sys.argv[1])
env = gymnasium.make(paddock_gym.IDS[0], randomize=(), **options).unwrapped
env.reset(seed=0)
action = env.options.actions.action({SPEED}, math.atan(0.164 / {RADIUS}))
print("ready", flush=True)
for _ in sys.stdin:
    done, start = 0, time.perf_counter()
    while time.perf_counter() - start < {SECONDS}:
        for _ in range({ACTIONS}):
            if any(env.step(action)[2:4]):
                env.reset()
        done += {ACTIONS}
    print(done / (time.perf_counter() - start), flush=True)
"""


def ring(folder):
    """Path of a ring's track file in a folder."""
    angles = [2.0 * math.pi * k / 24 for k in range(24)]
    points = [[round(RADIUS * math.sin(t), 4), round(-RADIUS * math.cos(t), 4)] for t in angles]
    path = pathlib.Path(folder, "ring.yaml")
    path.write_text(f"points: {points}\nwidth: {WIDTH}\n")
    return str(path)


class Circling:
    """An environment whose car goes round and round.

    Args:
        track: of the ring.
        options: of the environment.
    """

    def __init__(self, track, **options):
        from paddock_gym.envs.deepracer import DeepRacerEnv

        self.env = DeepRacerEnv(track, randomize=(), **options)
        wheelbase = 0.164  # [m]
        actions = self.env.options.actions
        self._action = actions.action(SPEED, math.atan(wheelbase / RADIUS))
        self.env.reset(seed=0)
        self.actions()

    def actions(self):
        """Take some actions; returns how many."""
        for _ in range(ACTIONS):
            _, _, terminated, truncated, info = self.env.step(self._action)
            if terminated:
                raise BenchError(f"the car did not stay on the ring: {info['end']}")
            if truncated:
                self.env.reset()
        return ACTIONS

    def steps(self):
        """Do the physics steps of some actions and nothing else; returns of how many."""
        world = self.env.world.world
        engine, count = world.engine, round(self.env.period / world.time_step)
        for _ in range(ACTIONS):
            engine.step(count)
        return ACTIONS

    def images(self):
        """Draw some images and nothing else; returns how many."""
        for _ in range(ACTIONS):
            self.env.task.camera()
        return ACTIONS

    def restart(self):
        """After bare steps: back onto the ring."""
        self.env.reset()
        self.actions()


class Before:
    """An environment of another checkout, in a process of its own.

    Args:
        folder: of the checkout.
        options: of the environment.
    """

    def __init__(self, folder, **options):
        paths = [str(path) for path in sorted(pathlib.Path(folder).glob("src/*/src"))]
        self._process = subprocess.Popen(
            [sys.executable, "-c", BEFORE, json.dumps(options)],
            env=dict(os.environ, PYTHONPATH=os.pathsep.join(paths)), text=True,
            stdin=subprocess.PIPE, stdout=subprocess.PIPE,
        )  # fmt: skip
        if self._process.stdout.readline() != "ready\n":
            raise BenchError(f"the environment of {folder} did not start")

    def rate(self):
        """Actions a second of a round."""
        self._process.stdin.write("go\n")
        self._process.stdin.flush()
        return float(self._process.stdout.readline())

    def close(self):
        """End the process."""
        self._process.stdin.close()
        self._process.wait()
        self._process.stdout.close()


class Worlds:
    """Environments side by side, each of which goes round and round as Circling."""

    def __init__(self, track, **options):
        from paddock_gym.envs.worlds import WorldsEnv

        self.env = WorldsEnv(WORLDS, track=track, randomize=(), **options)
        action = self.env.envs[0].unwrapped.options.actions.action(SPEED, math.atan(0.164 / RADIUS))
        self._actions = np.tile(action, (WORLDS, 1))
        self.env.reset(seed=0)
        self.actions()

    def actions(self):
        """Take some actions; returns how many."""
        for _ in range(3):
            self.env.step(self._actions)
        return 3 * WORLDS


def side_by_side(track, options, quick):
    """Worlds side by side over one environment: of PADDOCK_BEFORE, else of this checkout."""
    folder = os.environ.get("PADDOCK_BEFORE") or pathlib.Path(__file__).resolve().parents[2]
    one, worlds = Before(folder, track=track, **options), Worlds(track, **options)
    try:
        return alternate(
            one.rate, {"worlds": lambda: rate_of_work(worlds.actions, SECONDS)}, pairs_of(quick)
        )["worlds"].figures()
    finally:
        one.close()
        worlds.env.close()


def memory():
    """[MB] of one more car, `state`."""
    import psutil

    with tempfile.TemporaryDirectory() as folder:
        first = Worlds(ring(folder))
        before = psutil.Process().memory_info().rss
        second = Worlds(ring(folder))
        grown = psutil.Process().memory_info().rss - before
        first.env.close(), second.env.close()
    return grown / WORLDS / 1e6


def trainings(quick, log):
    """Reports of trainings as of ./run train first, of several seeds and both kinds of workers."""
    found = []
    for seed in SEEDS[:1] if quick else SEEDS:
        for threads in (True, False):
            with tempfile.TemporaryDirectory() as folder:
                table = {
                    "name": "bench", "folder": os.path.join(folder, "bench"), "resume": False,
                    "workers": train.WORLDS if threads else train.max_processes(), "seed": seed,
                    "threads": threads, "until_laps": True,
                }  # fmt: skip
                words = [sys.executable, "-m", "paddock_gym.training.cli", json.dumps(table)]
                subprocess.run(words, check=True, stdout=subprocess.DEVNULL)
                report = json.loads(pathlib.Path(folder, "bench", "report.json").read_text())
                curve = pathlib.Path(folder, "bench", "episodes.csv").read_text().splitlines()
            columns = curve[0].split(",")
            time, end = columns.index("wall_time"), columns.index("end")
            laps = [row.split(",") for row in curve[1:]]
            found.append(
                {
                    "seed": seed,
                    "threads": threads,
                    "seconds": report["seconds_this_time"],
                    "steps": report["steps"],
                    "laps": report["laps"],
                    "mean_lap_time": report["mean_lap_time"],
                    "ten_laps_in_a_row_after": ten_in_a_row(
                        [(float(row[time]), row[end] == "lap") for row in laps]
                    ),
                }
            )
            print(f"learning: {found[-1]}", file=log, flush=True)
    return found


def ten_in_a_row(runs):
    """Time [s] of the tenth lap of the first ten in a row, or None.

    Args:
        runs: (time [s], whether it was a lap) of each run.
    """
    count = 0
    for seconds, lap in runs:
        count = count + 1 if lap else 0
        if count == 10:
            return seconds
    return None


def measure(quick, log):
    """Each kind of observation over bare stepping, the camera over bare images, two processes."""
    figures = {}
    with tempfile.TemporaryDirectory() as folder:
        track = ring(folder)
        for name, options in KINDS.items():
            circling = Circling(track, **options)
            monitor = Monitor({"bench": [os.getpid()]})

            def one_round(work, circling=circling):
                circling.restart()
                return rate_of_work(work, SECONDS)

            measured = alternate(
                lambda one_round=one_round, circling=circling: one_round(circling.steps),
                {name: lambda one_round=one_round, circling=circling: one_round(circling.actions)},
                pairs_of(quick),
                monitor,
            )
            figures[name] = measured[name].figures()
            if circling.env.task.camera is not None:
                figures["camera_over_bare_pictures"] = alternate(
                    lambda one_round=one_round, circling=circling: one_round(circling.images),
                    {
                        name: lambda one_round=one_round, circling=circling: one_round(
                            circling.actions
                        )
                    },
                    pairs_of(quick),
                    monitor,
                )[name].figures()
                figures["renderer"] = circling.env.world.cameras.renderer.backend
            circling.env.close()
            figures[f"worlds_{name}"] = side_by_side(track, options, quick)
        figures["before"] = os.environ.get("PADDOCK_BEFORE", "")
        figures["memory_of_a_car"] = memory()
        figures["two_processes"] = alternate(
            lambda: together(1, track), {"two": lambda: together(2, track)}, pairs_of(quick)
        )["two"].figures()
    if importlib.util.find_spec("stable_baselines3"):
        figures["trainings"] = trainings(quick, log)
    return figures


def together(count, track):
    """Actions a second of some processes side by side, in all."""
    here = pathlib.Path(__file__).resolve().parents[1]
    children = [
        subprocess.Popen(
            [sys.executable, "-c", CHILD, track], cwd=here, text=True,
            stdin=subprocess.PIPE, stdout=subprocess.PIPE,
        )
        for _ in range(count)
    ]  # fmt: skip
    try:
        for process in children:
            if process.stdout.readline() != "ready\n":
                raise BenchError("a process with an environment did not start")
        for process in children:
            process.stdin.write("go\n")
            process.stdin.flush()
        return float(np.sum([float(process.stdout.readline()) for process in children]))
    finally:
        for process in children:
            process.stdin.close()
            process.wait()
            process.stdout.close()


def child(track):
    """A process of together(): ready, then its actions a second."""
    circling = Circling(track)
    print("ready", flush=True)
    sys.stdin.readline()
    print(rate_of_work(circling.actions, SECONDS), flush=True)


def rows(figures):
    """Ratio of each kind."""
    for name in KINDS:
        yield ratio_row(f"gym, {name}", figures[name], "bare stepping", "actions per s")
    drawn = figures["camera_over_bare_pictures"]
    yield ratio_row("gym, camera over bare images", drawn, "bare images", "per s")
    yield Row("  renderer", figures["renderer"])
    yield ratio_row("gym, two processes", figures["two_processes"], "one", "actions per s")
    one = f"one of {figures['before']}" if figures["before"] else "one"
    for name in KINDS:
        worlds = figures[f"worlds_{name}"]
        yield ratio_row(f"gym, {name}, {WORLDS} worlds", worlds, one, "actions per s")
    grown = figures["memory_of_a_car"]
    yield Row("  memory of one more car", f"{grown:.1f} MB", grown, "MB")
    for found in figures.get("trainings", ()):
        kind = "threads" if found["threads"] else "processes"
        mean = found["mean_lap_time"]
        text = f"{found['laps']} of 10 laps after {found['seconds']:.0f} s, {found['steps']} steps"
        text += f", {mean:.2f} s a lap" if mean else ""
        if found["ten_laps_in_a_row_after"] is not None:
            text += f"; ten in a row after {found['ten_laps_in_a_row_after']:.0f} s"
        done = found["laps"] == 10
        name = f"./run train first, {kind}, seed {found['seed']}" + ("" if done else ", no 10 laps")
        yield Row(name, text, found["seconds"], "s")
