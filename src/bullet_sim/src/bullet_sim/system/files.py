"""Reading a file that somebody has named, which may be no file, or endless."""

import os

from bullet_sim.errors import ModelError

MAX_TEXT = 20_000_000  # [bytes] of an SDF or of a world; reading takes some 20 times as much memory


def read_file(path, what, most):
    """All bytes of a file.

    Args:
        path: of the file; pipes and devices, which may be endless or silent, are none.
        what: for messages, e.g. "mesh".
        most: bytes that it may have.

    Raises:
        ModelError: it is no file, is too long or cannot be read; names it.
    """
    if os.path.exists(path) and not os.path.isfile(path):
        raise ModelError(f"{what} '{path}' is no file")
    try:
        size = os.path.getsize(path)
        if size > most:
            raise ModelError(f"{what} '{path}' has {size} bytes, must have at most {most}")
        with open(path, "rb") as file:
            content = file.read(size + 1)
    except OSError as error:
        raise ModelError(f"{what} '{path}' cannot be read: {error.strerror}") from error
    if len(content) > size:  # as of files in /proc, whose size is 0
        raise ModelError(f"{what} '{path}' has more than the {size} bytes that it says to have")
    return content
