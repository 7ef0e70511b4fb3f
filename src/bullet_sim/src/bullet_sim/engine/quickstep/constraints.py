"""Rows of constraints, in the order in which ODE finds them.

A row is one equation of the velocities of one or two bodies: its Jacobian, its right side and its
bounds. Functions that add rows take the number m of the first, and give the number of all then.

Source: R. Smith, "Constraints in rigid body dynamics" (2004).
"""

from __future__ import annotations

import math

from bullet_sim.engine.quickstep import layout as col
from bullet_sim.engine.quickstep.compiled import compiled, inlined, temporary
from bullet_sim.engine.quickstep.screws import gear_row, screw_rows
from bullet_sim.engine.quickstep.state import Constraints, Contacts, Islands, System
from bullet_sim.engine.quickstep.vectors import (
    copy,
    cross,
    invert,
    multiply,
    plane_space,
    rotate,
)
from bullet_sim.pose import Array


@inlined
def _bounce(contact: Array, row: Array, bodies: Array, one: int, two: int) -> float:
    """Speed [m/s] at which a contact's normal sends its bodies apart; row: with the normal's
    Jacobian."""
    speed = 0.0
    for k in range(6):
        speed -= row[col.R_J + k] * bodies[one, col.VEL + k]
        if two >= 0:
            speed -= row[col.R_J + 6 + k] * bodies[two, col.VEL + k]
    return contact[col.C_BOUNCE] * speed if speed > contact[col.C_BOUNCE + 1] else 0.0


@inlined
def _torsion_row(m: int, normal_row: int, contact: Array, constraints: Constraints) -> int:
    """The row of torsional friction, about the normal of a contact, if its patch has a size."""
    radius = contact[col.C_PATCH]
    if contact[col.C_RADIUS] > 0.0:
        radius = math.sqrt(contact[col.C_RADIUS] * max(0.0, contact[col.C_DEPTH]))
    if radius <= 0.0:
        return m
    row, links = constraints.rows[m], constraints.links
    for k in range(12):
        row[col.R_J + k] = 0.0
    links[m, 0], links[m, 1] = links[normal_row, 0], links[normal_row, 1]
    for k in range(3):
        row[col.R_J + 3 + k] = contact[col.C_NORMAL + k]
        if links[m, 1] >= 0:
            row[col.R_J + 9 + k] = -contact[col.C_NORMAL + k]
    bound = col.TORSION * radius * contact[col.C_TORSION]
    row[col.R_C], row[col.R_MAX], row[col.R_CFM] = 0.0, col.INFINITE, contact[col.C_TWIST_SLIP]
    row[col.R_LOW], row[col.R_HIGH] = -bound, bound
    links[m, 2], links[m, 3] = normal_row, -1
    return m + 1


@inlined
def _contact_rows(
    step: float, m: int, n: int, contacts: Contacts, bodies: Array, constraints: Constraints
) -> int:
    """Rows of contact n: its normal, up to two directions of friction, and torsion."""
    contact, links = contacts.rows[n], constraints.links
    one, two = contacts.owners[n, 0], contacts.owners[n, 1]
    arm, arm2, t, q = temporary(3), temporary(3), temporary(3), temporary(3)
    for k in range(3):
        arm[k] = contact[col.C_POINT + k] - bodies[one, col.POS + k]
        if two >= 0:
            arm2[k] = contact[col.C_POINT + k] - bodies[two, col.POS + k]
    normal_row = m
    contacts.first_row[n] = m
    for direction in range(3):
        if direction == 0:
            for k in range(3):
                t[k] = contact[col.C_NORMAL + k]
        else:
            if contact[col.C_MU + direction - 1] <= 0.0:
                continue
            normal = contact[col.C_NORMAL : col.C_NORMAL + 3]
            fdir = contact[col.C_FDIR : col.C_FDIR + 3]
            cross(normal, fdir, q)
            if q[0] == 0.0 and q[1] == 0.0 and q[2] == 0.0:
                plane_space(normal, t, q)
            else:
                for k in range(3):
                    t[k] = fdir[k]
            if direction == 2:
                for k in range(3):
                    t[k] = q[k]
        row = constraints.rows[m]
        for k in range(12):
            row[col.R_J + k] = 0.0
        for k in range(3):
            row[col.R_J + k] = t[k]
        cross(arm, t, row[col.R_J + 3 : col.R_J + 6])
        if two >= 0:
            cross(arm2, t, row[col.R_J + 9 : col.R_J + 12])
            for k in range(3):
                row[col.R_J + 6 + k] = -t[k]
                row[col.R_J + 9 + k] = -row[col.R_J + 9 + k]
        links[m, 0], links[m, 1], links[m, 3] = one, two, -1
        if direction == 0:
            row[col.R_C] = contact[col.C_ERP] / step * max(0.0, contact[col.C_DEPTH])
            row[col.R_MAX], row[col.R_CFM] = contact[col.C_MAX], contact[col.C_CFM]
            row[col.R_LOW], row[col.R_HIGH], links[m, 2] = 0.0, col.INFINITE, col.UNILATERAL
            if contact[col.C_BOUNCE] > 0.0:
                row[col.R_C] = max(row[col.R_C], _bounce(contact, row, bodies, one, two))
        else:
            mu = contact[col.C_MU + direction - 1]
            row[col.R_C], row[col.R_MAX] = 0.0, col.INFINITE
            row[col.R_CFM] = contact[col.C_SLIP + direction - 1]
            row[col.R_LOW], row[col.R_HIGH], links[m, 2] = -mu, mu, normal_row
        m += 1
    if contact[col.C_TORSION] > 0.0:
        m = _torsion_row(m, normal_row, contact, constraints)
    return m


