"""The compiled functions of quickstep as Python calls them.

./run setup has a shared library made of what numba compiles (entries.py). It is loaded here, which
spares each start importing numba: half a second of processor time and 100 MB. Where there is none
of these sources, for what this processor can do and of this numba, as in an installed copy, numba's
own functions are called, which it has compiled before or compiles now. Both have the same bits.
"""

import ctypes
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

from bullet_sim.engine.quickstep.sources import CACHE, library_path
from bullet_sim.engine.quickstep.state import Building, Casting, make_table
from bullet_sim.pose import Array

_CALLS: dict[str, tuple[Any, ...]] = {  # name -> types of its arguments before the table
    "advance": (*(ctypes.c_int64,) * 2, ctypes.c_double, *(ctypes.c_int64,) * 3),
    "cast": (ctypes.c_double,),
    "build_tree": (),
}


def _open(path: Path) -> dict[str, Callable[..., int]] | None:
    """Functions of a library; None: it is not there, or is none."""
    if not path.is_file():
        return None
    try:
        library = ctypes.PyDLL(str(path))
        found = {name: getattr(library, f"quickstep_{name}") for name in _CALLS}
    except (OSError, AttributeError):
        return None
    for name, function in found.items():
        function.restype = ctypes.c_int64
        function.argtypes = (*_CALLS[name], ctypes.c_void_p, ctypes.c_int64)
    return found


_library = _open(library_path())
if _library is None:
    from bullet_sim.engine.quickstep import entries


def is_compiled() -> bool:
    """Whether nothing has to be compiled any more."""
    return _library is not None or entries.is_compiled()


def compile_once() -> None:
    """Have numba compile, and make the library, where neither was done; else nothing."""
    if not is_compiled() and os.access(CACHE if CACHE.exists() else CACHE.parent, os.W_OK):
        entries.main()


def _call(name: str, *arguments: Any) -> int:
    """Call a function; the last argument is its table.

    Raises:
        ArithmeticError: a number was divided by 0.
    """
    if _library is None:
        found: int = entries.FUNCTIONS[name](*arguments)
        return found
    *numbers, table = arguments
    done = _library[name](*numbers, table.ctypes.data, len(table))
    if done < 0:
        raise ArithmeticError(f"{name}() of the solver 'ode' divided by 0")
    return done


def advance(
    count: int, given: int, step: float, iterations: int, watch: bool, sleepy: bool, table: Array
) -> int:
    """Make up to `count` steps, see solver.advance()."""
    return _call("advance", count, given, step, iterations, watch, sleepy, table)


def cast(
    center: Array,
    directions: Array,
    low: Array,
    high: Array,
    centers: Array,
    frames: Array,
    sizes: Array,
    radii: Array,
    kinds: Array,
    starts: Array,
    far: float,
    ranges: Array,
) -> None:
    """Shorten distances to those of the nearest hit, see rays.cast()."""
    arrays = center, directions, low, high, centers, frames, sizes, radii, kinds, starts, ranges
    _call("cast", far, make_table(Casting(*arrays)))


def build_tree(
    corners: Array, order: Array, nodes: Array, children: Array, todo: Array, means: Array
) -> int:
    """Build the tree of triangles; how deep it is. See trees.build_tree()."""
    return _call("build_tree", make_table(Building(corners, order, nodes, children, todo, means)))
