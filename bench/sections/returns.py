"""What drivers reach in Paddock/DeepRacer-v1 as it is made by default: baselines for learning.

All drive from the same starts. Trainings are as of ./run train first, each with another seed; where
its packages are not installed they are left out.
"""

import importlib.util
import json
import os
import subprocess
import sys
import tempfile

import numpy as np
from figures import Spread
from report import Row

from commands.subcommands import train

STARTS = 20
SEEDS = range(20, 25)  # of trainings; the settings were found with others
FIGURES = {"return": "m", "length": "actions", "laps": f"of {STARTS}"}  # of a driver


class Random:
    """Actions by chance."""

    def __init__(self):
        self._rng = np.random.default_rng(0)

    def restart(self):
        """Goes on."""

    def act(self, _observation, env):
        """Any of the action space."""
        space = env.action_space
        return self._rng.uniform(space.low, space.high).astype(space.dtype)


def runs_of(driver):
    """Returns and lengths of a driver's runs, and how many were laps."""
    from paddock_gym.course import LAP
    from paddock_gym.envs.deepracer import DeepRacerEnv
    from paddock_gym.evaluation.laps import starts

    env, found = DeepRacerEnv(), {"return": [], "length": [], "laps": 0}
    for seed, start in enumerate(starts(STARTS)):
        observation, info = env.reset(seed=seed, options=start)
        driver.restart()
        total, length, done = 0.0, 0, False
        while not done:
            action = driver.act(observation, env)
            observation, reward, terminated, truncated, info = env.step(action)
            total, length, done = total + reward, length + 1, terminated or truncated
        found["return"].append(total)
        found["length"].append(length)
        found["laps"] += info["end"] == LAP
    env.close()
    return found


def trained(seed, log):
    """Runs of the policy of a training, with its number of actions and seconds."""
    from paddock_gym.evaluation.laps import PolicyDriver

    with tempfile.TemporaryDirectory() as folder:
        table = {
            "name": "bench", "folder": os.path.join(folder, "bench"), "resume": False,
            "workers": train.WORLDS, "seed": seed, "threads": True, "until_laps": True,
        }  # fmt: skip
        words = [sys.executable, "-m", "paddock_gym.training.cli", json.dumps(table)]
        subprocess.run(words, check=True, stdout=log, stderr=log)
        with open(os.path.join(table["folder"], "report.json"), encoding="utf-8") as stream:
            steps = json.load(stream)["steps"]
        policy = PolicyDriver(os.path.join(table["folder"], "policy.onnx"))
        return {**runs_of(policy), "steps": steps}


def measure(quick, log):
    """Each driver's runs."""
    from paddock_gym.evaluation.laps import DRIVERS

    figures = {"random": runs_of(Random())}
    figures.update((name, runs_of(make())) for name, make in DRIVERS.items())
    if importlib.util.find_spec("stable_baselines3"):
        seeds = SEEDS[:1] if quick else SEEDS
        figures["trained"] = [trained(seed, log) for seed in seeds]
    return figures


def rows(figures):
    """Of each driver: return, length, laps; of trainings the seeds' means."""
    for driver, found in figures.items():
        seeds = isinstance(found, list)
        for name, unit in FIGURES.items():
            values = [np.mean(each[name]) for each in found] if seeds else np.ravel(found[name])
            spread = Spread.of(map(float, values))
            yield Row(f"{driver}, {name}", f"{spread.text()} {unit}", spread, unit)
        if seeds:
            steps = Spread.of(float(each["steps"]) for each in found)
            yield Row(f"{driver}, actions learned from", f"{steps.text()}", steps, "actions")