@inlined
def _anchor_rows(
    gain: float, m: int, ends: tuple[int, int], a1: Array, a2: Array, bodies: Array, rows: Array
) -> int:
    """Rows by which the anchors of two bodies meet.

    Args:
        gain: fraction of an error that is corrected, per step [1/s].
        ends: both bodies.
        a1, a2: (3,) anchors, from the bodies' centers.
    """
    unit, (one, two) = temporary(3), ends
    for i in range(3):
        row = rows[m]
        row[col.R_J + i] = 1.0
        unit[0] = unit[1] = unit[2] = 0.0
        unit[i] = 1.0
        cross(a1, unit, row[col.R_J + 3 : col.R_J + 6])
        error = a2[i] - bodies[one, col.POS + i] - a1[i]
        if two >= 0:
            row[col.R_J + 6 + i] = -1.0
            cross(a2, unit, row[col.R_J + 9 : col.R_J + 12])
            for k in range(3):
                row[col.R_J + 9 + k] = -row[col.R_J + 9 + k]
            error = bodies[two, col.POS + i] + a2[i] - bodies[one, col.POS + i] - a1[i]
        row[col.R_C] = gain * error
        m += 1
    return m


@inlined
def _axis_rows(
    gain: float, m: int, two: int, ax1: Array, ax2: Array, across: Array, rows: Array
) -> int:
    """Rows by which a hinge's axes in both bodies meet.

    Args:
        ax1, ax2: (3,) axes.
        across: (2, 3) directions across the first.
    """
    turn = temporary(3)
    cross(ax1, ax2, turn)
    for i in range(2):
        t, row = across[i], rows[m]
        for k in range(3):
            row[col.R_J + 3 + k] = t[k]
            if two >= 0:
                row[col.R_J + 9 + k] = -t[k]
        row[col.R_C] = gain * (turn[0] * t[0] + turn[1] * t[1] + turn[2] * t[2])
        m += 1
    return m


@compiled
def _rotation_rows(
    gain: float, m: int, ends: tuple[int, int], joint: Array, bodies: Array, rows: Array
) -> int:
    """Rows by which two bodies do not rotate in each other."""
    error, inverse, (one, two) = temporary(4), temporary(4), ends
    if two >= 0:
        orientation = bodies[two, col.QUAT : col.QUAT + 4]
        multiply(orientation, joint[col.QREL : col.QREL + 4], error)
    else:
        copy(joint[col.QREL : col.QREL + 4], error)
    for k in range(3):
        inverse[k] = -bodies[one, col.QUAT + k]
    inverse[3] = bodies[one, col.QUAT + 3]
    multiply(error, inverse, error)
    sign = -2.0 if error[3] < 0.0 else 2.0
    for i in range(3):
        row = rows[m]
        row[col.R_J + 3 + i] = 1.0
        if two >= 0:
            row[col.R_J + 9 + i] = -1.0
        row[col.R_C] = gain * sign * error[i]
        m += 1
    return m


