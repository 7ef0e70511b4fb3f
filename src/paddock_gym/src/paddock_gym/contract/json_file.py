"""JSON files of users, with errors that name file, key, value and what is valid."""

import json
import math

from paddock_gym.errors import GymError


def load(path):
    """Read a JSON file that holds a table.

    Raises:
        GymError: it cannot be read, or is none.
    """
    try:
        with open(path, encoding="utf-8") as stream:
            data = json.load(stream)
    except OSError as error:
        raise GymError(f"{path}: {error.strerror}; it must be a readable JSON file") from error
    except ValueError as error:
        raise GymError(f"{path} is no JSON ({error})") from error
    if not isinstance(data, dict):
        raise GymError(f"{path} holds {data!r}; it must be a table {{...}}")
    return data


def number(path, key, value, low, high, unit=""):
    """Return a number within a range.

    Raises:
        GymError: it is none, or outside.
    """
    if (
        isinstance(value, bool)
        or not isinstance(value, (int, float))
        or not math.isfinite(value)
        or not low <= value <= high
    ):
        words = f"from {low:g} to {high:g}" + (f" [{unit}]" if unit else "")
        raise GymError(f"{path}: {key} is {value!r}; it must be a number {words}")
    return float(value)


def one_of(path, key, value, valid):
    """Return a value that is one of some.

    Raises:
        GymError: it is none of them.
    """
    if value not in valid:
        raise GymError(f"{path}: {key} is {value!r}; it must be one of {', '.join(valid)}")
    return value
