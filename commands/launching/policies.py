"""Trained policies: by the name of their training, or a file."""

import json
import os

from commands.errors import UsageError
from commands.paths import OUT, read

FOLDER = os.path.join(OUT, "train")
FILE = "policy.onnx"


def names():
    """Lists the trainings that have left a policy."""
    if not os.path.isdir(FOLDER):
        return []
    return sorted(
        name for name in os.listdir(FOLDER) if os.path.isfile(os.path.join(FOLDER, name, FILE))
    )


def resolve(value):
    """Gives a policy's file.

    Args:
        value: A training's name, or the path of an ONNX file.

    Raises:
        UsageError: There is no such policy.
    """
    if value in names():
        return os.path.join(FOLDER, value, FILE)
    if value.endswith(".onnx") and os.path.isfile(value):
        return os.path.realpath(value)
    found = ", ".join(names()) or "none yet: ./run train makes one"
    raise UsageError(f"policy is {value!r}; there are {found}; or the path of an .onnx file")


def settings(path):
    """Gives the settings of the training that made a policy; empty where they are not beside it."""
    text = read(os.path.join(os.path.dirname(path), "settings.json"))
    return json.loads(text) if text else {}
