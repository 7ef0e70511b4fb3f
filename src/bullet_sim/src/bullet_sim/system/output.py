"""Suppressing the terminal output of C++ libraries."""

import contextlib
import os
import sys


def keep_python_output():
    """Give sys.stdout and sys.stderr own file descriptors, which silenced() does not redirect.

    Otherwise the output of other threads is lost while a library is silenced. To be called once,
    before other modules store these streams.
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
def silenced():
    """Redirect file descriptors 1 and 2 to /dev/null within the context."""
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
