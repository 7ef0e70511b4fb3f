"""The motion model: constant acceleration and constant turn rates in the robot's frame.

Position moves with velocity v and acceleration a, turned into the world by the angles q, which
move with the rates w:

    p' = p + R(q_m) (v dt + a dt^2 / 2),  q' = q + T(q_m) w dt,  v' = v + a dt,
    q_m = q + T(q) w dt / 2

T turns rates into the angles' derivatives. Taking R and T halfway (the midpoint rule) makes the
error of a turn of third order in the step.
"""

import math

import numpy as np

from robot_localization.estimate.state import (
    ACCELERATION,
    ANGLES,
    POSITION,
    RATES,
    SIZE,
    VELOCITY,
)
from robot_localization.rotation import matrix, wrap

STEEPEST = 1e-6  # smallest cosine of the pitch that is divided by
UNIT = np.eye(3)


def advance(state, step):
    """Moves a state on.

    Args:
        state: (15,).
        step: Time [s].

    Returns:
        (state (15,), its derivative by the state before (15, 15)).
    """
    rates = state[RATES]
    turn, turn_by_angles = _angle_rates(state[ANGLES], rates)
    middle = state[ANGLES] + 0.5 * step * (turn @ rates)
    middle_by_angles = UNIT + 0.5 * step * turn_by_angles
    middle_by_rates = 0.5 * step * turn
    turn, turn_by_middle = _angle_rates(middle, rates)
    way = step * state[VELOCITY] + 0.5 * step * step * state[ACCELERATION]
    rotation = matrix(*middle)
    way_by_middle = _rotated_by_angles(middle, rotation, way)

    after = state.copy()
    after[POSITION] += rotation @ way
    after[ANGLES] += step * (turn @ rates)
    after[ANGLES] = [wrap(angle) for angle in after[ANGLES]]
    after[VELOCITY] += step * state[ACCELERATION]

    jacobian = np.eye(SIZE)
    jacobian[POSITION, ANGLES] = way_by_middle @ middle_by_angles
    jacobian[POSITION, RATES] = way_by_middle @ middle_by_rates
    jacobian[POSITION, VELOCITY] = step * rotation
    jacobian[POSITION, ACCELERATION] = 0.5 * step * step * rotation
    jacobian[ANGLES, ANGLES] += step * (turn_by_middle @ middle_by_angles)
    jacobian[ANGLES, RATES] = step * (turn + turn_by_middle @ middle_by_rates)
    jacobian[VELOCITY, ACCELERATION] = step * UNIT
    return after, jacobian


def _angle_rates(angles, rates):
    """T of the angles, and the derivative of T w by the angles; both (3, 3)."""
    roll, pitch = angles[0], angles[1]
    sr, cr, sp, cp = math.sin(roll), math.cos(roll), math.sin(pitch), math.cos(pitch)
    cp = math.copysign(max(abs(cp), STEEPEST), cp)
    tp = sp / cp
    _, p, q = rates
    turn = np.array(((1.0, sr * tp, cr * tp), (0.0, cr, -sr), (0.0, sr / cp, cr / cp)))
    by_roll, by_pitch = cr * p - sr * q, sr * p + cr * q
    return turn, np.array(
        (
            (by_roll * tp, by_pitch / (cp * cp), 0.0),
            (-by_pitch, 0.0, 0.0),
            (by_roll / cp, by_pitch * tp / cp, 0.0),
        )
    )


def _rotated_by_angles(angles, rotation, vector):
    """Derivative of R(angles) vector by the angles, (3, 3)."""
    x, y, z = vector
    rx, ry, _ = rotation @ vector
    sy, cy = math.sin(angles[2]), math.cos(angles[2])
    sp, cp = math.sin(angles[1]), math.cos(angles[1])
    sr, cr = math.sin(angles[0]), math.cos(angles[0])
    by_roll = rotation @ (0.0, -z, y)
    ahead = -sp * x + cp * (sr * y + cr * z)  # of Ry Rx vector, by the pitch
    down = -cp * x - sp * (sr * y + cr * z)
    return np.array(
        ((by_roll[0], cy * ahead, -ry), (by_roll[1], sy * ahead, rx), (by_roll[2], down, 0.0))
    )
