"""Keeping what C++ libraries print out of the terminal."""

import contextlib
import os
import sys


def keep_python_audible():
    """Give sys.stdout and sys.stderr file descriptors of their own, beside quiet()'s effect.

    Otherwise what other threads log while a library is kept quiet is lost, too. To be called
    once, before anybody takes hold of these streams.
    """
    for name in ("stdout", "stderr"):
        stream = getattr(sys, name)
        stream.flush()
        setattr(
            sys,
            name,
            os.fdopen(
                os.dup(stream.fileno()),
                "w",
                buffering=1,
                encoding=stream.encoding,
                errors=stream.errors,
            ),
        )


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
