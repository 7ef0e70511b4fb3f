"""Rigid bodies in maximal coordinates, stepped as Gazebo Classic steps them: ODE's quick solver.

People tuned their robots in Gazebo, whose solver stops after 50 iterations of a slow kind; how a
car turns there is what that solver has come to until then. So its steps are made here: the same
rows of constraints in the same order, the same projected Gauss-Seidel iteration (relaxation 1.3,
for friction a quarter of it, 10 more iterations of friction alone, half of the joints' last
impulses to begin with), friction bounded along two directions, contacts at both rims of a cylinder,
two solutions: one that moves the bodies, and one whose push out of contacts is bounded, which they
keep as velocity.

Sources: Open Dynamics Engine, "User Guide"; R. Smith, "Constraints in rigid body dynamics" (2004);
Gazebo's parameters as of version 11 (dWorldCreate, ODEPhysics, ODELink, ODEJoint).

All quantities are numbers in arrays with one row per body, joint, shape, plane, contact or
constraint; the constants of layout.py are their columns. Units: m, kg, s, rad; world axes if
nothing else is said. numba compiles the functions. No operation is reordered, so that results are
the same on all processors.
"""

import math

from bullet_sim.engine.quickstep.blocks import iterate, pack, unpack
from bullet_sim.engine.quickstep.compiled import arrays_at, compiled, numba_type, temporary
from bullet_sim.engine.quickstep.contacts import find_contacts, place_solids
from bullet_sim.engine.quickstep.layout import (
    ANCHOR1,
    ANCHOR2,
    ANGLE,
    ASLEEP,
    AT_REST,
    AXIS1,
    AXIS2,
    BILATERAL,
    C_CFM,
    C_DEPTH,
    C_ERP,
    C_FDIR,
    C_FORCE,
    C_MAX,
    C_MU,
    C_NORMAL,
    C_POINT,
    C_SLIP,
    DAMPING,
    DECAY,
    DECAY_SPEED,
    EFFORT,
    FIXED,
    FMAX,
    FORCE,
    FRICTION_SCALE,
    GRAVITY,
    HINGE,
    IMPLICIT,
    IMPOSED,
    INERTIA,
    INERTIA_RATIO,
    INFINITE,
    INVERSE,
    LOWER,
    MASS,
    MAX_SPEED,
    MAY_SLEEP,
    MOTOR,
    PLACE,
    POS,
    QREL,
    QUAT,
    R_C,
    R_CFM,
    R_HIGH,
    R_J,
    R_L,
    R_L2,
    R_LOW,
    R_M,
    R_MAX,
    R_RHS,
    R_RHS2,
    RATE,
    REACHED,
    REST,
    REST_COUNT,
    REST_SPEED,
    REST_STEPS,
    REST_TIME,
    S_CFM,
    S_ERP,
    S_EVEN,
    S_RELAXATION,
    SLIDER,
    SPEED,
    STIFFNESS,
    STOP_CFM,
    STOP_ERP,
    STOP_PUSH,
    TARGET,
    UNILATERAL,
    UPPER,
    VEL,
    W_A,
    W_F,
    W_I,
    W_R,
    W_T,
    W_V,
    WARM,
    WARM2,
    WARM_START,
    WRENCH,
)
from bullet_sim.engine.quickstep.near import is_near
from bullet_sim.engine.quickstep.pids import apply_pids
from bullet_sim.engine.quickstep.state import State
from bullet_sim.engine.quickstep.vectors import (
    copy,
    cross,
    invert,
    matrix,
    multiply,
    plane_space,
    rotate,
    similar,
)
from bullet_sim.pose import Array


@compiled
def _even_out(work: Array, one: int, two: int, axis: Array) -> None:
    """Move the inertias of two hinged bodies along a constrained axis closer to each other."""
    m1 = m2 = 0.0
    for i in range(3):
        for j in range(3):
            m1 += axis[i] * work[one, W_I + 3 * i + j] * axis[j]
            m2 += axis[i] * work[two, W_I + 3 * i + j] * axis[j]
    large, small = one, two
    if m2 > m1:
        large, small, m1, m2 = two, one, m2, m1
    if m1 <= INERTIA_RATIO * m2:
        return
    moved = (m1 - INERTIA_RATIO * m2) / (1.0 + INERTIA_RATIO)
    dominant = True  # the matrices' diagonals, also afterwards
    for i in range(3):
        rest_large = rest_small = 0.0
        for j in range(3):
            if j != i:
                part = moved * axis[i] * axis[j]
                rest_large += abs(work[large, W_I + 3 * i + j] - part)
                rest_small += abs(work[small, W_I + 3 * i + j] + part)
        part = moved * axis[i] * axis[i]
        if (
            work[large, W_I + 4 * i] - part <= rest_large
            or work[small, W_I + 4 * i] + part <= rest_small
        ):
            dominant = False
    if dominant:
        for i in range(3):
            for j in range(3):
                part = moved * axis[i] * axis[j]
                work[large, W_I + 3 * i + j] -= part
                work[small, W_I + 3 * i + j] += part
    for body in (one, two):
        invert(work[body, W_I : W_I + 9], work[body, W_V : W_V + 9])


