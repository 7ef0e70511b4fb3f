"""What a PID and the limits of its joint make of plain numbers.

Controllers and the solver 'bullet' call these functions as they are; the solver 'ode' has them
compiled (pids.py). Both give the same bits. A limit that is not there is NaN.
"""

from __future__ import annotations

import math
from typing import Any

from bullet_sim.engine.quickstep import layout as col

TOLERANCE = 1e-9  # [rad] by which rounding may put an angle beyond a limit
TURN = 2.0 * math.pi


def position_error(
    position: float, target: float, lower: float, upper: float, is_linear: bool
) -> float:
    """Error [rad, m] of a joint's position, as ros_control's position controllers see it.

    Args:
        position, target: [rad, m]; a target beyond the limits counts as the limit.
        is_linear: the joint is prismatic; else the way may lead across half a rotation.

    Returns:
        Of a joint that rotates the shorter way if it ends within the limits, else the longer one
        if that does, else the difference.
    """
    if target < lower:
        target = lower
    elif target > upper:
        target = upper
    if is_linear or math.isinf(position - target):
        return target - position
    short = -math.remainder(position - target, TURN)
    if math.isnan(lower) or lower - TOLERANCE <= position + short <= upper + TOLERANCE:
        return short
    long = short - math.copysign(TURN, short)
    if lower - TOLERANCE <= position + long <= upper + TOLERANCE:
        return long
    return target - position


def pid_terms(
    error: float, rate: float, integral: float, period: float, p: float, i: float, d: float,
    low: float, high: float, antiwindup: bool,
) -> tuple[float, float, float, float, float]:  # fmt: skip
    """One computation of a PID.

    Args:
        integral: of the error, before this period [s].
        low, high: bounds of i times the integral.
        antiwindup: bound the integral itself, too.

    Returns:
        output, integral, and the parts of the output by error, integral and rate.
    """
    integral = integral + error * period
    if antiwindup and i != 0.0:
        first, last = low / i, high / i
        if first > last:
            first, last = last, first
        if integral < first:
            integral = first
        elif integral > last:
            integral = last
    by_integral = i * integral
    if by_integral < low:
        by_integral = low
    elif by_integral > high:
        by_integral = high
    by_error, by_rate = p * error, d * rate
    return 0.0 + by_error + by_integral + by_rate, integral, by_error, by_integral, by_rate


def effort_bounds(
    position: float, velocity: float, limit: float, lower: float, upper: float, speed: float
) -> tuple[float, float]:
    """Min and max effort [N m, N] that a joint may get, as ros_control's saturation: its limit, and
    no push further beyond a limit of position or velocity.

    Args:
        limit: of the effort.
        lower, upper: limits of the position [rad, m].
        speed: limit of the velocity [rad/s, m/s].
    """
    low = 0.0 if position < lower or velocity < -speed else -limit
    high = 0.0 if position > upper or velocity > speed else limit
    return low, high


def within(effort: float, low: float, high: float) -> float:
    """An effort within its bounds; one that is not finite counts as 0."""
    if low <= effort <= high:
        return effort
    if not math.isfinite(effort):
        return 0.0
    return low if effort < low else high


def truncated(effort: float, rate: float, speed: float, limit: float) -> float:
    """An effort [N m, N] as Gazebo lets it act (Joint::CheckAndTruncateForce): at most the joint's
    limit, and none that makes a joint faster which moves faster than its limit.

    Args:
        rate: velocity of the joint [rad/s, m/s].
        speed, limit: of velocity and effort; 0: none.
    """
    if speed != 0.0 and abs(rate) > speed and effort * rate > 0.0:
        effort = 0.0
    if limit != 0.0:
        if effort < -limit:
            effort = -limit
        elif effort > limit:
            effort = limit
    return effort


def effort_of(row: Any, position: float, velocity: float, period: float) -> float:
    """The effort [N m, N] that a row of efforts has act on its joint in the next step.

    Args:
        row: numbers in the columns PID_*, which get the new state.
        position, velocity: of the joint now [rad, m], [rad/s, m/s].
        period: of a step [s].
    """
    if row[col.PID_GOAL] != col.GOAL_EFFORT:
        if row[col.PID_GOAL] == col.GOAL_POSITION:
            lower, upper = row[col.PID_LOWER], row[col.PID_UPPER]
            is_linear = row[col.PID_LINEAR] != 0.0
            error = position_error(position, row[col.PID_TARGET], lower, upper, is_linear)
        else:
            error = row[col.PID_TARGET] - velocity
        rate = 0.0
        if not math.isnan(row[col.PID_LAST]):
            rate = (error - row[col.PID_LAST]) / period
        output, integral, by_error, by_integral, by_rate = pid_terms(
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
    low, high = effort_bounds(position, velocity, row[col.PID_LIMIT], lower, upper, speed)
    row[col.PID_APPLIED] = within(row[col.PID_OUTPUT], low, high)
    return truncated(
        row[col.PID_APPLIED], velocity, row[col.PID_TOP_SPEED], row[col.PID_TOP_EFFORT]
    )
