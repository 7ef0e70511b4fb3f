"""What a PID, the limits of its joint and a base that follows commands make of plain numbers.

Controllers and the solver 'bullet' call these functions as they are; the solver 'ode' has them
compiled (pids.py). Both give the same bits. A limit that is not there is NaN.
"""

from __future__ import annotations

import math
from typing import Any

from bullet_sim.engine.quickstep import layout as col

TOLERANCE = 1e-9  # [rad] by which rounding may put an angle beyond a limit
TURN = 2.0 * math.pi
WAY_SHORT, WAY_LINEAR, WAY_WITHIN = 0.0, 1.0, 2.0  # of the error of a position


def ahead(
    x: float, y: float, z: float, w: float, forward: float, left: float
) -> tuple[float, float]:
    """Horizontal velocity (2,) [m/s] in the world of a body with a quaternion that moves forward
    and to the left of its heading [m/s], that of pose.rpy_from_quaternion()."""
    yaw = math.remainder(math.atan2(z + x, w - y) + math.atan2(z - x, w + y), TURN)
    c, s = math.cos(yaw), math.sin(yaw)
    return c * forward - s * left, s * forward + c * left


def position_error(position: float, target: float, lower: float, upper: float, way: float) -> float:
    """Error [rad, m] of a joint's position, as ros_control's position controllers see it.

    Args:
        position, target: [rad, m]; a target beyond the limits counts as the limit.
        way: WAY_LINEAR: the difference; WAY_SHORT: it may lead across half a rotation;
            WAY_WITHIN: as distance_with_limits().

    Returns:
        WAY_SHORT: the shorter way if it ends within the limits, else the longer one if that does,
        else the difference.
    """
    if target < lower:
        target = lower
    elif target > upper:
        target = upper
    if way == WAY_LINEAR or math.isinf(position - target):
        return target - position
    if way == WAY_WITHIN:
        return distance_with_limits(position, target, lower, upper)
    short = -math.remainder(position - target, TURN)
    if math.isnan(lower) or lower - TOLERANCE <= position + short <= upper + TOLERANCE:
        return short
    long = short - math.copysign(TURN, short)
    if lower - TOLERANCE <= position + long <= upper + TOLERANCE:
        return long
    return target - position


def normalized(angle: float) -> float:
    """angles::normalize_angle: an angle in (-pi, pi] [rad]."""
    rest = math.fmod(angle + math.pi, TURN)
    return rest + math.pi if rest <= 0.0 else rest - math.pi


def other_way(angle: float) -> float:
    """angles::two_pi_complement: the way round in the other direction [rad]."""
    if abs(angle) > TURN:
        angle = math.fmod(angle, TURN)
    if angle < 0.0:
        return TURN + angle
    return angle - TURN if angle > 0.0 else TURN


def room(start: float, lower: float, upper: float) -> tuple[float, float, bool]:
    """angles::find_min_max_delta: how far it may turn from an angle [rad].

    Args:
        lower, upper: limits, of which it knows only where they are on the circle: between such
            beyond half a rotation it finds no room, or other room than there is.

    Returns:
        least, most, whether the angle is within the limits.
    """
    down, up = normalized(lower - start), normalized(upper - start)
    down_other, up_other = other_way(down), other_way(up)
    if down == 0.0:
        return down, max(up, up_other), True
    if up == 0.0:
        return min(down, down_other), up, True
    if down_other < down:
        down, down_other = down_other, down
    if up_other > up:
        up, up_other = up_other, up
    if down <= up_other or up >= down_other:
        return up_other, down_other, lower == -math.pi and upper == math.pi
    return down, up, True


def distance_with_limits(start: float, end: float, lower: float, upper: float) -> float:
    """angles::shortest_angular_distance_with_limits (ros/angles 1.9), wrong ways included [rad].

    It is gazebo_ros_control's for a revolute joint that follows positions by a PID.
    """
    least, most, is_within = room(start, lower, upper)
    short = normalized(end - start)
    other = other_way(short)
    if is_within:
        if least <= short <= most:
            return short
        if least <= other <= most:
            return other
        first, second, _ = room(end, lower, upper)
        if abs(first) != abs(second):
            return max(short, other) if abs(first) < abs(second) else min(short, other)
    elif abs(least) != abs(most):
        return min(short, other) if abs(least) < abs(most) else max(short, other)
    return short if abs(short) < abs(other) else other


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
    position: float, velocity: float, limit: float, lower: float, upper: float, speed: float,
    soft_lower: float, soft_upper: float, k_position: float, k_velocity: float,
) -> tuple[float, float]:  # fmt: skip
    """Min and max effort [N m, N] that a joint may get, as joint_limits_interface's
    EffortJointSaturationHandle: its limit, and no push further beyond a limit of position or
    velocity; with soft limits as its EffortJointSoftLimitsHandle.

    Args:
        limit: of the effort.
        lower, upper: limits of the position [rad, m].
        speed: limit of the velocity [rad/s, m/s].
        soft_lower, soft_upper: soft limits of the position [rad, m].
        k_position: velocity per distance from there [1/s].
        k_velocity: effort per velocity beyond its bounds [N m s/rad, N s/m]; NaN: no soft limits.
    """
    if not math.isnan(k_velocity):
        slow, fast = -speed, speed
        if not (math.isinf(lower) and math.isinf(upper)):
            slow = min(max(-k_position * (position - soft_lower), -speed), speed)
            fast = min(max(-k_position * (position - soft_upper), -speed), speed)
        low = min(max(-k_velocity * (velocity - slow), -limit), limit)
        return low, min(max(-k_velocity * (velocity - fast), -limit), limit)
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
            error = position_error(position, row[col.PID_TARGET], lower, upper, row[col.PID_WAY])
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
    low, high = effort_bounds(
        position, velocity, row[col.PID_LIMIT], lower, upper, speed, row[col.PID_SOFT_MIN],
        row[col.PID_SOFT_MAX], row[col.PID_K_POSITION], row[col.PID_K_VELOCITY],
    )  # fmt: skip
    within_limits = within(row[col.PID_OUTPUT], low, high)
    applied = truncated(within_limits, velocity, row[col.PID_TOP_SPEED], row[col.PID_TOP_EFFORT])
    row[col.PID_APPLIED] = applied
    return applied