@compiled
def _impose(step: float, bodies: Array, joints: Array, types: Array, below: Array) -> None:
    """Put and move what is below joints with a commanded position or an imposed velocity."""
    for j in range(len(joints)):
        target = joints[j, TARGET]
        if target == target:  # a number
            reach = joints[j, MAX_SPEED] * step
            reached = joints[j, REACHED]
            joints[j, REACHED] = reached + min(max(target - reached, -reach), reach)
            _set_position(j, joints[j, REACHED], bodies, joints, types, below[j])
        velocity = joints[j, IMPOSED]
        if velocity == velocity:
            _set_velocity(j, velocity, bodies, joints, types)


@compiled
def _set_position(
    j: int, position: float, bodies: Array, joints: Array, types: Array, below: Array
) -> None:
    """Put what is below a joint where a position says."""
    rotation, axis, anchor, arm = temporary(9), temporary(3), temporary(3), temporary(3)
    turn, quaternion = temporary(4), temporary(4)
    change = position - joints[j, ANGLE]
    if change == 0.0:
        return
    joints[j, ANGLE] = position
    first = types[j, 1]
    matrix(bodies[first, QUAT : QUAT + 4], rotation)
    rotate(rotation, joints[j, AXIS1 : AXIS1 + 3], axis)
    rotate(rotation, joints[j, ANCHOR1 : ANCHOR1 + 3], anchor)
    for k in range(3):
        anchor[k] += bodies[first, POS + k]
    if types[j, 0] == HINGE:
        sine = math.sin(0.5 * change)
        turn[0], turn[1], turn[2] = axis[0] * sine, axis[1] * sine, axis[2] * sine
        turn[3] = math.cos(0.5 * change)
        matrix(turn, rotation)
    for b in range(len(bodies)):
        if not below[b]:
            continue
        if types[j, 0] == HINGE:
            for k in range(3):
                arm[k] = bodies[b, POS + k] - anchor[k]
            rotate(rotation, arm, arm)
            for k in range(3):
                bodies[b, POS + k] = anchor[k] + arm[k]
            multiply(turn, bodies[b, QUAT : QUAT + 4], quaternion)
            copy(quaternion, bodies[b, QUAT : QUAT + 4])
        else:
            for k in range(3):
                bodies[b, POS + k] += change * axis[k]


@compiled
def _set_velocity(j: int, velocity: float, bodies: Array, joints: Array, types: Array) -> None:
    """Give the body below a joint the motion of the one above, and a velocity along the joint.

    As Gazebo's Joint::SetVelocity.
    """
    rotation, axis, arm, turn = temporary(9), temporary(3), temporary(3), temporary(3)
    first, second = types[j, 1], types[j, 2]
    child = bodies[first]
    matrix(child[QUAT : QUAT + 4], rotation)
    rotate(rotation, joints[j, AXIS1 : AXIS1 + 3], axis)
    for k in range(3):
        child[VEL + k] = bodies[second, VEL + k] if second >= 0 else 0.0
    if types[j, 0] != HINGE:
        for k in range(3):
            child[VEL + k] += velocity * axis[k]
        return
    for k in range(3):
        spin = bodies[second, VEL + 3 + k] if second >= 0 else 0.0
        child[VEL + 3 + k] = spin + velocity * axis[k]
    rotate(rotation, joints[j, ANCHOR1 : ANCHOR1 + 3], arm)
    cross(arm, child[VEL + 3 : VEL + 6], turn)
    for k in range(3):
        child[VEL + k] += turn[k]
    if second >= 0:
        matrix(bodies[second, QUAT : QUAT + 4], rotation)
        rotate(rotation, joints[j, ANCHOR2 : ANCHOR2 + 3], arm)
        cross(bodies[second, VEL + 3 : VEL + 6], arm, turn)
        for k in range(3):
            child[VEL + k] += turn[k]


