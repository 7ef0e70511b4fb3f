"""Islands of bodies that touch or are joined, solved by several threads (island_threads).

Islands share no body, so that each has the same bits whoever solves it, and whenever. The rows of
an island follow each other (constraints.add_rows); small islands are solved in groups, whose blocks
stay in a processor's first cache during the iterations.

The thread that makes steps offers the groups of each step by a countdown; it and its helpers take
one after the other from it. Helpers are inside serve() for as long as the arrays exist, so that
they never wait for Python's lock; between calls of advance() they sleep by a semaphore.
"""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

from bullet_sim.engine.quickstep import layout as col
from bullet_sim.engine.quickstep.blocks import iterate, pack, unpack
from bullet_sim.engine.quickstep.compiled import compiled, inlined, temporary
from bullet_sim.engine.quickstep.state import Blocks, Constraints, Islands, System
from bullet_sim.engine.quickstep.vectors import rotate
from bullet_sim.pose import Array

_INTEGER = ir.IntType(64)


def _address(context: Any, builder: Any, signed: Any, args: Any) -> Any:
    """Of the number `args[1]` of a flat array."""
    array = context.make_array(signed.args[0])(context, builder, args[0])
    return builder.gep(array.data, [args[1]])


@intrinsic
def _read(typing: Any, array: Any, place: Any) -> Any:
    """A number of a flat array (int64), and all that its writer had written before."""

    def generate(context: Any, builder: Any, signed: Any, args: Any) -> Any:
        return builder.load_atomic(_address(context, builder, signed, args), "seq_cst", 8)

    return types.int64(array, types.int64), generate


@intrinsic
def _write(typing: Any, array: Any, place: Any, value: Any) -> Any:
    """Write a number of a flat array (int64), after all that was written before."""

    def generate(context: Any, builder: Any, signed: Any, args: Any) -> Any:
        where = _address(context, builder, signed, args)
        builder.store_atomic(args[2], where, "seq_cst", 8)
        return context.get_dummy_value()

    return types.void(array, types.int64, types.int64), generate


@intrinsic
def _count_down(typing: Any, array: Any, place: Any) -> Any:
    """Reduce a number of a flat array (int64) by one; what it was."""

    def generate(context: Any, builder: Any, signed: Any, args: Any) -> Any:
        where = _address(context, builder, signed, args)
        return builder.atomic_rmw("sub", where, _INTEGER(1), "seq_cst")

    return types.int64(array, types.int64), generate


def _function_of_c(name: str) -> Any:
    """A function of the C library that is given the address of a number of a flat array."""

    @intrinsic
    def call(typing: Any, array: Any, place: Any) -> Any:
        def generate(context: Any, builder: Any, signed: Any, args: Any) -> Any:
            integer, address = ir.IntType(32), _address(context, builder, signed, args)
            kind = ir.FunctionType(integer, [address.type])
            function = cgutils.get_or_insert_function(builder.module, kind, name)
            return builder.sext(builder.call(function, [address]), _INTEGER)

        return types.int64(array, types.int64), generate

    return call


_post, _wait = _function_of_c("sem_post"), _function_of_c("sem_wait")


@intrinsic
def _let_others_run(typing: Any) -> Any:
    def generate(_context: Any, builder: Any, _signed: Any, _args: Any) -> Any:
        kind = ir.FunctionType(ir.IntType(32), [])
        function = cgutils.get_or_insert_function(builder.module, kind, "sched_yield")
        return builder.sext(builder.call(function, []), _INTEGER)

    return types.int64(), generate


