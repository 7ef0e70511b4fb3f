"""PIDs of joints, computed in each of several steps.

What one computes is in controllers/law.py, which controllers call from Python, too.
"""

import math
from typing import Any

from numba import types
from numba.extending import overload

from bullet_sim.controllers import law
from bullet_sim.engine.quickstep.compiled import compiled
from bullet_sim.engine.quickstep.layout import ANGLE, EFFORT, RATE
from bullet_sim.engine.quickstep.state import (
    EFFORT_ALONE,
    P_ANTIWINDUP,
    P_APPLIED,
    P_BY_ERROR,
    P_BY_INTEGRAL,
    P_BY_RATE,
    P_D,
    P_GOAL,
    P_HIGH,
    P_I,
    P_INTEGRAL,
    P_JOINT,
    P_LAST,
    P_LIMIT,
    P_LINEAR,
    P_LOW,
    P_LOWER,
    P_MAX,
    P_MIN,
    P_OUTPUT,
    P_P,
    P_RATE,
    P_SPEED,
    P_TARGET,
    P_TOP_EFFORT,
    P_TOP_SPEED,
    P_UPPER,
    POSITION,
)
from bullet_sim.pose import Array

_remainder = types.ExternalFunction("remainder", types.float64(types.float64, types.float64))


@overload(math.remainder)
def _math_remainder(x: Any, y: Any) -> Any:
    """That of the C library, which Python calls, too."""

    def remainder(x: Any, y: Any) -> Any:
        return _remainder(x, y)

    return remainder


_position_error = compiled(law.position_error)
_pid_terms = compiled(law.pid_terms)
_effort_bounds = compiled(law.effort_bounds)
_within = compiled(law.within)
_truncated = compiled(law.truncated)


@compiled
def apply_pids(period: float, pids: Array, active: Array, noted: Array, joints: Array) -> None:
    """Compute PIDs, and have their efforts act on the joints in the next step.

    Args:
        period: of a step [s].
        active: (3,) how many of the PIDs, whether to note the positions of joints, and how often
            that was done.
        noted: (MAX_NOTED_STEPS, j) positions [rad, m].
    """
    if active[1] != 0 and active[2] < len(noted):
        for j in range(len(joints)):
            noted[active[2], j] = joints[j, ANGLE]
        active[2] += 1
    for k in range(active[0]):
        row, joint = pids[k], joints[int(pids[k, P_JOINT])]
        angle, velocity = joint[ANGLE], joint[RATE]
        if row[P_GOAL] != EFFORT_ALONE:
            if row[P_GOAL] == POSITION:
                error = _position_error(
                    angle, row[P_TARGET], row[P_LOWER], row[P_UPPER], row[P_LINEAR] != 0.0
                )
            else:
                error = row[P_TARGET] - velocity
            rate = 0.0
            if not math.isnan(row[P_LAST]):
                rate = (error - row[P_LAST]) / period
            output, integral, by_error, by_integral, by_rate = _pid_terms(
                error, rate, row[P_INTEGRAL], period, row[P_P], row[P_I], row[P_D], row[P_LOW],
                row[P_HIGH], row[P_ANTIWINDUP] != 0.0,
            )  # fmt: skip
            if not math.isfinite(output):
                output = 0.0
            row[P_OUTPUT] = output
            if math.isfinite(error) and math.isfinite(rate):
                row[P_LAST], row[P_INTEGRAL], row[P_RATE] = error, integral, rate
                row[P_BY_ERROR], row[P_BY_INTEGRAL], row[P_BY_RATE] = by_error, by_integral, by_rate
        low, high = _effort_bounds(
            angle, velocity, row[P_LIMIT], row[P_MIN], row[P_MAX], row[P_SPEED]
        )
        row[P_APPLIED] = _within(row[P_OUTPUT], low, high)
        joint[EFFORT] += _truncated(row[P_APPLIED], velocity, row[P_TOP_SPEED], row[P_TOP_EFFORT])