@compiled
def _prepare(gravity: Array, bodies: Array, joints: Array, types: Array, work: Array) -> None:
    """Rotations, inertias and forces of all bodies for a step."""
    spin, axis, arm = temporary(3), temporary(3), temporary(3)
    for b in range(len(bodies)):
        matrix(bodies[b, QUAT : QUAT + 4], work[b, W_R : W_R + 9])
        similar(work[b, W_R : W_R + 9], bodies[b, INERTIA : INERTIA + 9], work[b, W_I : W_I + 9])
        similar(work[b, W_R : W_R + 9], bodies[b, INVERSE : INVERSE + 9], work[b, W_V : W_V + 9])
        rotate(work[b, W_I : W_I + 9], bodies[b, VEL + 3 : VEL + 6], spin)
        cross(spin, bodies[b, VEL + 3 : VEL + 6], work[b, W_F + 3 : W_F + 6])  # gyroscopic
        for k in range(3):
            weight = bodies[b, MASS] * gravity[k] * bodies[b, GRAVITY]
            work[b, W_F + k] = weight + bodies[b, FORCE + k]
            work[b, W_F + 3 + k] += bodies[b, FORCE + 3 + k]
    for j in range(len(joints)):
        effort = joints[j, EFFORT]
        if joints[j, IMPLICIT] == 0.0:
            effort -= joints[j, DAMPING] * joints[j, RATE]
            effort += joints[j, STIFFNESS] * (joints[j, AT_REST] - joints[j, ANGLE])
        if effort == 0.0:
            continue
        first, second = types[j, 1], types[j, 2]
        rotate(work[first, W_R : W_R + 9], joints[j, AXIS1 : AXIS1 + 3], axis)
        shift = 3 if types[j, 0] == HINGE else 0
        for k in range(3):
            work[first, W_F + shift + k] += effort * axis[k]
            if second >= 0:
                work[second, W_F + shift + k] -= effort * axis[k]
        if shift == 0 and second >= 0:  # both forces on one line
            for k in range(3):
                arm[k] = 0.5 * (bodies[second, POS + k] - bodies[first, POS + k])
            cross(arm, axis, spin)
            for k in range(3):
                work[first, W_F + 3 + k] += effort * spin[k]
                work[second, W_F + 3 + k] += effort * spin[k]


@compiled
def _fall_asleep(step: float, n: int, bodies: Array, owners: Array, touched: Array) -> bool:
    """Let bodies sleep that have been at rest on something; whether one has fallen asleep.

    Args:
        n: number of contacts.
        touched: (n,) numbers to work with.
    """
    touched[: len(bodies)] = 0
    for i in range(n):
        touched[owners[i, 0]] = 1
        if owners[i, 1] >= 0:
            touched[owners[i, 1]] = 1
    found = False
    for b in range(len(bodies)):
        body = bodies[b]
        if not touched[b] or body[MAY_SLEEP] == 0.0 or body[ASLEEP] != 0.0:
            continue
        linear = angular = 0.0
        for k in range(3):
            linear += body[VEL + k] * body[VEL + k]
            angular += body[VEL + 3 + k] * body[VEL + 3 + k]
        if max(linear, angular) > REST_SPEED * REST_SPEED:
            body[REST], body[REST_STEPS] = REST_TIME, REST_COUNT
            continue
        body[REST] -= step
        body[REST_STEPS] -= 1.0
        if body[REST] <= 0.0 and body[REST_STEPS] <= 0.0:
            body[ASLEEP] = 1.0
            body[VEL : VEL + 6] = 0.0
            found = True
    return found