@inlined
def _relax(
    group: int, system: System, sequence: Array, constraints: Constraints, islands: Islands,
    settings: Array,
) -> None:  # fmt: skip
    """Right sides, scaled rows and the impulses to begin with."""
    bodies, joints, work = system.bodies, system.joints, system.work
    rows, links, starts = constraints.rows, constraints.links, islands.starts
    step, v = islands.step[0], temporary(3)
    for place in range(starts[group, col.I_BODY], starts[group + 1, col.I_BODY]):
        b = sequence[place]
        rotate(work[b, col.W_V : col.W_V + 9], work[b, col.W_F + 3 : col.W_F + 6], v)
        for k in range(3):
            work[b, col.W_T + k] = (
                work[b, col.W_F + k] / bodies[b, col.MASS] + bodies[b, col.VEL + k] / step
            )
            work[b, col.W_T + 3 + k] = v[k] + bodies[b, col.VEL + 3 + k] / step
        work[b, col.W_A : col.W_A + 12] = 0.0
    for i in range(starts[group, col.I_ROW], starts[group + 1, col.I_ROW]):
        row, one, two = rows[i], links[i, 0], links[i, 1]
        total = diagonal = 0.0
        for k in range(6):
            total += row[col.R_J + k] * work[one, col.W_T + k]
        for k in range(3):
            row[col.R_M + k] = row[col.R_J + k] / bodies[one, col.MASS]
        inverse, angular = work[one, col.W_V : col.W_V + 9], row[col.R_M + 3 : col.R_M + 6]
        rotate(inverse, row[col.R_J + 3 : col.R_J + 6], angular)
        for k in range(6):
            diagonal += row[col.R_M + k] * row[col.R_J + k]
        if two >= 0:
            for k in range(6):
                total += row[col.R_J + 6 + k] * work[two, col.W_T + k]
            for k in range(3):
                row[col.R_M + 6 + k] = row[col.R_J + 6 + k] / bodies[two, col.MASS]
            inverse, angular = work[two, col.W_V : col.W_V + 9], row[col.R_M + 9 : col.R_M + 12]
            rotate(inverse, row[col.R_J + 9 : col.R_J + 12], angular)
            for k in range(6, 12):
                diagonal += row[col.R_M + k] * row[col.R_J + k]
        softness = row[col.R_CFM] / step
        scale = settings[col.S_RELAXATION] / (diagonal + softness)
        if links[i, 2] >= 0:
            scale *= col.FRICTION_SCALE
        wanted = row[col.R_C]
        row[col.R_RHS2] = (wanted / step - total) * scale
        most = settings[col.S_MAX] if links[i, 2] == col.BILATERAL else row[col.R_MAX]
        if abs(wanted) > most:  # a joint's or a motor's, too, and of one backwards, as in ODE
            wanted = most
        row[col.R_RHS] = (wanted / step - total) * scale
        row[col.R_CFM] = scale * softness
        for k in range(12):
            row[col.R_J + k] *= scale
        row[col.R_L] = row[col.R_L2] = 0.0
        j = links[i, 3]
        if j >= 0:
            row[col.R_L] = col.WARM_START * joints[j, col.WARM + links[i, 4]]
            row[col.R_L2] = col.WARM_START * joints[j, col.WARM2 + links[i, 4]]
            for k in range(6):
                work[one, col.W_A + 2 * k] += row[col.R_L] * row[col.R_M + k]
                work[one, col.W_A + 2 * k + 1] += row[col.R_L2] * row[col.R_M + k]
            if two >= 0:
                for k in range(6):
                    work[two, col.W_A + 2 * k] += row[col.R_L] * row[col.R_M + 6 + k]
                    work[two, col.W_A + 2 * k + 1] += row[col.R_L2] * row[col.R_M + 6 + k]


@compiled
def _solve_group(
    group: int, system: System, sequence: Array, constraints: Constraints, blocks: Blocks,
    islands: Islands, settings: Array,
) -> None:  # fmt: skip
    """Impulses of the rows of a group, and what they do to its bodies."""
    _relax(group, system, sequence, constraints, islands, settings)
    pack(group, constraints.rows, constraints.links, blocks, islands)
    iterate(islands.counts[1], group, blocks, islands)
    unpack(group, constraints.rows, constraints.links, blocks, islands)


@compiled
def solve_islands(
    system: System, sequence: Array, constraints: Constraints, blocks: Blocks, islands: Islands,
    settings: Array,
) -> None:  # fmt: skip
    """Solve the groups of a step, with the helpers if there are any."""
    shared, count = islands.shared, islands.counts[0]
    if shared[col.T_HELPERS] == 0 or count < 2:
        for group in range(count):
            _solve_group(group, system, sequence, constraints, blocks, islands, settings)
        return
    _write(shared, col.T_UNDONE, count)
    _write(shared, col.T_OFFERED, count)
    if shared[col.T_AWAKE] == 0:
        _write(shared, col.T_AWAKE, 1)
        for _ in range(shared[col.T_HELPERS]):
            _post(shared, col.T_SEMAPHORE)
    _take_groups(system, sequence, constraints, blocks, islands, settings)
    turns = 0
    while _read(shared, col.T_UNDONE) > 0:
        turns = _spin(turns)


@compiled
def end_islands(islands: Islands) -> None:
    """Let the helpers sleep."""
    _write(islands.shared, col.T_AWAKE, 0)


@compiled
def _spin(turns: int) -> int:
    """Wait a moment, the longer the more others need the processor."""
    if turns >= col.SPINS:
        _let_others_run()
    return turns + 1


@compiled
def _take_groups(
    system: System, sequence: Array, constraints: Constraints, blocks: Blocks, islands: Islands,
    settings: Array,
) -> bool:  # fmt: skip
    """Solve groups until none is left; whether there was one."""
    shared, found = islands.shared, False
    while _read(shared, col.T_OFFERED) > 0:
        group = _count_down(shared, col.T_OFFERED) - 1
        if group < 0:
            break
        _solve_group(group, system, sequence, constraints, blocks, islands, settings)
        _count_down(shared, col.T_UNDONE)
        found = True
    return found


@compiled
def help_solve(
    system: System, sequence: Array, constraints: Constraints, blocks: Blocks, islands: Islands,
    settings: Array,
) -> int:  # fmt: skip
    """What a helper does until T_ENDED is set."""
    shared, turns = islands.shared, 0
    while True:
        if _read(shared, col.T_AWAKE) == 0:
            _wait(shared, col.T_SEMAPHORE)
            turns = 0
            if _read(shared, col.T_ENDED) != 0:
                return 0
        elif _take_groups(system, sequence, constraints, blocks, islands, settings):
            turns = 0
        else:
            turns = _spin(turns)
