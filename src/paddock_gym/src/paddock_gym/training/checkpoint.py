"""Checkpoints: network, optimizer, counters and random states, as arrays of numbers.

A folder may come from elsewhere: what is read here cannot execute anything, unlike a pickle or
stable-baselines3's own files.
"""

import json
import os
import random
import zipfile
from collections import deque

import numpy as np
import torch

from paddock_gym.errors import GymError

FILE, FORMER = "checkpoint.npz", "checkpoint.zip"
LARGEST = 1 << 30  # [bytes] of its arrays
COUNTERS = ("num_timesteps", "_n_updates", "_episode_num")
BUFFERS = ("ep_info_buffer", "ep_success_buffer")  # of the latest episodes; learn() wants both
ABOUT = "about"  # JSON of what is no array


def save(model, path):
    """Save a model atomically: a reader never gets a part of it."""
    arrays = {f"policy/{key}": value.numpy() for key, value in model.policy.state_dict().items()}
    for number, values in model.policy.optimizer.state_dict()["state"].items():
        for key, value in values.items():
            arrays[f"optimizer/{number}/{key}"] = np.asarray(value)
    _, arrays["random/numpy"], *numpy_rest = np.random.get_state()
    arrays["random/torch"] = torch.get_rng_state().numpy()
    about = {
        "counters": {name: getattr(model, name) for name in COUNTERS},
        "episodes": {name: list(getattr(model, name) or ()) for name in BUFFERS},
        "random": {"numpy": numpy_rest, "python": random.getstate()},
    }
    arrays[ABOUT] = np.frombuffer(json.dumps(about, default=float).encode(), np.uint8)
    part = f"{path}.part"
    with open(part, "wb") as stream:
        np.savez(stream, **arrays)
    os.replace(part, path)


def _read(path):
    """(arrays, what is no array) of a checkpoint.

    Raises:
        GymError: there is none, or it is none.
    """
    former = os.path.join(os.path.dirname(path), FORMER)
    if not os.path.exists(path) and os.path.exists(former):
        raise GymError(
            f"{former} is of an earlier version and is not read, as it could execute anything; "
            "train again"
        )
    try:
        with zipfile.ZipFile(path) as file:
            size = sum(entry.file_size for entry in file.infolist())
        if size > LARGEST:
            raise ValueError(f"has {size} bytes unpacked, at most {LARGEST} are read")
        with np.load(path, allow_pickle=False) as file:
            arrays = {name: file[name] for name in file.files}
        return arrays, json.loads(arrays[ABOUT].tobytes())
    except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile) as error:
        raise GymError(f"{path} cannot be read: {error}") from error


def load_policy(policy, path):
    """Give a policy the weights of a checkpoint.

    Raises:
        GymError: it cannot be read, or is of another network.
    """
    arrays, _ = _read(path)
    _load_weights(policy, arrays, path)


def _load_weights(policy, arrays, path):
    weights = {
        name[len("policy/") :]: torch.from_numpy(array)
        for name, array in arrays.items()
        if name.startswith("policy/")
    }
    try:
        policy.load_state_dict(weights)
    except RuntimeError as error:
        raise GymError(f"{path} is of another network: {error}") from error


def restore(model, path):
    """Continue a model from a checkpoint, with the random states.

    Args:
        model: new, of the same settings.

    Raises:
        GymError: it cannot be read, or is of another network.
    """
    arrays, about = _read(path)
    _load_weights(model.policy, arrays, path)
    state = {}
    for name, array in arrays.items():
        if name.startswith("optimizer/"):
            _, number, key = name.split("/")
            state.setdefault(int(number), {})[key] = torch.from_numpy(array)
    optimizer = model.policy.optimizer
    try:
        groups = optimizer.state_dict()["param_groups"]
        optimizer.load_state_dict({"state": state, "param_groups": groups})
        for name in COUNTERS:
            setattr(model, name, int(about["counters"][name]))
        for name in BUFFERS:
            setattr(model, name, deque(about["episodes"][name], maxlen=model._stats_window_size))
        np.random.set_state(("MT19937", arrays["random/numpy"], *about["random"]["numpy"]))
        torch.set_rng_state(torch.from_numpy(arrays["random/torch"]))
        version, numbers, rest = about["random"]["python"]
        random.setstate((version, tuple(numbers), rest))
    except (KeyError, TypeError, ValueError, RuntimeError) as error:
        raise GymError(f"{path} cannot be continued from: {error!r}") from error
