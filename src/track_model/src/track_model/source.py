"""Reading tracks: those of this package by name, other files by path and suffix."""

from __future__ import annotations

import os

from track_model import track_file
from track_model.spec import TrackError, TrackSpec

MAX_SIZE = 10_000_000  # [bytes] of a file


def tracks_directory() -> str:
    """Return the folder of the tracks of this package."""
    here = os.path.dirname(os.path.realpath(__file__))
    candidates = [
        os.path.join(here, "..", ".."),  # source tree
        # install space, from lib/python3/dist-packages/track_model
        os.path.join(here, *[".."] * 4, "share", "track_model"),
    ]
    for candidate in candidates:
        directory = os.path.normpath(os.path.join(candidate, "tracks"))
        if os.path.isdir(directory):
            return directory
    raise TrackError(
        "track_model",
        "folder tracks",
        "missing",
        "one of {}".format(", ".join(map(os.path.normpath, candidates))),
    )


def find(name_or_path: str) -> str:
    """Return the absolute path of a track by its name or file.

    Raises:
        TrackError: There is no such track.
    """
    directory = tracks_directory()
    named = os.path.join(directory, f"{name_or_path}.yaml")
    if os.sep not in name_or_path and os.path.isfile(named):
        return named
    if os.path.isfile(name_or_path):
        return os.path.abspath(name_or_path)
    names = sorted(entry[:-5] for entry in os.listdir(directory) if entry.endswith(".yaml"))
    raise TrackError(
        name_or_path,
        "track",
        "not found",
        "{}, or the path of a YAML, NPY or CSV file".format(", ".join(names)),
    )


def load(path: str, content: bytes | None = None) -> TrackSpec:
    """Read and check a track file of any format: YAML, or a route (.npy, .csv).

    Args:
        content: Its bytes, if they were read already.

    Raises:
        TrackError: It cannot be read or is not valid.
    """
    content = read(path) if content is None else content
    if path.lower().endswith((".npy", ".csv")):
        from track_model import routes  # imports numpy only for a route

        return routes.parse(content, path)
    return track_file.parse(content, path)


def read(path: str) -> bytes:
    """Return a track file's bytes.

    Raises:
        TrackError: The file cannot be read.
    """
    if os.path.exists(path) and not os.path.isfile(path):
        raise TrackError(path, "file", "no regular file", "a readable track file")
    try:
        size = os.path.getsize(path)
        if size > MAX_SIZE:
            raise TrackError(path, "file", f"{size} bytes long", f"at most {MAX_SIZE} bytes")
        with open(path, "rb") as stream:
            return stream.read()
    except OSError as error:
        raise TrackError(path, "file", error.strerror, "a readable track file") from error