@compiled
def _contact_rows(
    step: float,
    m: int,
    n: int,
    contacts: Array,
    owners: Array,
    bodies: Array,
    rows: Array,
    links: Array,
    first_row: Array,
) -> int:
    """Rows of contact n, from row m; the number of rows then."""
    contact = contacts[n]
    one, two = owners[n, 0], owners[n, 1]
    arm, arm2, t, q = temporary(3), temporary(3), temporary(3), temporary(3)
    for k in range(3):
        arm[k] = contact[C_POINT + k] - bodies[one, POS + k]
        if two >= 0:
            arm2[k] = contact[C_POINT + k] - bodies[two, POS + k]
    normal_row = m
    first_row[n] = m
    for direction in range(3):
        if direction == 0:
            for k in range(3):
                t[k] = contact[C_NORMAL + k]
        else:
            if contact[C_MU + direction - 1] <= 0.0:
                continue
            normal = contact[C_NORMAL : C_NORMAL + 3]
            fdir = contact[C_FDIR : C_FDIR + 3]
            cross(normal, fdir, q)
            if q[0] == 0.0 and q[1] == 0.0 and q[2] == 0.0:
                plane_space(normal, t, q)
            else:
                for k in range(3):
                    t[k] = fdir[k]
            if direction == 2:
                for k in range(3):
                    t[k] = q[k]
        row = rows[m]
        for k in range(12):
            row[R_J + k] = 0.0
        for k in range(3):
            row[R_J + k] = t[k]
        cross(arm, t, row[R_J + 3 : R_J + 6])
        if two >= 0:
            cross(arm2, t, row[R_J + 9 : R_J + 12])
            for k in range(3):
                row[R_J + 6 + k] = -t[k]
                row[R_J + 9 + k] = -row[R_J + 9 + k]
        links[m, 0], links[m, 1], links[m, 3] = one, two, -1
        if direction == 0:
            row[R_C] = contact[C_ERP] / step * max(0.0, contact[C_DEPTH])
            row[R_MAX], row[R_CFM] = contact[C_MAX], contact[C_CFM]
            row[R_LOW], row[R_HIGH], links[m, 2] = 0.0, INFINITE, UNILATERAL
        else:
            mu = contact[C_MU + direction - 1]
            row[R_C], row[R_MAX] = 0.0, INFINITE
            row[R_CFM] = contact[C_SLIP + direction - 1]
            row[R_LOW], row[R_HIGH], links[m, 2] = -mu, mu, normal_row
        m += 1
    return m


@compiled
def _joint_rows(
    step: float,
    m: int,
    j: int,
    bodies: Array,
    joints: Array,
    types: Array,
    rows: Array,
    links: Array,
    work: Array,
    settings: Array,
) -> int:
    """Rows of joint j, from row m; the number of rows then."""
    joint = joints[j]
    kind, one, two = types[j, 0], types[j, 1], types[j, 2]
    a1, a2, ax1, ax2 = temporary(3), temporary(3), temporary(3), temporary(3)
    p, q, u = temporary(3), temporary(3), temporary(3)
    r1, at1 = work[one, W_R : W_R + 9], bodies[one, POS : POS + 3]
    rotate(r1, joint[ANCHOR1 : ANCHOR1 + 3], a1)
    rotate(r1, joint[AXIS1 : AXIS1 + 3], ax1)
    if two >= 0:
        rotate(work[two, W_R : W_R + 9], joint[ANCHOR2 : ANCHOR2 + 3], a2)
        rotate(work[two, W_R : W_R + 9], joint[AXIS2 : AXIS2 + 3], ax2)
    else:
        for k in range(3):
            a2[k], ax2[k] = joint[ANCHOR2 + k], joint[AXIS2 + k]
    gain, first = settings[S_ERP] / step, m
    count = 3 if kind == SLIDER else 5 if kind == HINGE else 6
    for i in range(count + (2 if kind == SLIDER else 0)):
        for k in range(12):
            rows[m + i, R_J + k] = 0.0
    if kind != SLIDER:  # the anchors meet
        for i in range(3):
            row = rows[m]
            row[R_J + i] = 1.0
            u[0] = u[1] = u[2] = 0.0
            u[i] = 1.0
            cross(a1, u, row[R_J + 3 : R_J + 6])
            error = a2[i] - at1[i] - a1[i]
            if two >= 0:
                row[R_J + 6 + i] = -1.0
                cross(a2, u, row[R_J + 9 : R_J + 12])
                for k in range(3):
                    row[R_J + 9 + k] = -row[R_J + 9 + k]
                error = bodies[two, POS + i] + a2[i] - at1[i] - a1[i]
            row[R_C] = gain * error
            m += 1
    if kind == HINGE:  # the axes meet
        plane_space(ax1, p, q)
        cross(ax1, ax2, u)
        for i in range(2):
            t = p if i == 0 else q
            row = rows[m]
            for k in range(3):
                row[R_J + 3 + k] = t[k]
                if two >= 0:
                    row[R_J + 9 + k] = -t[k]
            row[R_C] = gain * (u[0] * t[0] + u[1] * t[1] + u[2] * t[2])
            m += 1
            if two >= 0 and settings[S_EVEN] != 0.0:
                _even_out(work, one, two, t)
    else:  # nothing rotates
        error4, inverse = temporary(4), temporary(4)
        if two >= 0:
            multiply(bodies[two, QUAT : QUAT + 4], joint[QREL : QREL + 4], error4)
        else:
            copy(joint[QREL : QREL + 4], error4)
        for k in range(3):
            inverse[k] = -bodies[one, QUAT + k]
        inverse[3] = bodies[one, QUAT + 3]
        multiply(error4, inverse, error4)
        sign = -2.0 if error4[3] < 0.0 else 2.0
        for i in range(3):
            row = rows[m]
            row[R_J + 3 + i] = 1.0
            if two >= 0:
                row[R_J + 9 + i] = -1.0
            row[R_C] = gain * sign * error4[i]
            m += 1
    if kind == SLIDER:  # the anchors meet, but along the axis
        plane_space(ax1, p, q)
        for k in range(3):
            ax2[k] = (bodies[two, POS + k] if two >= 0 else 0.0) - at1[k]
        for i in range(2):
            t = p if i == 0 else q
            row = rows[m]
            cross(ax2, t, u)
            error = 0.0
            for k in range(3):
                row[R_J + k] = t[k]
                if two >= 0:
                    row[R_J + 3 + k] = 0.5 * u[k]
                    row[R_J + 6 + k] = -t[k]
                    row[R_J + 9 + k] = 0.5 * u[k]
                error += t[k] * (ax2[k] + a2[k])
            row[R_C] = gain * error
            m += 1
    for i in range(first, m):
        rows[i, R_MAX], rows[i, R_CFM] = INFINITE, settings[S_CFM]
        rows[i, R_LOW], rows[i, R_HIGH], links[i, 2] = -INFINITE, INFINITE, BILATERAL
    if kind != FIXED:
        m = _limit_row(step, m, joint, kind, one, two, ax1, bodies, rows, links, work, settings)
    for i in range(first, m):
        links[i, 0], links[i, 1], links[i, 3], links[i, 4] = one, two, j, i - first
    return m


