"""The functions of quickstep that Python calls, and the library that is made of them.

python -m bullet_sim.engine.quickstep.entries        makes the library; numba takes a minute
"""

import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import llvmlite.binding as llvm
from llvmlite import ir
from numba import types
from numba.core.compiler_lock import global_compiler_lock
from numba.core.registry import cpu_target
from numba.np.arrayobj import populate_array

from bullet_sim.engine.quickstep import rays, solver, touching, trees
from bullet_sim.engine.quickstep.compiled import arrays_at, compiled, numba_type, number_type
from bullet_sim.engine.quickstep.sources import CACHE, SOURCES, library_path
from bullet_sim.engine.quickstep.state import CALLS, Building, Casting, Touching

_casting_at = arrays_at(numba_type(Casting))
_building_at = arrays_at(numba_type(Building))
_touching_at = arrays_at(numba_type(Touching))
_TABLE = types.int64[::1]
_COMPILERS = ("cc", "gcc", "clang", "g++")


@compiled
def _cast(near: float, far: float, table: Any) -> int:
    return rays.cast(near, far, _casting_at(table))


@compiled
def _build_tree(table: Any) -> int:
    return trees.build_tree(_building_at(table))


@compiled
def _list_contacts(row: int, table: Any) -> int:
    return touching.list_contacts(row, _touching_at(table))


FUNCTIONS = {
    "advance": solver.advance,
    "serve": solver.serve,
    "cast": _cast,
    "build_tree": _build_tree,
    "list_contacts": _list_contacts,
}


def is_compiled() -> bool:
    """Whether numba has compiled the solver of this version; if there are libraries, but none for
    this processor, it was another one."""
    return any(CACHE.glob("solver.advance-*.nbi")) and not any(CACHE.glob("quickstep-*.so"))


class BuildError(RuntimeError):
    """The library cannot be made."""


def _add(library: Any, name: str) -> None:
    """Compile a function, and add one to a library that C can call: numbers, then the table's
    address and length. It returns -1 where numba's would raise an error."""
    context, arguments = cpu_target.target_context, (*map(number_type, CALLS[name]), _TABLE)
    FUNCTIONS[name].compile(arguments)
    found = FUNCTIONS[name].overloads[arguments]
    library.add_linking_library(found.library)
    module = library.create_ir_module(f"quickstep_{name}")
    integer, double = ir.IntType(64), ir.DoubleType()
    given = [double if kind is types.float64 else integer for kind in arguments[:-1]]
    called = ir.FunctionType(integer, [*given, integer.as_pointer(), integer])
    function = ir.Function(module, called, f"quickstep_{name}")
    builder = ir.IRBuilder(function.append_basic_block())
    *numbers, address, length = function.args
    values = [
        builder.trunc(value, ir.IntType(1)) if kind is types.boolean else value
        for kind, value in zip(arguments, numbers)
    ]
    table = context.make_array(_TABLE)(context, builder)
    populate_array(table, address, [length], [integer(8)], integer(8), meminfo=None)
    inner = context.declare_function(module, found.fndesc)
    status, result = context.call_conv.call_function(
        builder, inner, types.int64, arguments, [*values, table._getvalue()]
    )
    builder.ret(builder.select(status.is_error, integer(-1), result))
    library.add_ir_module(module)


@global_compiler_lock
def make_library(path: Path) -> None:
    """Write the library.

    Raises:
        BuildError: There is no C compiler, or the linker fails.
    """
    linker = next(filter(None, map(shutil.which, _COMPILERS)), None)
    if linker is None:
        raise BuildError(f"none of {', '.join(_COMPILERS)} is installed, one is needed to link")
    codegen = cpu_target.target_context.codegen()
    library = codegen.create_library("quickstep")
    for name in FUNCTIONS:
        _add(library, name)
    library.finalize()
    target = llvm.Target.from_triple(llvm.get_process_triple())
    machine = target.create_target_machine(
        cpu=codegen._get_host_cpu_name(),
        features=codegen._get_host_cpu_features(),
        opt=3,
        reloc="pic",
        codemodel="default",
    )
    path.parent.mkdir(exist_ok=True)
    with tempfile.TemporaryDirectory(dir=path.parent) as folder:
        compiled_file, linked = Path(folder, "quickstep.o"), Path(folder, "quickstep.so")
        module = llvm.parse_bitcode(library._final_module.as_bitcode())
        compiled_file.write_bytes(machine.emit_object(module))
        options = "-shared", "-Wl,-z,defs,-z,noexecstack"
        words = [linker, *options, "-o", str(linked), str(compiled_file), "-lm", "-lpthread"]
        done = subprocess.run(words, text=True, capture_output=True, check=False)
        if done.returncode != 0:
            raise BuildError(f"{linker} failed: {done.stderr.strip()}")
        linked.chmod(0o644)  # it is no program
        os.replace(linked, path)
    changed = max(source.stat().st_mtime for source in SOURCES)
    for other in path.parent.glob("quickstep-*.so"):  # newer ones may be for other processors
        if other.stat().st_mtime < changed:
            other.unlink(missing_ok=True)


def main() -> None:
    """Make the library, or say why there is none; then numba's functions are used."""
    try:
        make_library(library_path())
    except (BuildError, OSError) as error:
        print(f"there is no library of the solver, starts take longer: {error}", file=sys.stderr)


if __name__ == "__main__":
    main()
