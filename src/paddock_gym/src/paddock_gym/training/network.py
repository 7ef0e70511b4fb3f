"""The part of the networks that makes features of observations.

Pictures are first halved, then go through three small convolutions: a tenth of the work of the
network of Mnih et al. (2015) on 160x120 pixels, which a processor has to do thousands of times a
second.
"""

import torch
from gymnasium import spaces
from stable_baselines3.common.preprocessing import is_image_space
from stable_baselines3.common.torch_layers import BaseFeaturesExtractor
from torch import nn

PICTURE_FEATURES = 128


def picture_layers(space):
    """Layers for pictures (N, C, H, W) of 0 to 1; give (N, PICTURE_FEATURES)."""
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
    return nn.Sequential(convolutions, nn.Linear(count, PICTURE_FEATURES), nn.ReLU())


class Features(BaseFeaturesExtractor):
    """Features of one observation or of a dict of them, side by side.

    Args:
        observation_space: of the environment, pictures as (C, H, W).
    """

    def __init__(self, observation_space):
        several = isinstance(observation_space, spaces.Dict)
        parts = observation_space.spaces if several else {"": observation_space}
        pictures = {name for name, space in parts.items() if is_image_space(space)}
        size = sum(
            PICTURE_FEATURES if name in pictures else spaces.flatdim(space)
            for name, space in parts.items()
        )
        super().__init__(observation_space, size)
        self._several = several
        self.layers = nn.ModuleDict(
            {
                name or "only": picture_layers(space) if name in pictures else nn.Flatten()
                for name, space in parts.items()
            }
        )

    def forward(self, observations):
        """Features (N, size) of observations."""
        if not self._several:
            return self.layers["only"](observations)
        return torch.cat([layer(observations[name]) for name, layer in self.layers.items()], dim=1)