@compiled
def _limit_row(
    step: float,
    m: int,
    joint: Array,
    kind: int,
    one: int,
    two: int,
    axis: Array,
    bodies: Array,
    rows: Array,
    links: Array,
    work: Array,
    settings: Array,
) -> int:
    """The row of a joint's motor, limit or damping, if it needs one; the number of rows then."""
    position, limit = joint[ANGLE], 0
    if joint[LOWER] <= joint[UPPER]:
        limit = 1 if position <= joint[LOWER] else 2 if position >= joint[UPPER] else 0
    softness = step * joint[STIFFNESS] + joint[DAMPING]
    damped = joint[IMPLICIT] != 0.0 and softness > 0.0 and limit == 0
    powered = joint[FMAX] > 0.0 and not (damped or limit and joint[LOWER] == joint[UPPER])
    if not (powered or limit or damped):
        return m
    row, shift = rows[m], 3 if kind == HINGE else 0
    for k in range(12):
        row[R_J + k] = 0.0
    for k in range(3):
        row[R_J + shift + k] = axis[k]
        if two >= 0:
            row[R_J + 6 + shift + k] = -axis[k]
    if shift == 0 and two >= 0:  # both forces on one line
        arm = temporary(3)
        for k in range(3):
            arm[k] = 0.5 * (bodies[two, POS + k] - bodies[one, POS + k])
        cross(arm, axis, row[R_J + 3 : R_J + 6])
        for k in range(3):
            row[R_J + 9 + k] = row[R_J + 3 + k]
    row[R_MAX], row[R_CFM] = INFINITE, settings[S_CFM]
    if damped:  # a limit at both sides that yields as a spring and a damper do
        row[R_C] = -joint[STIFFNESS] / softness * (position - joint[AT_REST])
        row[R_CFM] = 1.0 / softness
        row[R_LOW], row[R_HIGH], links[m, 2] = -INFINITE, INFINITE, BILATERAL
    elif limit:
        if powered:  # the motor pushes with its whole effort
            push = joint[FMAX]
            if joint[SPEED] > 0.0 or (joint[SPEED] == 0.0 and limit == 2):
                push = -push
            if limit == 1 and joint[SPEED] > 0.0 or limit == 2 and joint[SPEED] < 0.0:
                push *= joint[STOP_PUSH]  # away from the limit
            for k in range(3):
                work[one, W_F + shift + k] -= push * axis[k]
                if two >= 0:
                    work[two, W_F + shift + k] += push * axis[k]
        stop = joint[LOWER] if limit == 1 else joint[UPPER]
        row[R_C], links[m, 2] = -joint[STOP_ERP] / step * (position - stop), BILATERAL
        row[R_CFM] = joint[STOP_CFM]
        row[R_LOW] = 0.0 if limit == 1 and joint[LOWER] < joint[UPPER] else -INFINITE
        row[R_HIGH] = 0.0 if limit == 2 and joint[LOWER] < joint[UPPER] else INFINITE
    else:
        row[R_C] = joint[SPEED]
        row[R_LOW], row[R_HIGH], links[m, 2] = -joint[FMAX], joint[FMAX], BILATERAL
    return m + 1


