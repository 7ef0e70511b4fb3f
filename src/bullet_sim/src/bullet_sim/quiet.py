"""Keeping what C++ libraries print out of the terminal."""

import contextlib
import os
import sys


@contextlib.contextmanager
def quiet():
    """Point file descriptors 1 and 2 to nowhere for a while."""
    sys.stdout.flush()
    sys.stderr.flush()
    saved = [(fd, os.dup(fd)) for fd in (1, 2)]
    null = os.open(os.devnull, os.O_WRONLY)
    try:
        for fd, _ in saved:
            os.dup2(null, fd)
        yield
    finally:
        for fd, copy in saved:
            os.dup2(copy, fd)
            os.close(copy)
        os.close(null)
