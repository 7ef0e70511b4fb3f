"""Functions that numba compiles, and keeps compiled beside their files.

numba compiles a function again when its own file has changed, but not when another function that it
calls has. So what was kept is deleted here, before the other files are imported, when any of them
has changed.

Records (NamedTuples) are passed to compiled functions as the arrays and numbers in them. Constants
are read as `col.NAME`; only temporary() needs a name of its own module.
"""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from typing import Any

from llvmlite import ir
from numba import njit, types
from numba.core import cgutils
from numba.core import ir as numba_ir
from numba.extending import intrinsic
from numba.np.arrayobj import populate_array

from bullet_sim.engine.quickstep.sources import CACHE, sources_hash
from bullet_sim.engine.quickstep.state import KINDS


def _forget_older() -> None:
    """Delete what was compiled from other sources."""
    sources, stamp = sources_hash(), CACHE / "sources.sha256"
    try:
        if stamp.is_file() and stamp.read_text() == sources:
            return
        CACHE.mkdir(exist_ok=True)
        for kept in CACHE.glob("*.nb[ic]"):
            kept.unlink(missing_ok=True)
        written = stamp.with_suffix(f".{os.getpid()}")
        written.write_text(sources)
        written.replace(stamp)
    except OSError:  # a folder that cannot be written to has nothing, either
        return


_forget_older()
# Before numba 0.59, each statement of what is inlined is copied with a scope of its own, which has
# all names of the function: minutes, and gigabytes. It is read only, so that one does for all.
if "__deepcopy__" not in vars(numba_ir.Var):
    numba_ir.Scope.__deepcopy__ = lambda scope, _copied: scope
# Without counting references to arrays, which costs more than the arithmetic: slices are free.
# A division by 0 gives inf or NaN, as in C: a robot whose gains are unstable must not end the
# simulation of the others.
compiled = njit(cache=True, _nrt=False, error_model="numpy")
# Without Python's lock, also where there is no library.
threaded = njit(cache=True, _nrt=False, error_model="numpy", nogil=True)
# As part of each function that calls it: a call passes each array of a tuple as nine numbers.
inlined = njit(cache=True, _nrt=False, error_model="numpy", inline="always")


def switch(cases: Mapping[int, Any]) -> Any:
    """A compiled function that calls one of several: that of the code which is its first argument.

    numba can call none of a list without a price. These are comparisons one after the other, of
    which the processor's code makes a single jump.

    Args:
        cases: code -> compiled function; all take the same arguments.
    """
    (code, function), *rest = cases.items()
    others = switch(dict(rest)) if rest else function

    @njit(_nrt=False, error_model="numpy")
    def chosen(wanted: int, *arguments: Any) -> Any:
        return function(*arguments) if wanted == code else others(wanted, *arguments)

    @njit(_nrt=False, error_model="numpy")
    def last(wanted: int, *arguments: Any) -> Any:
        return function(*arguments)

    return chosen if rest else last


@intrinsic(prefer_literal=True)
def temporary(typing: Any, *shape: Any) -> Any:
    """An array of numbers on the stack of the function that calls it; at first they are any.

    Args:
        shape: constants.
    """
    kind = types.Array(types.float64, len(shape), "C")
    sizes = [size.literal_value for size in shape]

    def generate(context: Any, builder: Any, _signed: Any, _args: Any) -> Any:
        array = context.make_array(kind)(context, builder)
        number, integer = ir.DoubleType(), ir.IntType(64)
        memory = cgutils.alloca_once(builder, ir.ArrayType(number, math.prod(sizes)))
        populate_array(
            array,
            data=builder.bitcast(memory, number.as_pointer()),
            shape=[integer(size) for size in sizes],
            strides=[integer(8 * math.prod(sizes[i + 1 :])) for i in range(len(sizes))],
            itemsize=integer(8),
            meminfo=None,
        )
        return array._getvalue()

    return kind(types.StarArgTuple(shape)), generate


_NUMBERS = {"f8": types.float64, "f4": types.float32, "i8": types.int64, "b1": types.boolean}
number_type = _NUMBERS.__getitem__  # numba's type of a kind of numbers


def numba_type(kind: Any) -> Any:
    """numba's type of one of state.KINDS, or of what is in it."""
    if isinstance(kind, str):
        number, _, dimensions = kind.partition(".")
        return types.Array(number_type(number), int(dimensions), "C")
    return types.NamedTuple([numba_type(each) for each in KINDS[kind]], kind)


def arrays_at(kind: Any) -> Any:
    """Function of a table that gives its arrays in a tuple of a type of numba.

    numba takes 0.2 us to convert an array that it is given; a table of all is one array.
    """

    @intrinsic
    def read(typing: Any, table: Any) -> Any:
        def generate(context: Any, builder: Any, signed: Any, args: Any) -> Any:
            integer, at = ir.IntType(64), iter(range(1 << 20))
            numbers = context.make_array(signed.args[0])(context, builder, args[0]).data

            def number() -> Any:
                return builder.load(builder.gep(numbers, [integer(next(at))]))

            def made(each: Any) -> Any:
                if not isinstance(each, types.Array):
                    parts = [made(part) for part in each.types]
                    return context.make_tuple(builder, each, parts)
                array = context.make_array(each)(context, builder)
                address, shape = number(), [number() for _ in range(each.ndim)]
                size = integer(context.get_abi_sizeof(context.get_data_type(each.dtype)))
                strides = [size]
                for length in shape[:0:-1]:
                    strides.insert(0, builder.mul(strides[0], length))
                data = builder.inttoptr(address, array.data.type)
                populate_array(array, data, shape, strides, size, meminfo=None)
                return array._getvalue()

            return made(kind)

        return kind(table), generate

    return read
