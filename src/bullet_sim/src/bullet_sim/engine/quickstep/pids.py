"""Efforts of joints, computed before each of several steps; what one computes is in law.py."""

import math
from typing import Any

from numba import types
from numba.extending import overload, register_jitable

from bullet_sim.engine.quickstep import law
from bullet_sim.engine.quickstep import layout as col
from bullet_sim.engine.quickstep.compiled import compiled
from bullet_sim.pose import Array

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
