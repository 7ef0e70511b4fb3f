"""Efforts of joints and velocities of bases, computed before each of several steps; what one
computes is in law.py."""

import math
from typing import Any

from numba import types
from numba.extending import overload, register_jitable

from bullet_sim.engine.quickstep import law
from bullet_sim.engine.quickstep import layout as col
from bullet_sim.engine.quickstep.compiled import compiled, temporary
from bullet_sim.engine.quickstep.state import System
from bullet_sim.engine.quickstep.vectors import multiply
from bullet_sim.pose import UNTURNED, Array

_of_two = types.float64(types.float64, types.float64)
_remainder = types.ExternalFunction("remainder", _of_two)
_fmod = types.ExternalFunction("fmod", _of_two)


@overload(math.remainder)
def _math_remainder(x: Any, y: Any) -> Any:
    """That of the C library, which Python calls, too."""

    def remainder(x: Any, y: Any) -> Any:
        return _remainder(x, y)

    return remainder


@overload(math.fmod)
def _math_fmod(x: Any, y: Any) -> Any:
    """As remainder."""

    def fmod(x: Any, y: Any) -> Any:
        return _fmod(x, y)

    return fmod


for _part in (
    law.normalized,
    law.other_way,
    law.room,
    law.distance_with_limits,
    law.position_error,
    law.pid_terms,
    law.effort_bounds,
    law.within,
    law.truncated,
):
    register_jitable(error_model="numpy")(_part)  # what effort_of() calls
_effort_of = compiled(law.effort_of)
_ahead = compiled(law.ahead)


@compiled
def apply_efforts(
    period: float, efforts: Array, active: Array, recorded: Array, joints: Array
) -> None:
    """Have efforts act on joints in the next step, PIDs' computed anew.

    Args:
        period: of a step [s].
        efforts: (j, PID_SIZE), rows of efforts.
        active: (3,) how many rows there are, whether to record the joints, and how often that was
            done.
        recorded: (2 * MAX_RECORDED, j) positions [rad, m] and, in the next row, velocities.
    """
    if active[1] != 0 and active[2] < len(recorded):
        for j in range(len(joints)):
            recorded[active[2], j] = joints[j, col.ANGLE]
            recorded[active[2] + 1, j] = joints[j, col.RATE]
        active[2] += 2
    for k in range(active[0]):
        row = efforts[k]
        joint = joints[int(row[col.PID_JOINT])]
        joint[col.EFFORT] += _effort_of(row, joint[col.ANGLE], joint[col.RATE], period)


@compiled
def hold_velocities(held: Array, count: int, system: System) -> None:
    """Set the velocities of bodies that follow their commands, and those of their joints to 0.

    Args:
        held: rows of HELD_SIZE; count: how many there are.
    """
    bodies, joints, turn = system.bodies, system.joints, temporary(4)
    for k in range(count):
        row = held[k]
        multiply(bodies[int(row[col.HELD_ROOT]), col.QUAT : col.VEL], UNTURNED, turn)
        x, y = _ahead(turn[0], turn[1], turn[2], turn[3], row[col.HELD_FORWARD], row[col.HELD_LEFT])
        for b in range(int(row[col.HELD_FIRST]), int(row[col.HELD_END])):
            body = bodies[b]
            body[col.VEL], body[col.VEL + 1] = x, y
            body[col.VEL + 2] = body[col.VEL + 3] = body[col.VEL + 4] = 0.0
            body[col.VEL + 5] = row[col.HELD_TURN]
            if body[col.MAY_SLEEP] != 0.0:
                body[col.REST], body[col.REST_STEPS] = col.REST_TIME, col.REST_COUNT
                body[col.ASLEEP] = 0.0
        for j in range(int(row[col.HELD_JOINT]), int(row[col.HELD_JOINT_END])):
            joints[j, col.RATE] = 0.0
