"""Screws and gears: angles between bodies, and rows that couple rotations with each other and with
what moves along an axis.

Sources: ODE's hinges, and the screw and gearbox joints that Gazebo has added to it.
"""

import math

from bullet_sim.engine.quickstep import layout as col
from bullet_sim.engine.quickstep.compiled import compiled, temporary
from bullet_sim.engine.quickstep.state import Constraints, System
from bullet_sim.engine.quickstep.vectors import copy, cross, matrix, multiply, rotate
from bullet_sim.pose import Array


@compiled
def turned(one: int, two: int, relative: Array, axis: Array, last: float, bodies: Array) -> float:
    """Angle [rad] by which a body is turned in another one, with whole rotations.

    Args:
        two: -1: the world.
        relative: (4,) quaternion of the first in the second at 0.
        axis: (3,) in the first body.
        last: the angle before, from which it is half a rotation away at most.
    """
    error, inverse = temporary(4), temporary(4)
    if two >= 0:
        multiply(bodies[two, col.QUAT : col.QUAT + 4], relative, error)
    else:
        copy(relative, error)
    for k in range(3):
        inverse[k] = -error[k]
    inverse[3] = error[3]
    multiply(inverse, bodies[one, col.QUAT : col.QUAT + 4], error)
    sine = error[0] * axis[0] + error[1] * axis[1]
    sine += error[2] * axis[2]
    tilted = math.sqrt(error[0] ** 2 + error[1] ** 2 + error[2] ** 2)
    change = 2.0 * math.atan2(math.copysign(tilted, sine), error[3]) - last
    change -= 2.0 * math.pi * math.floor(change / (2.0 * math.pi) + 0.5)
    return last + change


@compiled
def measure_screw(j: int, system: System) -> None:
    """Angle and rate of a screw."""
    joint, one, two = system.joints[j], system.types[j, 1], system.types[j, 2]
    bodies, rotation, axis = system.bodies, temporary(9), temporary(3)
    relative, own = joint[col.QREL : col.QREL + 4], joint[col.AXIS1 : col.AXIS1 + 3]
    joint[col.ANGLE] = turned(one, two, relative, own, joint[col.ANGLE], bodies)
    matrix(bodies[one, col.QUAT : col.QUAT + 4], rotation)
    rotate(rotation, own, axis)
    rate = 0.0
    for k in range(3):
        spin = bodies[one, col.VEL + 3 + k]
        if two >= 0:
            spin -= bodies[two, col.VEL + 3 + k]
        rate += axis[k] * spin
    joint[col.RATE] = rate


@compiled
def screw_rows(
    gain: float,
    m: int,
    j: int,
    a1: Array,
    a2: Array,
    across: Array,
    system: System,
    rows: Array,
) -> int:
    """Rows by which a screw's anchors meet across its axis, and by which it moves along the axis as
    its thread says; arguments as those of constraints._anchor_rows() and _axis_rows()."""
    joint, bodies, work = system.joints[j], system.bodies, system.work
    one, two = system.types[j, 1], system.types[j, 2]
    arm, start, rotation, axis = temporary(3), temporary(3), temporary(9), temporary(3)
    rotate(work[one, col.W_R : col.W_R + 9], joint[col.AXIS1 : col.AXIS1 + 3], axis)
    for i in range(2):
        t, row = across[i], rows[m]
        error = 0.0
        cross(a1, t, row[col.R_J + 3 : col.R_J + 6])
        for k in range(3):
            row[col.R_J + k] = t[k]
            there = a2[k] + bodies[two, col.POS + k] if two >= 0 else a2[k]
            error += (there - a1[k] - bodies[one, col.POS + k]) * t[k]
        if two >= 0:
            cross(t, a2, row[col.R_J + 9 : col.R_J + 12])
            for k in range(3):
                row[col.R_J + 6 + k] = -t[k]
        row[col.R_C] = gain * error
        m += 1
    # where the first body's center is at 0, from the second one's
    matrix(joint[col.QREL : col.QREL + 4], rotation)
    rotate(rotation, joint[col.ANCHOR1 : col.ANCHOR1 + 3], arm)
    for k in range(3):
        start[k] = joint[col.ANCHOR2 + k] - arm[k]
    if two >= 0:
        rotate(work[two, col.W_R : col.W_R + 9], start, start)
        for k in range(3):
            start[k] += bodies[two, col.POS + k]
    along = 0.0
    for k in range(3):
        along += axis[k] * (bodies[one, col.POS + k] - start[k])
    row, pitch = rows[m], joint[col.PITCH]
    straight, round_ = pitch, 1.0  # the whole row times the pitch where that is small
    if abs(pitch) > 1.0:
        straight, round_ = 1.0, 1.0 / pitch
    for k in range(3):
        row[col.R_J + k], row[col.R_J + 3 + k] = axis[k] * straight, -axis[k] * round_
        if two >= 0:
            row[col.R_J + 6 + k], row[col.R_J + 9 + k] = -axis[k] * straight, axis[k] * round_
    row[col.R_C] = -gain * (straight * along - round_ * joint[col.ANGLE])
    return m + 1


@compiled
def gear_row(
    gain: float, softness: float, m: int, j: int, system: System, constraints: Constraints
) -> None:
    """The row by which two bodies rotate as gears, against a third body; the angles are measured
    here."""
    joint, bodies, work = system.joints[j], system.bodies, system.work
    row, links, axis = constraints.rows[m], constraints.links, temporary(3)
    one, two, base = system.types[j, 1], system.types[j, 2], int(joint[col.GEAR_BASE])
    ratio = joint[col.PITCH]
    for k in range(12):
        row[col.R_J + k] = 0.0
    for place in range(2):
        body, own = (one, col.AXIS1) if place == 0 else (two, col.AXIS2)
        start, angle = (col.QREL, col.ANGLE) if place == 0 else (col.GEAR_QREL, col.GEAR_ANGLE)
        joint[angle] = turned(
            body, base, joint[start : start + 4], joint[own : own + 3], joint[angle], bodies
        )
        rotate(work[body, col.W_R : col.W_R + 9], joint[own : own + 3], axis)
        for k in range(3):
            row[col.R_J + 3 + 6 * place + k] = axis[k] if place == 0 else ratio * axis[k]
    error = joint[col.ANGLE] + ratio * joint[col.GEAR_ANGLE]
    error -= 2.0 * math.pi * math.floor(error / (2.0 * math.pi) + 0.5)
    row[col.R_C] = -gain * error
    row[col.R_CFM] = softness
    row[col.R_LOW], row[col.R_HIGH] = -col.INFINITE, col.INFINITE
    links[m, 0], links[m, 1], links[m, 2], links[m, 3], links[m, 4] = one, two, col.BILATERAL, j, 0