@compiled
def _line_rows(
    gain: float,
    m: int,
    ends: tuple[int, int],
    a2: Array,
    across: Array,
    bodies: Array,
    rows: Array,
) -> int:
    """Rows by which a slider's anchors meet, but along its axis; arguments as those of
    _anchor_rows() and _axis_rows()."""
    gap, turn, (one, two) = temporary(3), temporary(3), ends
    for k in range(3):
        there = bodies[two, col.POS + k] if two >= 0 else 0.0
        gap[k] = there - bodies[one, col.POS + k]
    for i in range(2):
        t, row = across[i], rows[m]
        cross(gap, t, turn)
        error = 0.0
        for k in range(3):
            row[col.R_J + k] = t[k]
            if two >= 0:
                row[col.R_J + 3 + k] = 0.5 * turn[k]
                row[col.R_J + 6 + k] = -t[k]
                row[col.R_J + 9 + k] = 0.5 * turn[k]
            error += t[k] * (gap[k] + a2[k])
        row[col.R_C] = gain * error
        m += 1
    return m


@compiled
def _rescale_inertias(work: Array, one: int, two: int, axis: Array) -> None:
    """Move the inertias of two hinged bodies along a constrained axis closer to each other."""
    m1 = m2 = 0.0
    for i in range(3):
        for j in range(3):
            m1 += axis[i] * work[one, col.W_I + 3 * i + j] * axis[j]
            m2 += axis[i] * work[two, col.W_I + 3 * i + j] * axis[j]
    large, small = one, two
    if m2 > m1:
        large, small, m1, m2 = two, one, m2, m1
    if m1 <= col.INERTIA_RATIO * m2:
        return
    moved = (m1 - col.INERTIA_RATIO * m2) / (1.0 + col.INERTIA_RATIO)
    dominant = True  # the matrices' diagonals, also afterwards
    for i in range(3):
        rest_large = rest_small = 0.0
        for j in range(3):
            if j != i:
                part = moved * axis[i] * axis[j]
                rest_large += abs(work[large, col.W_I + 3 * i + j] - part)
                rest_small += abs(work[small, col.W_I + 3 * i + j] + part)
        part = moved * axis[i] * axis[i]
        if (
            work[large, col.W_I + 4 * i] - part <= rest_large
            or work[small, col.W_I + 4 * i] + part <= rest_small
        ):
            dominant = False
    if dominant:
        for i in range(3):
            for j in range(3):
                part = moved * axis[i] * axis[j]
                work[large, col.W_I + 3 * i + j] -= part
                work[small, col.W_I + 3 * i + j] += part
    for body in (one, two):
        invert(work[body, col.W_I : col.W_I + 9], work[body, col.W_V : col.W_V + 9])


@inlined
def _joint_rows(
    step: float, m: int, j: int, system: System, constraints: Constraints, settings: Array
) -> int:
    """Rows of joint j."""
    joint, bodies, work = system.joints[j], system.bodies, system.work
    rows, links = constraints.rows, constraints.links
    kind, one, two = system.types[j, 0], system.types[j, 1], system.types[j, 2]
    a1, a2, ax1, ax2 = temporary(3), temporary(3), temporary(3), temporary(3)
    across, first, ends = temporary(2, 3), m, (one, two)
    rotate(work[one, col.W_R : col.W_R + 9], joint[col.ANCHOR1 : col.ANCHOR1 + 3], a1)
    rotate(work[one, col.W_R : col.W_R + 9], joint[col.AXIS1 : col.AXIS1 + 3], ax1)
    if two >= 0:
        rotate(work[two, col.W_R : col.W_R + 9], joint[col.ANCHOR2 : col.ANCHOR2 + 3], a2)
        rotate(work[two, col.W_R : col.W_R + 9], joint[col.AXIS2 : col.AXIS2 + 3], ax2)
    else:
        for k in range(3):
            a2[k], ax2[k] = joint[col.ANCHOR2 + k], joint[col.AXIS2 + k]
    gain = (joint[col.ERP] if joint[col.ERP] >= 0.0 else settings[col.S_ERP]) / step
    softness = joint[col.CFM] if joint[col.CFM] >= 0.0 else settings[col.S_CFM]
    if kind == col.GEARS:
        gear_row(gain, softness, m, j, system, constraints)
        return m + 1
    for i in range(6 if kind == col.FIXED else 5):
        for k in range(12):
            rows[m + i, col.R_J + k] = 0.0
    if kind != col.FIXED:
        plane_space(ax1, across[0], across[1])
    if kind == col.SCREW:
        m = screw_rows(gain, m, j, a1, a2, across, system, rows)
    elif kind != col.SLIDER:
        m = _anchor_rows(gain, m, ends, a1, a2, bodies, rows)
    if kind == col.SCREW:
        m = _axis_rows(gain, m, two, ax1, ax2, across, rows)
    elif kind == col.HINGE:
        m = _axis_rows(gain, m, two, ax1, ax2, across, rows)
        if two >= 0 and settings[col.S_RESCALE] != 0.0:
            for i in range(2):
                _rescale_inertias(work, one, two, across[i])
    else:
        m = _rotation_rows(gain, m, ends, joint, bodies, rows)
    if kind == col.SLIDER:
        m = _line_rows(gain, m, ends, a2, across, bodies, rows)
    for i in range(first, m):
        row = rows[i]
        row[col.R_CFM] = softness
        row[col.R_LOW], row[col.R_HIGH], links[i, 2] = -col.INFINITE, col.INFINITE, col.BILATERAL
    if kind != col.FIXED:
        m = _limit_row(step, softness, m, j, ax1, system, constraints)
    for i in range(first, m):
        links[i, 0], links[i, 1], links[i, 3], links[i, 4] = one, two, j, i - first
    return m


