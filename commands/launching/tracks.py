"""Tracks: the shipped ones by name, or a file of a kind that the readers take."""

import os

from commands.errors import UsageError
from commands.paths import SOURCES

FOLDER = os.path.join(SOURCES, "track_model", "tracks")
SUFFIXES = (".yaml", ".yml", ".npy", ".csv")


def names():
    """Lists the shipped tracks."""
    return sorted(name[: -len(".yaml")] for name in os.listdir(FOLDER) if name.endswith(".yaml"))


def resolve(value):
    """Checks a track.

    Args:
        value: A shipped track's name, or a path.

    Returns:
        The name, or the absolute path: launched nodes have another current directory.

    Raises:
        UsageError: There is no such track.
    """
    if value in names():
        return value
    if not os.path.isfile(value):
        raise UsageError(
            f"track is {value!r}; there are {', '.join(names())}, or the path of a YAML, .npy or "
            ".csv file"
        )
    if not value.lower().endswith(SUFFIXES):
        raise UsageError(f"track is {value!r}; a track file ends in {', '.join(SUFFIXES)}")
    return os.path.realpath(value)
