"""YAML files that somebody has written: what they hold, or one sentence that says why not."""

import os
import reprlib

import yaml

LONGEST = 10_000_000  # [bytes] of a file
_SHORT = reprlib.Repr()
_SHORT.maxlevel, _SHORT.maxstring, _SHORT.maxother = 3, 200, 200


def shown(value):
    """A value for a message: short, also where it is nested without end."""
    return _SHORT.repr(value)


def parse(text, name):
    """Returns what a YAML text holds: plain values, no objects.

    Args:
        text: str or bytes.
        name: Of the file, for messages.

    Raises:
        ValueError: It is no YAML; names it.
    """
    try:
        return yaml.safe_load(text)
    except RecursionError:
        raise ValueError(f"{name} is no YAML that can be read: it is nested too deeply") from None
    except (yaml.YAMLError, ValueError) as error:  # ValueError: no date, a number of 5000 digits
        raise ValueError(f"{name} is no YAML: {' '.join(str(error).split())}") from None


def read(path):
    """Returns what a YAML file holds, see parse().

    Raises:
        ValueError: It is no file, is too long, cannot be read or is no YAML; names it.
    """
    if os.path.exists(path) and not os.path.isfile(path):
        raise ValueError(f"{path} cannot be read: it is no regular file")
    try:
        with open(path, "rb") as stream:
            content = stream.read(LONGEST + 1)
    except OSError as error:
        raise ValueError(f"{path} cannot be read: {error.strerror}") from None
    if len(content) > LONGEST:
        raise ValueError(f"{path} cannot be read: it has more than {LONGEST} bytes")
    return parse(content, path)