@inlined
def _limit_row(
    step: float,
    cfm: float,
    m: int,
    j: int,
    axis: Array,
    system: System,
    constraints: Constraints,
) -> int:
    """The row of a joint's motor, limit or damping, if it needs one.

    Args:
        cfm: of a motor.
        axis: (3,) of the joint.
    """
    joint, bodies, work, links = system.joints[j], system.bodies, system.work, constraints.links
    kind, one, two = system.types[j, 0], system.types[j, 1], system.types[j, 2]
    position, limit = joint[col.ANGLE], 0
    if joint[col.LOWER] <= joint[col.UPPER]:
        limit = 1 if position <= joint[col.LOWER] else 2 if position >= joint[col.UPPER] else 0
    softness = step * joint[col.STIFFNESS] + joint[col.DAMPING]
    damped = joint[col.IMPLICIT] != 0.0 and softness > 0.0
    if damped and joint[col.LOWER] <= joint[col.UPPER]:
        # As ODEJoint::ApplyImplicitStiffnessDamping: not where it is near a limit two steps later.
        ahead = position + 2.0 * joint[col.RATE] * step
        damped = joint[col.LOWER] < ahead < joint[col.UPPER]
    limit = 0 if damped else limit
    is_locked = joint[col.LOWER] == joint[col.UPPER]
    powered = joint[col.FMAX] > 0.0 and not (damped or limit and is_locked)
    if kind == col.SCREW and limit == 0:
        powered = False  # ODE counts no row for it
    if not (powered or limit or damped):
        return m
    row, shift = constraints.rows[m], 0 if kind == col.SLIDER else 3
    for k in range(12):
        row[col.R_J + k] = 0.0
    for k in range(3):
        row[col.R_J + shift + k] = axis[k]
        if two >= 0:
            row[col.R_J + 6 + shift + k] = -axis[k]
    if shift == 0 and two >= 0:  # both forces on one line
        arm = temporary(3)
        for k in range(3):
            arm[k] = 0.5 * (bodies[two, col.POS + k] - bodies[one, col.POS + k])
        cross(arm, axis, row[col.R_J + 3 : col.R_J + 6])
        for k in range(3):
            row[col.R_J + 9 + k] = row[col.R_J + 3 + k]
    row[col.R_CFM] = cfm
    row[col.R_LOW], row[col.R_HIGH], links[m, 2] = -col.INFINITE, col.INFINITE, col.BILATERAL
    if damped:  # a limit at both sides that yields as a spring and a damper do
        row[col.R_C] = -joint[col.STIFFNESS] / softness * (position - joint[col.AT_REST])
        row[col.R_CFM] = 1.0 / softness
    elif limit:
        if powered:
            push = _push_at_limit(limit, joint)
            for k in range(6):
                work[one, col.W_F + k] -= push * row[col.R_J + k]
                if two >= 0:
                    work[two, col.W_F + k] -= push * row[col.R_J + 6 + k]
        stop = joint[col.LOWER] if limit == 1 else joint[col.UPPER]
        row[col.R_C] = -joint[col.STOP_ERP] / step * (position - stop)
        row[col.R_CFM] = joint[col.STOP_CFM]
        if joint[col.LOWER] < joint[col.UPPER]:  # it holds in one direction
            row[col.R_LOW if limit == 1 else col.R_HIGH] = 0.0
            bounced = -joint[col.BOUNCE] * joint[col.RATE]
            if joint[col.BOUNCE] <= 0.0:
                pass
            elif limit == 1 and joint[col.SPEED] < 0.0:  # as in ODE: of the motor, not of the joint
                row[col.R_C] = max(row[col.R_C], bounced)
            elif limit == 2 and joint[col.RATE] > 0.0:
                row[col.R_C] = min(row[col.R_C], bounced)
    else:
        row[col.R_C] = joint[col.SPEED]
        row[col.R_LOW], row[col.R_HIGH] = -joint[col.FMAX], joint[col.FMAX]
    return m + 1


