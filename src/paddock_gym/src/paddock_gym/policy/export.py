"""Writes a network of stable-baselines3 as an ONNX file."""

import onnx
import torch
from stable_baselines3.common.preprocessing import is_image_space

from paddock_gym.policy.description import KEY, OUTPUT

OPSET = 15


class _Deterministic(torch.nn.Module):
    """The deterministic action of an actor-critic policy, from unprocessed observations.

    Args:
        policy: of stable-baselines3's PPO.
        images: names of those that are images (H, W, C), which the network takes as (C, H, W).
        alone: the only one is no entry of a dict.
        bounds: lowest and highest action; None: they are discrete.
    """

    def __init__(self, policy, names, images, alone, bounds):
        super().__init__()
        self.policy, self._names, self._images, self._alone = policy, names, images, alone
        self._bounds = bounds and [torch.as_tensor(bound) for bound in bounds]

    def forward(self, *arrays):
        inputs = {}
        for name, array in zip(self._names, arrays):
            if name in self._images:
                array = array.permute(0, 3, 1, 2).to(torch.float32) / 255.0
            inputs[name] = array
        observation = next(iter(inputs.values())) if self._alone else inputs
        extractor = self.policy.features_extractor
        latent = self.policy.mlp_extractor.forward_actor(extractor(observation))
        action = self.policy.action_net(latent)
        if self._bounds:
            return torch.clamp(action, *self._bounds)
        return torch.argmax(action, dim=1)


def export(policy, space, description, path):
    """Write the policy's actor.

    Args:
        policy: of stable-baselines3's PPO, on the processor.
        space: Gymnasium space of the environment's observations (images as (H, W, C)).
    """
    names = description.observations
    alone = not hasattr(space, "spaces")
    spaces = {names[0]: space} if alone else space.spaces
    images = [name for name in names if is_image_space(spaces[name])]
    bounds = getattr(description.actions, "bounds", None)
    network = _Deterministic(policy, names, images, alone, bounds)
    policy.set_training_mode(False)
    samples = tuple(torch.as_tensor(spaces[name].sample()[None]) for name in names)
    torch.onnx.export(
        network,
        samples,
        str(path),
        input_names=list(names),
        output_names=[OUTPUT],
        dynamic_axes={name: {0: "batch"} for name in (*names, OUTPUT)},
        opset_version=OPSET,
    )
    model = onnx.load(str(path))
    entry = model.metadata_props.add()
    entry.key, entry.value = KEY, description.text()
    onnx.save(model, str(path))
