"""Actions a second of the learner's environments, over bare stepping and bare images; no ROS.

The car drives round a ring by one action that never changes. Bare stepping is that of the same
engine with the same car on the same circle: nothing but PyBullet's steps.
"""

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
        engine, count = self.env.scene.world.engine, self.env.scene.substeps
        for _ in range(ACTIONS):
            engine.step(count)
        return ACTIONS

    def images(self):
        """Draw some images and nothing else; returns how many."""
        for _ in range(ACTIONS):
            self.env.run.camera.image()
        return ACTIONS

    def restart(self):
        """After bare steps: back onto the ring."""
        self.env.reset()
        self.actions()


def measure(quick, _log):
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
            if circling.env.run.camera is not None:
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
                figures["renderer"] = circling.env.scene.renderer.backend
            circling.env.close()
        figures["two_processes"] = alternate(
            lambda: together(1, track), {"two": lambda: together(2, track)}, pairs_of(quick)
        )["two"].figures()
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
