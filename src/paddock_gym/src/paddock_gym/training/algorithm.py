"""PPO of stable-baselines3 as the workers and a hyperparameters.json want it."""

import math

import numpy as np
from stable_baselines3 import PPO
from torch.nn import functional

from paddock_gym.contract import hyperparameters
from paddock_gym.training.workers import Workers

FEWEST, MOST = 16, 4096  # actions of each worker between updates


def of(settings, workers):
    """The class of a training's algorithm.

    Args:
        settings: Settings.
        workers: Workers or RayWorkers.
    """
    base = PPO
    if not isinstance(workers, Workers):
        from paddock_gym.training.actors.ppo import RayPPO

        base = RayPPO
    if not settings.hyperparameters:
        return base
    given = hyperparameters.load(settings.hyperparameters)
    parts = [base]
    if given.loss_type == "huber":
        parts.insert(0, Huber)
    if given.num_episodes_between_training:
        parts.insert(0, Paced)
    runs = given.num_episodes_between_training
    return type("PPO", tuple(parts), {"runs": runs}) if len(parts) > 1 else base


class Huber:
    """PPO whose value function has the Huber loss, as loss_type of DeepRacer asks for."""

    def train(self):
        """One update."""
        squared, functional.mse_loss = functional.mse_loss, functional.smooth_l1_loss
        try:
            super().train()
        finally:
            functional.mse_loss = squared


class Paced:
    """PPO with an update after some runs, as num_episodes_between_training of DeepRacer asks for.

    All workers take equally many actions between updates, as many as these runs take by the mean
    length of the last hundred; so their number is met on average, not each time.

    Attributes:
        runs: between updates.
    """

    runs = None

    def collect_rollouts(self, env, callback, rollout_buffer, n_rollout_steps):
        """Collect what these runs take."""
        lengths = [run["l"] for run in self.ep_info_buffer or ()]
        if lengths:
            least = max(FEWEST, math.ceil(self.batch_size / env.num_envs))
            steps = math.ceil(self.runs * np.mean(lengths) / env.num_envs)
            self.n_steps = n_rollout_steps = int(min(MOST, max(least, steps)))
        if n_rollout_steps != rollout_buffer.buffer_size:
            rollout_buffer.buffer_size = n_rollout_steps  # reset() makes it anew
        return super().collect_rollouts(env, callback, rollout_buffer, n_rollout_steps)
