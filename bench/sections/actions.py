"""Actions a second of the learner's environments, absolute and of a core, by what is observed.

Paddock/Robot-v0 is the cart of the package's examples, in an empty world; Paddock/DeepRacer-v1 is
as it is made by default (lidar: between walls). A constant action, 10 and 15 times a simulated
second; runs that end start anew. Of a core: over the processor time of all threads.
"""

import importlib.metadata
import os
import pathlib
import time

import numpy as np
from figures import Spread
from report import Row
from usage import Monitor, between, summarise

CART = pathlib.Path(__file__).parents[2] / "src" / "paddock_gym" / "examples" / "cart.urdf"
ON_GROUND = (0.0, 0.0, 0.1, 0.0, 0.0, 0.0)
WORLDS = (1, 8)
KINDS = {  # environment -> observation in words -> options
    "Robot-v0": {
        "state": {"observation": "odom"},
        "lidar of 24 rays": {"observation": "scan"},
        "camera of 64x48": {"observation": "camera/image_raw"},
    },
    "DeepRacer-v1": {
        "state": {"observation": "state"},
        "lidar of 64 rays": {"observation": "lidar", "walls": True},
        "camera of 160x120": {"observation": "camera"},
    },
}
ROUNDS, SECONDS = 9, 2.0  # wall time of a round
QUICK_ROUNDS, QUICK_SECONDS = 3, 0.5
FIRST = 20  # actions before the first round
PACKAGES = ("gymnasium", "numpy", "numba", "moderngl")


class Subject:
    """One environment, or several side by side in threads.

    Args:
        name: of KINDS.
        worlds: how many.
        options: of each.
    """

    def __init__(self, name, worlds, options):
        from paddock_gym.envs.deepracer import DeepRacerEnv
        from paddock_gym.envs.robot import RobotEnv
        from paddock_gym.envs.worlds import RobotWorldsEnv, WorldsEnv

        one, several = {
            "Robot-v0": (RobotEnv, RobotWorldsEnv),
            "DeepRacer-v1": (DeepRacerEnv, WorldsEnv),
        }[name]
        robot = {"urdf": str(CART), "pose": ON_GROUND} if name == "Robot-v0" else {}
        options = {**robot, **options}
        self.worlds = worlds
        self.env = one(**options) if worlds == 1 else several(worlds, **options)
        action = np.array((0.3, 0.5) if robot else (0.2, -0.6), np.float32)
        self._action = action if worlds == 1 else np.tile(action, (worlds, 1))
        self.env.reset(seed=0)
        self.act(FIRST)

    def act(self, count):
        """Take actions in each world."""
        for _ in range(count):
            _, _, terminated, truncated, _ = self.env.step(self._action)
            if self.worlds == 1 and (terminated or truncated):
                self.env.reset()

    def one_round(self, seconds):
        """Actions of all worlds a second, and a second of processor time, in some wall time."""
        done, start, spent = 0, time.perf_counter(), time.process_time()
        while time.perf_counter() - start < seconds:
            self.act(5)
            done += 5 * self.worlds
        took = time.perf_counter() - start
        return done / took, done / (time.process_time() - spent)


def measure(quick, log):
    """Rates of each environment, observation and number of worlds, one after the other."""
    rounds, seconds = (QUICK_ROUNDS, QUICK_SECONDS) if quick else (ROUNDS, SECONDS)
    monitor, found = Monitor({"bench": [os.getpid()]}), {}
    for name, kinds in KINDS.items():
        for kind, options in kinds.items():
            for worlds in WORLDS:
                subject, rates, spent = Subject(name, worlds, options), [], []
                try:
                    for _ in range(rounds):
                        before = monitor.read()
                        rates.append(subject.one_round(seconds))
                        spent.append(between(before, monitor.read()))
                finally:
                    subject.env.close()
                wall, core = (Spread.of(each).figures() for each in zip(*rates))
                label = f"{name}, {kind}, {worlds} world{'s' * (worlds > 1)}"
                found[label] = {"wall": wall, "core": core, "spent": summarise(spent)}
                print(f"actions: {label}: {wall['median']:.0f}", file=log, flush=True)
    return {"rates": found, "versions": versions()}


def versions():
    """Of the packages that the rates depend on: name -> version."""
    names = {each.metadata["Name"].lower() for each in importlib.metadata.distributions()}
    return {name: importlib.metadata.version(name) for name in PACKAGES if name in names}


def rows(figures):
    """Rates of each, and the versions."""
    for label, found in figures["rates"].items():
        for name, text in (("wall", ""), ("core", ", of a core")):
            rate = Spread.read(found[name])
            yield Row(label + text, f"{rate.text('.0f')} actions a s", rate, "actions/s")
    yield Row("versions", ", ".join(f"{name} {text}" for name, text in figures["versions"].items()))