@compiled
def _build(
    step: float,
    n: int,
    bodies: Array,
    joints: Array,
    types: Array,
    starts: Array,
    lists: Array,
    contacts: Array,
    owners: Array,
    rows: Array,
    links: Array,
    first_row: Array,
    work: Array,
    marks: Array,
    sequence: Array,
    settings: Array,
) -> int:
    """Rows of all constraints, in the order in which ODE finds them; their number.

    From the body that was added last to the first: its contacts, the last first, its joints, the
    last first, and depth first what they connect it with.

    Contacts of bodies that sleep have none.

    Args:
        sequence: gets the bodies in that order.
    """
    count, m, top, placed = len(bodies), 0, 0, 0
    body_seen, joint_seen, stack = marks[0], marks[1], marks[2]
    contact_seen = marks[3]
    for b in range(count):
        body_seen[b] = 0
    for j in range(len(joints)):
        joint_seen[j] = 0
    for i in range(n):
        contact_seen[i], first_row[i] = 0, -1
    for root in range(count - 1, -1, -1):
        if body_seen[root] or bodies[root, ASLEEP] != 0.0:
            continue
        body_seen[root] = 1
        b = root
        while True:
            sequence[placed] = b
            bodies[b, PLACE] = placed
            bodies[b, ASLEEP] = 0.0  # what touches somebody awake
            placed += 1
            for i in range(n - 1, -1, -1):
                if contact_seen[i] or (owners[i, 0] != b and owners[i, 1] != b):
                    continue
                contact_seen[i] = 1
                m = _contact_rows(step, m, i, contacts, owners, bodies, rows, links, first_row)
                other = owners[i, 1] if owners[i, 0] == b else owners[i, 0]
                if other >= 0 and not body_seen[other]:
                    body_seen[other] = 1
                    stack[top] = other
                    top += 1
            for place in range(starts[b], starts[b + 1]):
                j = lists[place]
                if joint_seen[j]:
                    continue
                joint_seen[j] = 1
                m = _joint_rows(step, m, j, bodies, joints, types, rows, links, work, settings)
                other = types[j, 2] if types[j, 1] == b else types[j, 1]
                if other >= 0 and not body_seen[other]:
                    body_seen[other] = 1
                    stack[top] = other
                    top += 1
            if top == 0:
                break
            top -= 1
            b = stack[top]
    for b in range(count):
        if not body_seen[b]:
            sequence[placed] = b
            bodies[b, PLACE] = placed
            placed += 1
    return m


@compiled
def _relax(
    step: float,
    m: int,
    bodies: Array,
    joints: Array,
    rows: Array,
    links: Array,
    work: Array,
    settings: Array,
) -> None:
    """Right sides, scaled rows and the impulses to begin with."""
    v = temporary(3)
    for b in range(len(bodies)):
        rotate(work[b, W_V : W_V + 9], work[b, W_F + 3 : W_F + 6], v)
        for k in range(3):
            work[b, W_T + k] = work[b, W_F + k] / bodies[b, MASS] + bodies[b, VEL + k] / step
            work[b, W_T + 3 + k] = v[k] + bodies[b, VEL + 3 + k] / step
        work[b, W_A : W_A + 12] = 0.0
    for i in range(m):
        row, one, two = rows[i], links[i, 0], links[i, 1]
        total = diagonal = 0.0
        for k in range(6):
            total += row[R_J + k] * work[one, W_T + k]
        for k in range(3):
            row[R_M + k] = row[R_J + k] / bodies[one, MASS]
        rotate(work[one, W_V : W_V + 9], row[R_J + 3 : R_J + 6], row[R_M + 3 : R_M + 6])
        for k in range(6):
            diagonal += row[R_M + k] * row[R_J + k]
        if two >= 0:
            for k in range(6):
                total += row[R_J + 6 + k] * work[two, W_T + k]
            for k in range(3):
                row[R_M + 6 + k] = row[R_J + 6 + k] / bodies[two, MASS]
            rotate(work[two, W_V : W_V + 9], row[R_J + 9 : R_J + 12], row[R_M + 9 : R_M + 12])
            for k in range(6, 12):
                diagonal += row[R_M + k] * row[R_J + k]
        softness = row[R_CFM] / step
        scale = settings[S_RELAXATION] / (diagonal + softness)
        if links[i, 2] >= 0:
            scale *= FRICTION_SCALE
        wanted = row[R_C]
        row[R_RHS2] = (wanted / step - total) * scale
        row[R_RHS] = (min(wanted, row[R_MAX]) / step - total) * scale
        row[R_CFM] = scale * softness
        for k in range(12):
            row[R_J + k] *= scale
        row[R_L] = row[R_L2] = 0.0
        j = links[i, 3]
        if j >= 0:
            row[R_L] = WARM_START * joints[j, WARM + links[i, 4]]
            row[R_L2] = WARM_START * joints[j, WARM2 + links[i, 4]]
            for k in range(6):
                work[one, W_A + 2 * k] += row[R_L] * row[R_M + k]
                work[one, W_A + 2 * k + 1] += row[R_L2] * row[R_M + k]
            if two >= 0:
                for k in range(6):
                    work[two, W_A + 2 * k] += row[R_L] * row[R_M + 6 + k]
                    work[two, W_A + 2 * k + 1] += row[R_L2] * row[R_M + 6 + k]


