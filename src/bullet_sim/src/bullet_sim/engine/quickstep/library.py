"""The compiled functions of quickstep as Python calls them.

./run setup has a shared library made of what numba compiles (entries.py). It is loaded here, which
spares each start importing numba: half a second of processor time and 100 MB; it is installed, too.
Where there is none of these sources, for what this processor can do and of this numba, numba's own
functions are called, which it has compiled before or compiles now. Both have the same bits.
"""

from __future__ import annotations

import ctypes
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

from bullet_sim.engine.quickstep.sources import CACHE, library_path
from bullet_sim.engine.quickstep.state import CALLS, Building, Casting, Touching, make_table
from bullet_sim.pose import Array


def _open(path: Path, kind: Any = ctypes.PyDLL) -> dict[str, Callable[..., int]] | None:
    """Functions of a library; None: it is not there, or is none.

    Args:
        kind: of ctypes: CDLL gives up Python's lock while a function runs, which costs a thread
            whose lock others take at once up to 5 ms; PyDLL keeps it.
    """
    if not path.is_file():
        return None
    try:
        library = kind(str(path))
        found = {name: getattr(library, f"quickstep_{name}") for name in CALLS}
    except (OSError, AttributeError):
        return None
    for name, function in found.items():
        function.restype = ctypes.c_int64
        numbers = (ctypes.c_double if kind == "f8" else ctypes.c_int64 for kind in CALLS[name])
        function.argtypes = (*numbers, ctypes.c_void_p, ctypes.c_int64)
    return found


_library = _open(library_path())
_unlocked = _open(library_path(), ctypes.CDLL)
if _library is None:
    from bullet_sim.engine.quickstep import entries


def is_compiled() -> bool:
    """Whether nothing has to be compiled any more."""
    return _library is not None or entries.is_compiled()


def compile_once() -> None:
    """Have numba compile, and make the library, where neither was done; else nothing."""
    if not is_compiled() and os.access(CACHE if CACHE.exists() else CACHE.parent, os.W_OK):
        entries.main()


def _call(name: str, *arguments: Any, unlocked: bool = False) -> int:
    """Call a function; the last argument is its table.

    Args:
        unlocked: let other threads of Python run meanwhile.

    Raises:
        RuntimeError: the function raised an error.
    """
    library = _unlocked if unlocked else _library
    if library is None:
        found: int = entries.FUNCTIONS[name](*arguments)
        return found
    *numbers, table = arguments
    done = library[name](*numbers, table.ctypes.data, len(table))
    if done < 0:
        raise RuntimeError(f"{name}() of the solver 'ode' raised an error")
    return done


def advance(*arguments: Any, unlocked: bool = False) -> int:
    """Make steps, see solver.advance(); unlocked: as of _call()."""
    return _call("advance", *arguments, unlocked=unlocked)


def serve(table: Array) -> None:
    """Help advance(), see solver.serve(); other threads of Python run meanwhile."""
    _call("serve", table, unlocked=True)


def caster(casting: Casting) -> Callable[[float, float], int]:
    """rays.cast() of arrays that outlive it and stay where they are."""
    table = make_table(casting)
    return lambda near, far: _call("cast", near, far, table)


def build_tree(building: Building) -> int:
    """Build the tree of triangles; how deep it is."""
    return _call("build_tree", make_table(building))


def contact_lister(touching: Touching) -> Callable[[int], int]:
    """touching.list_contacts() of arrays that outlive it and stay where they are."""
    table = make_table(touching)
    return lambda row: _call("list_contacts", row, table)
