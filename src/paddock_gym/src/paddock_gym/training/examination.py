"""Laps from unseen starts between updates of a training, which may end when all of them succeed."""

import numpy as np

from paddock_gym.course import LAP
from paddock_gym.evaluation.laps import starts

STARTS = 10  # of an examination, and of the evaluation at the end


def all_laps(model, env, stop):
    """Drive from the starts, until a run fails.

    Args:
        model: PPO; its most probable actions drive.
        env: VecEnv of DeepRacers; their runs end.
        stop: function without arguments: whether to give up.

    Returns:
        Whether all were laps, actions of the worlds together.
    """
    chosen, count, taken = starts(STARTS), env.num_envs, 0
    for first in range(0, STARTS, count):
        group = chosen[first : first + count]
        driving = np.arange(count) < len(group)
        env.set_options([*group, *[group[-1]] * (count - len(group))])
        observations = env.reset()
        while driving.any():
            actions, _ = model.predict(observations, deterministic=True)
            observations, _, over, infos = env.step(actions)
            taken += count
            ended = driving & over
            if stop() or any(infos[index]["end"] != LAP for index in np.flatnonzero(ended)):
                return False, taken
            driving &= ~ended
    return True, taken
