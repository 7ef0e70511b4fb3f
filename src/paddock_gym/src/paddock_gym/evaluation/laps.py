"""Laps of a driver in the environment, from given starts."""

import math
from dataclasses import dataclass

import numpy as np

from paddock_gym.course.judge import LAP

FIRST_SEED = 10_000  # of the starts; training uses others
SIDE, TURN = 0.15, math.radians(10.0)  # largest offset [m] and turn of a start


@dataclass(frozen=True)
class Lap:
    """One start.

    Attributes:
        start: share of the track.
        end: why it ended: lap, off_track, crashed, stuck or reversed.
        progress: [%].
        time: simulated [s].
        way: (N, 3) x, y [m], forward speed [m/s] after each action.
        rms_lateral, max_lateral: distance from the centreline [m].
    """

    start: float
    end: str
    progress: float
    time: float
    way: np.ndarray
    rms_lateral: float
    max_lateral: float

    @property
    def is_lap(self):
        """Whether it was a whole lap."""
        return self.end == LAP


def starts(count, seed=FIRST_SEED):
    """Starts for reset(options=...): count places at random, beside the centreline and turned."""
    rng = np.random.default_rng(seed)
    return [
        {
            "start": float(rng.uniform(0.0, 1.0)),
            "lateral": float(rng.uniform(-SIDE, SIDE)),
            "turn": float(rng.uniform(-TURN, TURN)),
        }
        for _ in range(count)
    ]


def drive(env, driver, start, seed=0, each=None):
    """Drive once.

    Args:
        env: DeepRacerEnv.
        driver: has act(observation, env) -> action, and restart().
        start: of starts().
        seed: of noise.
        each: called without arguments after every action; for films.

    Returns:
        Lap.
    """
    observation, info = env.reset(seed=seed, options=start)
    driver.restart()
    way, lateral, done = [], [], False
    while not done:
        observation, _, terminated, truncated, info = env.step(driver.act(observation, env))
        done = terminated or truncated
        motion = env.run.motion
        way.append((motion.x, motion.y, motion.forward))
        lateral.append(info["lateral"])
        if each:
            each()
    return Lap(
        start["start"],
        info["end"],
        info["progress"],
        info["time"],
        np.array(way),
        float(np.sqrt(np.mean(np.square(lateral)))),
        float(np.max(np.abs(lateral))),
    )