@inlined
def _push_at_limit(limit: int, joint: Array) -> float:
    """Effort [N m, N] of a motor at a joint's lower (1) or upper (2) limit, against its axis: the
    whole, or a part of it away from the limit."""
    push = joint[col.FMAX]
    if joint[col.SPEED] > 0.0 or (joint[col.SPEED] == 0.0 and limit == 2):
        push = -push
    if limit == 1 and joint[col.SPEED] > 0.0 or limit == 2 and joint[col.SPEED] < 0.0:
        push *= joint[col.STOP_PUSH]
    return push


@inlined
def add_rows(
    n: int,
    system: System,
    contacts: Contacts,
    constraints: Constraints,
    islands: Islands,
    marks: Array,
    sequence: Array,
    settings: Array,
) -> int:
    """Rows of all constraints; their number.

    From the body that was added last to the first: its contacts, the last first, its joints, the
    last first, and depth first what they connect it with.

    Contacts of bodies that sleep have none.

    Args:
        n: number of contacts.
        islands: has the time step; gets where groups of them begin.
        marks: (4, k) numbers to work with.
        sequence: gets the bodies in that order.
    """
    bodies, types, lists, owners = system.bodies, system.types, system.lists, contacts.owners
    step, count, m, top, placed = islands.step[0], len(bodies), 0, 0, 0
    body_seen, joint_seen, stack = marks[0], marks[1], marks[2]
    contact_seen, starts = marks[3], islands.starts
    group, at = 0, col.WEIGHTS  # where the blocks of the rows are, at most
    starts[0, col.I_ROW], starts[0, col.I_BODY], starts[0, col.I_NUMBER] = 0, 0, at
    for b in range(count):
        body_seen[b] = 0
    for j in range(len(types)):
        joint_seen[j] = 0
    for i in range(n):
        contact_seen[i], contacts.first_row[i] = 0, -1
    for root in range(count - 1, -1, -1):
        if body_seen[root] or bodies[root, col.ASLEEP] != 0.0:
            continue
        first_row, first_body, first_number = m, placed, at  # of this island
        body_seen[root] = 1
        b = root
        while True:
            sequence[placed] = b
            bodies[b, col.PLACE] = placed
            bodies[b, col.ASLEEP] = 0.0  # what touches somebody awake
            placed += 1
            for i in range(n - 1, -1, -1):
                if contact_seen[i] or (owners[i, 0] != b and owners[i, 1] != b):
                    continue
                contact_seen[i] = 1
                before = m
                m = _contact_rows(step, m, i, contacts, bodies, constraints)
                at += (m - before) * col.CB_SIZE
                other = owners[i, 1] if owners[i, 0] == b else owners[i, 0]
                if other >= 0 and not body_seen[other]:
                    body_seen[other] = 1
                    stack[top] = other
                    top += 1
            for place in range(system.starts[b], system.starts[b + 1]):
                j = lists[place]
                if joint_seen[j]:
                    continue
                joint_seen[j] = 1
                before = m
                m = _joint_rows(step, m, j, system, constraints, settings)
                at += (m - before) * col.JB_SIZE
                other = types[j, 2] if types[j, 1] == b else types[j, 1]
                if other >= 0 and not body_seen[other]:
                    body_seen[other] = 1
                    stack[top] = other
                    top += 1
            if top == 0:
                break
            top -= 1
            b = stack[top]
        begin = starts[group, col.I_ROW]
        if m - begin > col.GROUP_ROWS and first_row > begin:
            group += 1
            starts[group, col.I_ROW], starts[group, col.I_BODY] = first_row, first_body
            starts[group, col.I_NUMBER] = first_number
    for b in range(count):
        if not body_seen[b]:
            sequence[placed] = b
            bodies[b, col.PLACE] = placed
            placed += 1
    starts[group + 1, col.I_ROW], starts[group + 1, col.I_BODY] = m, placed
    islands.counts[0] = group + 1
    return m
