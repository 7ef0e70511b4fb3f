"""Checkpoints: network, optimizer and random states."""

import os
import pickle
import random

import numpy as np
import torch

FILE, RANDOM_STATE = "checkpoint.zip", "random.pickle"


def save(model, folder):
    """Save a model atomically: a reader never gets a part of it."""
    part = os.path.join(folder, "part.zip")
    model.save(part)
    os.replace(part, os.path.join(folder, FILE))
    states = (torch.get_rng_state(), np.random.get_state(), random.getstate())
    with open(os.path.join(folder, RANDOM_STATE + ".part"), "wb") as stream:
        pickle.dump(states, stream)
    os.replace(os.path.join(folder, RANDOM_STATE + ".part"), os.path.join(folder, RANDOM_STATE))


def restore_random_state(folder):
    """Restore the states of the random number generators."""
    with open(os.path.join(folder, RANDOM_STATE), "rb") as stream:
        of_torch, of_numpy, of_python = pickle.load(stream)
    torch.set_rng_state(of_torch)
    np.random.set_state(of_numpy)
    random.setstate(of_python)