@compiled
def _decay(velocity: Array, fraction: float) -> None:
    """Reduce a velocity (3,), unless it is small."""
    if fraction == 0.0:
        return
    square = velocity[0] * velocity[0] + velocity[1] * velocity[1] + velocity[2] * velocity[2]
    if square > DECAY_SPEED * DECAY_SPEED:
        for k in range(3):
            velocity[k] *= 1.0 - fraction


@compiled
def _move(
    step: float,
    m: int,
    n: int,
    bodies: Array,
    joints: Array,
    types: Array,
    contacts: Array,
    first_row: Array,
    rows: Array,
    links: Array,
    work: Array,
) -> None:
    """Velocities, positions, and what is measured, of the solutions."""
    v, turn, quaternion = temporary(3), temporary(4), temporary(4)
    for j in range(len(joints)):
        joints[j, MOTOR] = 0.0
        for k in range(6):
            joints[j, WRENCH + k] = 0.0
    for i in range(m):
        j = links[i, 3]
        if j < 0:
            continue
        at, row = links[i, 4], rows[i]
        joints[j, WARM + at], joints[j, WARM2 + at] = row[R_L], row[R_L2]
        one = links[i, 0]
        if at == 5 and types[j, 0] != FIXED:
            joints[j, MOTOR] = row[R_L]
        else:
            for k in range(3):
                joints[j, WRENCH + k] += row[R_L] * row[R_M + k] * bodies[one, MASS]
            rotate(work[one, W_I : W_I + 9], row[R_M + 3 : R_M + 6], v)
            for k in range(3):
                joints[j, WRENCH + 3 + k] += row[R_L] * v[k]
    for i in range(n):
        first = first_row[i]
        if first < 0:  # it sleeps with its last force
            continue
        mass = bodies[links[first, 0], MASS]
        for k in range(3):
            contacts[i, C_FORCE + k] = rows[first, R_L] * rows[first, R_M + k] * mass
        for more in (1, 2):
            at = first + more
            if at < m and links[at, 2] == first:
                for k in range(3):
                    contacts[i, C_FORCE + k] += rows[at, R_L] * rows[at, R_M + k] * mass
    for b in range(len(bodies)):
        body = bodies[b]
        if body[ASLEEP] != 0.0:
            continue
        rotate(work[b, W_V : W_V + 9], work[b, W_F + 3 : W_F + 6], v)
        for k in range(3):
            body[VEL + k] += step * (work[b, W_A + 2 * k + 1] + work[b, W_F + k] / body[MASS])
            body[VEL + 3 + k] += step * (work[b, W_A + 2 * k + 7] + v[k])
            body[FORCE + k] = body[FORCE + 3 + k] = 0.0
        for k in range(3):
            body[POS + k] += step * body[VEL + k]
        for k in range(3):
            turn[k] = 0.5 * step * body[VEL + 3 + k]
        turn[3] = 1.0
        multiply(turn, body[QUAT : QUAT + 4], quaternion)
        length = math.sqrt(
            quaternion[0] ** 2 + quaternion[1] ** 2 + quaternion[2] ** 2 + quaternion[3] ** 2
        )
        for k in range(4):
            body[QUAT + k] = quaternion[k] / length
        _decay(body[VEL : VEL + 3], body[DECAY])
        _decay(body[VEL + 3 : VEL + 6], body[DECAY + 1])
        for k in range(6):  # what has pushed out of contacts is no velocity
            body[VEL + k] += step * (work[b, W_A + 2 * k] - work[b, W_A + 2 * k + 1])
    for j in range(len(joints)):
        joints[j, EFFORT] = 0.0
    measure_joints(bodies, joints, types)


