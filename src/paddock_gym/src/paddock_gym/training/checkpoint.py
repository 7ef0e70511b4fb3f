"""Checkpoints: network, optimiser and random numbers."""

import os
import pickle
import random

import numpy as np
import torch

FILE, NUMBERS = "checkpoint.zip", "random.pickle"


def save(model, folder):
    """Save a model so that no reader ever sees half of it."""
    part = os.path.join(folder, "part.zip")
    model.save(part)
    os.replace(part, os.path.join(folder, FILE))
    numbers = (torch.get_rng_state(), np.random.get_state(), random.getstate())
    with open(os.path.join(folder, NUMBERS + ".part"), "wb") as stream:
        pickle.dump(numbers, stream)
    os.replace(os.path.join(folder, NUMBERS + ".part"), os.path.join(folder, NUMBERS))


def restore_numbers(folder):
    """Go on with the random numbers of the last save."""
    with open(os.path.join(folder, NUMBERS), "rb") as stream:
        of_torch, of_numpy, of_python = pickle.load(stream)
    torch.set_rng_state(of_torch)
    np.random.set_state(of_numpy)
    random.setstate(of_python)
