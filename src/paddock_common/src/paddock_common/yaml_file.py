"""YAML files of users: their content, or one error message."""

from __future__ import annotations

import os
import reprlib
from typing import Any

import yaml  # type: ignore[import]

MAX_SIZE = 10_000_000  # [bytes] of a file
_SHORT = reprlib.Repr()
_SHORT.maxlevel, _SHORT.maxstring, _SHORT.maxother = 3, 200, 200


def formatted(value: object) -> str:
    """Returns a value as text for a message: short, even if it is nested endlessly."""
    return _SHORT.repr(value)


def parse(text: str | bytes, name: str) -> Any:
    """Returns the content of a YAML text: plain values, no objects.

    Args:
        name: Name of the file in messages.

    Raises:
        ValueError: It is not YAML; the message has its name.
    """
    try:
        return yaml.safe_load(text)
    except RecursionError:
        raise ValueError(f"{name} is no YAML that can be read: it is nested too deeply") from None
    except (
        yaml.YAMLError,
        ValueError,
    ) as error:  # ValueError: an invalid date, a number of 5000 digits
        raise ValueError(f"{name} is no YAML: {' '.join(str(error).split())}") from None


def read(path: str) -> Any:
    """Returns the content of a YAML file, see parse().

    Raises:
        ValueError: It is not a file, too long, not readable or not YAML; the message has its name.
    """
    if os.path.exists(path) and not os.path.isfile(path):
        raise ValueError(f"{path} cannot be read: it is no regular file")
    try:
        with open(path, "rb") as stream:
            content = stream.read(MAX_SIZE + 1)
    except OSError as error:
        raise ValueError(f"{path} cannot be read: {error.strerror}") from None
    if len(content) > MAX_SIZE:
        raise ValueError(f"{path} cannot be read: it has more than {MAX_SIZE} bytes")
    return parse(content, path)