@compiled
def measure_joints(bodies: Array, joints: Array, types: Array) -> None:
    """Positions and velocities of the joints; positions of hinges count whole rotations."""
    error, inverse, rotation = temporary(4), temporary(4), temporary(9)
    axis, a2 = temporary(3), temporary(3)
    for j in range(len(joints)):
        kind, one, two = types[j, 0], types[j, 1], types[j, 2]
        joint = joints[j]
        matrix(bodies[one, QUAT : QUAT + 4], rotation)
        rotate(rotation, joint[AXIS1 : AXIS1 + 3], axis)
        shift = 3 if kind == HINGE else 0
        rate = 0.0
        for k in range(3):
            relative = bodies[one, VEL + shift + k]
            if two >= 0:
                relative -= bodies[two, VEL + shift + k]
            rate += axis[k] * relative
        if kind == HINGE:
            if two >= 0:
                multiply(bodies[two, QUAT : QUAT + 4], joint[QREL : QREL + 4], error)
            else:
                copy(joint[QREL : QREL + 4], error)
            for k in range(3):
                inverse[k] = -error[k]
            inverse[3] = error[3]
            multiply(inverse, bodies[one, QUAT : QUAT + 4], error)
            sine = (
                error[0] * joint[AXIS1] + error[1] * joint[AXIS1 + 1] + error[2] * joint[AXIS1 + 2]
            )
            tilted = math.sqrt(error[0] ** 2 + error[1] ** 2 + error[2] ** 2)
            change = 2.0 * math.atan2(math.copysign(tilted, sine), error[3]) - joint[ANGLE]
            change -= 2.0 * math.pi * math.floor(change / (2.0 * math.pi) + 0.5)
            joint[ANGLE] += change
        elif kind == SLIDER:
            position = 0.0
            for k in range(3):
                a2[k] = joint[ANCHOR2 + k]
            if two >= 0:
                matrix(bodies[two, QUAT : QUAT + 4], rotation)
                rotate(rotation, joint[ANCHOR2 : ANCHOR2 + 3], a2)
                for k in range(3):
                    a2[k] += bodies[two, POS + k]
            for k in range(3):
                position += axis[k] * (bodies[one, POS + k] - a2[k])
            joint[ANGLE] = position
        joint[RATE] = rate


_state_at = arrays_at(numba_type(State))


@compiled
def advance(
    count: int, given: int, step: float, iterations: int, watch: bool, sleepy: bool, table: Array
) -> int:
    """Make up to `count` steps.

    Args:
        given: number of contacts, in the first rows, that the caller has found for the next step;
            -1: none were looked for, and it stops before a step for which they are needed.
        watch: whether there is something of which the caller finds the contacts.
        sleepy: whether there are bodies that may sleep.
        table: state.make_table() of the State that is moved.

    Returns:
        Number of steps made; it also stops after a step in which a body has fallen asleep.
    """
    (settings, gravity, bodies, sequence, joints, types, starts, lists, below, scene, contacts,
     owners, rows, links, first_row, blocks, work, marks, result, pids, active,
        noted) = _state_at(table)  # fmt: skip
    for done in range(count):
        if watch and is_near(bodies, scene) and given < 0:
            return done
        apply_pids(step, pids, active, noted, joints)
        _impose(step, bodies, joints, types, below)
        _prepare(gravity, bodies, joints, types, work)
        place_solids(bodies, scene, work)
        n = find_contacts(step, bodies, sequence, scene, contacts, owners, max(given, 0), work)
        fell = sleepy and _fall_asleep(step, n, bodies, owners, marks[0])
        m = _build(step, n, bodies, joints, types, starts, lists, contacts, owners, rows, links,
                   first_row, work, marks, sequence, settings)  # fmt: skip
        _relax(step, m, bodies, joints, rows, links, work, settings)
        pack(m, rows, links, blocks)
        iterate(iterations, blocks)
        unpack(m, rows, links, blocks)
        _move(step, m, n, bodies, joints, types, contacts, first_row, rows, links, work)
        result[0] = n
        given = -1
        if fell:
            return done + 1
    return count
