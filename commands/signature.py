"""Signatures of files by size and times: a quick answer to whether anything changed.

A signature only saves work. Where it does not fit, the content decides, and where it fits, the
content is the same: the time of change (ctime) moves with every write, also with those that put
the time of modification back.
"""

import os
import time

from commands.paths import CACHE, read, write

FOLDER = os.path.join(CACHE, "signatures")
RACY = 2_000_000_000  # [ns] a file younger than this could change within its time's resolution


def unchanged(name, key):
    """Returns whether key and files are as they were when the signature was saved.

    Args:
        name: What the signature is for.
        key: Text without a line break that has to be the same.
    """
    lines = read(os.path.join(FOLDER, name)).split("\n")
    if lines[0] != key or lines[-1] != "end":
        return False
    return all(line == _line(line.split(" ", 3)[-1]) for line in lines[1:-1])


def save(name, key, paths):
    """Records key and files, unless one of them changed just now.

    Args:
        name: What the signature is for.
        key: Text without a line break.
        paths: Files and directories; also those that do not exist, if that is what counts.
    """
    paths = list(paths)
    if max(map(_changed, paths), default=0) > time.time_ns() - RACY:
        return
    write(os.path.join(FOLDER, name), "\n".join([key, *map(_line, paths), "end"]))


def _line(path):
    try:
        result = os.stat(path)
    except OSError:
        return f"- - - {path}"
    return f"{result.st_size} {result.st_mtime_ns} {result.st_ctime_ns} {path}"


def _changed(path):
    try:
        result = os.stat(path)
    except OSError:
        return 0
    return max(result.st_mtime_ns, result.st_ctime_ns)
