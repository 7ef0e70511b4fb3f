"""Functions that numba compiles, and keeps compiled beside their files.

numba compiles a function again when its own file has changed, but not when another function that it
calls has. So what was kept is deleted here, before the other files are imported, when any of them
has changed.
"""

import hashlib
import os
from pathlib import Path

from numba import njit

_FOLDER = Path(__file__).parent
_CACHE = _FOLDER / "__pycache__"


def _forget_older() -> None:
    """Delete what was compiled from other sources."""
    sources = hashlib.sha256()
    for path in sorted(_FOLDER.glob("*.py")):
        sources.update(path.read_bytes())
    stamp = _CACHE / "sources.sha256"
    try:
        if stamp.is_file() and stamp.read_text() == sources.hexdigest():
            return
        _CACHE.mkdir(exist_ok=True)
        for kept in _CACHE.glob("*.nb[ic]"):
            kept.unlink(missing_ok=True)
        written = stamp.with_suffix(f".{os.getpid()}")
        written.write_text(sources.hexdigest())
        written.replace(stamp)
    except OSError:  # a folder that cannot be written to has nothing, either
        return


def is_compiled() -> bool:
    """Whether numba has compiled the solver of this version."""
    return any(_CACHE.glob("solver.advance-*.nbi"))


_forget_older()
compiled = njit(cache=True)
