"""Algorithms of the training and their networks.

Feature extraction: images are halved, then go through three small convolutions, a tenth of the
work of the network of Mnih et al. (2015) on 160x120 pixels, thousands of times a second.
"""

import math

import numpy as np
import torch
from gymnasium import spaces
from stable_baselines3 import PPO
from stable_baselines3.common.preprocessing import is_image_space
from stable_baselines3.common.torch_layers import BaseFeaturesExtractor
from torch import nn
from torch.nn import functional

from paddock_gym.contract import hyperparameters
from paddock_gym.training.workers import Threads, Workers

IMAGE_FEATURES = 128


def image_layers(space):
    """Layers from images (N, C, H, W) of 0 to 1 to (N, IMAGE_FEATURES)."""
    convolutions = nn.Sequential(
        nn.AvgPool2d(2),
        nn.Conv2d(space.shape[0], 16, 5, stride=2),
        nn.ReLU(),
        nn.Conv2d(16, 32, 3, stride=2),
        nn.ReLU(),
        nn.Conv2d(32, 32, 3, stride=2),
        nn.ReLU(),
        nn.Flatten(),
    )
    with torch.no_grad():
        count = convolutions(torch.zeros(1, *space.shape)).shape[1]
    return nn.Sequential(convolutions, nn.Linear(count, IMAGE_FEATURES), nn.ReLU())


class Features(BaseFeaturesExtractor):
    """Features of one observation or of a dict of them, concatenated.

    Args:
        observation_space: of the environment, images as (C, H, W).
    """

    def __init__(self, observation_space):
        several = isinstance(observation_space, spaces.Dict)
        parts = observation_space.spaces if several else {"": observation_space}
        images = {name for name, space in parts.items() if is_image_space(space)}
        size = sum(
            IMAGE_FEATURES if name in images else spaces.flatdim(space)
            for name, space in parts.items()
        )
        super().__init__(observation_space, size)
        self._several = several
        self.layers = nn.ModuleDict(
            {
                name or "only": image_layers(space) if name in images else nn.Flatten()
                for name, space in parts.items()
            }
        )

    def forward(self, observations):
        """Features (N, size) of observations."""
        if not self._several:
            return self.layers["only"](observations)
        return torch.cat([layer(observations[name]) for name, layer in self.layers.items()], dim=1)


MIN_STEPS, MAX_STEPS = 16, 4096  # actions of each worker between updates


def of(settings, workers):
    """The class of a training's algorithm.

    Args:
        workers: Workers, Threads or RayWorkers.
    """
    base = PPO
    if not isinstance(workers, (Workers, Threads)):
        from paddock_gym.training.ray_actors import RayPPO

        base = RayPPO
    if not settings.hyperparameters:
        return base
    parameters = hyperparameters.load(settings.hyperparameters)
    parts = [base]
    if parameters.loss_type == "huber":
        parts.insert(0, Huber)
    if parameters.num_episodes_between_training:
        parts.insert(0, Paced)
    runs = parameters.num_episodes_between_training
    return type("PPO", tuple(parts), {"runs": runs}) if len(parts) > 1 else base


class Huber:
    """PPO whose value function has the Huber loss, as DeepRacer's loss_type requests."""

    def train(self):
        """One update."""
        squared, functional.mse_loss = functional.mse_loss, functional.smooth_l1_loss
        try:
            super().train()
        finally:
            functional.mse_loss = squared


class Paced:
    """PPO with an update after some runs, as DeepRacer's num_episodes_between_training.

    All workers take equally many actions between updates: as many as these runs take by the mean
    length of the last hundred. The number of runs is thus exact on average only.

    Attributes:
        runs: between updates.
    """

    runs = None

    def collect_rollouts(self, env, callback, rollout_buffer, n_rollout_steps):
        """Collect as many actions as these runs take."""
        lengths = [run["l"] for run in self.ep_info_buffer or ()]
        if lengths:
            minimum = max(MIN_STEPS, math.ceil(self.batch_size / env.num_envs))
            steps = math.ceil(self.runs * np.mean(lengths) / env.num_envs)
            self.n_steps = n_rollout_steps = int(min(MAX_STEPS, max(minimum, steps)))
        if n_rollout_steps != rollout_buffer.buffer_size:
            rollout_buffer.buffer_size = n_rollout_steps  # reset() allocates it
        return super().collect_rollouts(env, callback, rollout_buffer, n_rollout_steps)
