"""PIDs of joints, computed in each of several steps.

What one computes is in controllers/law.py, which controllers call from Python, too.
"""

import math
from typing import Any

from numba import types
from numba.extending import overload

from bullet_sim.controllers import law
from bullet_sim.engine.quickstep import layout as col
from bullet_sim.engine.quickstep.compiled import compiled
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
            noted[active[2], j] = joints[j, col.ANGLE]
        active[2] += 1
    for k in range(active[0]):
        row, joint = pids[k], joints[int(pids[k, col.PID_JOINT])]
        angle, velocity = joint[col.ANGLE], joint[col.RATE]
        if row[col.PID_GOAL] != col.GOAL_EFFORT:
            if row[col.PID_GOAL] == col.GOAL_POSITION:
                lower, upper = row[col.PID_LOWER], row[col.PID_UPPER]
                is_linear = row[col.PID_LINEAR] != 0.0
                error = _position_error(angle, row[col.PID_TARGET], lower, upper, is_linear)
            else:
                error = row[col.PID_TARGET] - velocity
            rate = 0.0
            if not math.isnan(row[col.PID_LAST]):
                rate = (error - row[col.PID_LAST]) / period
            output, integral, by_error, by_integral, by_rate = _pid_terms(
                error, rate, row[col.PID_INTEGRAL], period,
                row[col.PID_P], row[col.PID_I], row[col.PID_D],
                row[col.PID_LOW], row[col.PID_HIGH], row[col.PID_ANTIWINDUP] != 0.0,
            )  # fmt: skip
            if not math.isfinite(output):
                output = 0.0
            row[col.PID_OUTPUT] = output
            if math.isfinite(error) and math.isfinite(rate):
                row[col.PID_LAST], row[col.PID_INTEGRAL], row[col.PID_RATE] = error, integral, rate
                row[col.PID_BY_ERROR], row[col.PID_BY_INTEGRAL] = by_error, by_integral
                row[col.PID_BY_RATE] = by_rate
        lower, upper, speed = row[col.PID_MIN], row[col.PID_MAX], row[col.PID_SPEED]
        low, high = _effort_bounds(angle, velocity, row[col.PID_LIMIT], lower, upper, speed)
        row[col.PID_APPLIED] = _within(row[col.PID_OUTPUT], low, high)
        joint[col.EFFORT] += _truncated(
            row[col.PID_APPLIED], velocity, row[col.PID_TOP_SPEED], row[col.PID_TOP_EFFORT]
        )
