"""Rigid bodies in maximal coordinates, stepped as Gazebo Classic steps them: ODE's quick solver.

People tuned their robots in Gazebo, whose solver stops after 50 iterations of a slow kind; how a
car turns there is what that solver has come to until then. So its steps are made here: the same
rows of constraints in the same order, the same projected Gauss-Seidel iteration (relaxation 1.3,
for friction a quarter of it, 10 more iterations of friction alone, half of the joints' last
impulses to begin with), friction bounded along two directions, contacts at both rims of a cylinder,
two solutions: one that moves the bodies, and one whose push out of contacts is bounded, which they
keep as velocity.

Sources: Open Dynamics Engine, "User Guide"; Gazebo's parameters as of version 11 (dWorldCreate,
ODEPhysics, ODELink, ODEJoint).

All quantities are numbers in arrays with one row per body, joint, shape, plane, contact or
constraint; the constants of layout.py are their columns. Units: m, kg, s, rad; world axes if
nothing else is said. numba compiles the functions. No operation is reordered, so that results are
the same on all processors.
"""

import math

from bullet_sim.engine.quickstep import joints
from bullet_sim.engine.quickstep import layout as col
from bullet_sim.engine.quickstep.broadphase import is_near
from bullet_sim.engine.quickstep.collision import find_contacts, place_solids
from bullet_sim.engine.quickstep.compiled import (
    arrays_at,
    compiled,
    inlined,
    numba_type,
    temporary,
    threaded,
)
from bullet_sim.engine.quickstep.constraints import add_rows
from bullet_sim.engine.quickstep.islands import end_islands, help_solve, solve_islands
from bullet_sim.engine.quickstep.pids import apply_efforts, hold_velocities
from bullet_sim.engine.quickstep.state import Constraints, Contacts, State, System
from bullet_sim.engine.quickstep.touching import record_contacts
from bullet_sim.engine.quickstep.vectors import cross, matrix, multiply, rotate, similar
from bullet_sim.pose import UNTURNED, Array


@inlined
def _prepare(gravity: Array, system: System) -> None:
    """Rotations, inertias and forces of all bodies for a step."""
    bodies, work = system.bodies, system.work
    for b in range(len(bodies)):
        body, values = bodies[b], work[b]
        turn, spin = values[col.W_R : col.W_R + 9], body[col.VEL + 3 : col.VEL + 6]
        inertia, force = values[col.W_I : col.W_I + 9], values[col.W_F : col.W_F + 6]
        momentum = temporary(3)
        matrix(body[col.QUAT : col.QUAT + 4], turn)
        similar(turn, body[col.INERTIA : col.INERTIA + 9], inertia)
        similar(turn, body[col.INVERSE : col.INVERSE + 9], values[col.W_V : col.W_V + 9])
        rotate(inertia, spin, momentum)
        cross(momentum, spin, force[3:])  # gyroscopic
        for k in range(3):
            weight = body[col.MASS] * gravity[k] * body[col.GRAVITY]
            force[k] = weight + body[col.FORCE + k]
            force[3 + k] += body[col.FORCE + 3 + k]
    for j in range(len(system.joints)):
        _add_effort(j, system)


@inlined
def _add_effort(j: int, system: System) -> None:
    """Have a joint's effort, its spring and its damper act on both bodies."""
    joint, bodies, work = system.joints[j], system.bodies, system.work
    axis, arm, torque = temporary(3), temporary(3), temporary(3)
    effort = joint[col.EFFORT]
    if joint[col.IMPLICIT] == 0.0:
        effort -= joint[col.DAMPING] * joint[col.RATE]
        effort += joint[col.STIFFNESS] * (joint[col.AT_REST] - joint[col.ANGLE])
    if effort == 0.0:
        return
    first, second = system.types[j, 1], system.types[j, 2]
    rotate(work[first, col.W_R : col.W_R + 9], joint[col.AXIS1 : col.AXIS1 + 3], axis)
    shift = 0 if system.types[j, 0] == col.SLIDER else 3
    for k in range(3):
        work[first, col.W_F + shift + k] += effort * axis[k]
        if second >= 0:
            work[second, col.W_F + shift + k] -= effort * axis[k]
    if shift == 0 and second >= 0:  # both forces on one line
        for k in range(3):
            arm[k] = 0.5 * (bodies[second, col.POS + k] - bodies[first, col.POS + k])
        cross(arm, axis, torque)
        for k in range(3):
            work[first, col.W_F + 3 + k] += effort * torque[k]
            work[second, col.W_F + 3 + k] += effort * torque[k]


@compiled
def _fall_asleep(step: float, n: int, bodies: Array, owners: Array, touched: Array) -> bool:
    """Let bodies sleep that have been at rest on something; whether one has fallen asleep.

    Those have FALLING until _stays_asleep(): what touches somebody awake is woken in the same step.

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
        if not touched[b] or body[col.MAY_SLEEP] == 0.0 or body[col.ASLEEP] != 0.0:
            continue
        linear = angular = 0.0
        for k in range(3):
            linear += body[col.VEL + k] * body[col.VEL + k]
            angular += body[col.VEL + 3 + k] * body[col.VEL + 3 + k]
        if max(linear, angular) > col.REST_SPEED * col.REST_SPEED:
            body[col.REST], body[col.REST_STEPS] = col.REST_TIME, col.REST_COUNT
            continue
        body[col.REST] -= step
        body[col.REST_STEPS] -= 1.0
        if body[col.REST] <= 0.0 and body[col.REST_STEPS] <= 0.0:
            body[col.ASLEEP] = col.FALLING
            body[col.VEL : col.VEL + 6] = 0.0
            found = True
    return found


@compiled
def _stays_asleep(bodies: Array) -> bool:
    """Whether one of those that have fallen asleep in this step has not been woken."""
    found = False
    for b in range(len(bodies)):
        if bodies[b, col.ASLEEP] == col.FALLING:
            bodies[b, col.ASLEEP], found = 1.0, True
    return found


@compiled
def _decay(velocity: Array, fraction: float) -> None:
    """Reduce a velocity (3,), unless it is small."""
    if fraction == 0.0:
        return
    square = velocity[0] * velocity[0] + velocity[1] * velocity[1] + velocity[2] * velocity[2]
    if square > col.DECAY_SPEED * col.DECAY_SPEED:
        for k in range(3):
            velocity[k] *= 1.0 - fraction


@inlined
def _keep_impulses(m: int, system: System, constraints: Constraints) -> None:
    """Of the joints' rows: impulses to begin the next step with, motors' efforts, loads."""
    bodies, joints, work = system.bodies, system.joints, system.work
    v, links = temporary(3), constraints.links
    for j in range(len(joints)):
        joints[j, col.MOTOR] = 0.0
        for k in range(6):
            joints[j, col.WRENCH + k] = 0.0
    for i in range(m):
        j = links[i, 3]
        if j < 0:
            continue
        at, row = links[i, 4], constraints.rows[i]
        joints[j, col.WARM + at], joints[j, col.WARM2 + at] = row[col.R_L], row[col.R_L2]
        one = links[i, 0]
        if at == 5 and system.types[j, 0] != col.FIXED:
            joints[j, col.MOTOR] = row[col.R_L]
        else:
            for k in range(3):
                joints[j, col.WRENCH + k] += row[col.R_L] * row[col.R_M + k] * bodies[one, col.MASS]
            rotate(work[one, col.W_I : col.W_I + 9], row[col.R_M + 3 : col.R_M + 6], v)
            for k in range(3):
                joints[j, col.WRENCH + 3 + k] += row[col.R_L] * v[k]


@inlined
def _measure_contacts(
    m: int, n: int, bodies: Array, contacts: Contacts, constraints: Constraints
) -> None:
    """Forces of the contacts."""
    rows, links = constraints.rows, constraints.links
    for i in range(n):
        first = contacts.first_row[i]
        if first < 0:  # it sleeps with its last force
            continue
        mass, row = bodies[links[first, 0], col.MASS], rows[first]
        force = contacts.rows[i, col.C_FORCE : col.C_FORCE + 3]
        for k in range(3):
            force[k] = row[col.R_L] * row[col.R_M + k] * mass
        for more in (1, 2):
            at = first + more
            if at < m and links[at, 2] == first:
                row = rows[at]
                for k in range(3):
                    force[k] += row[col.R_L] * row[col.R_M + k] * mass


@inlined
def _move(step: float, system: System) -> None:
    """Velocities and positions of the solutions."""
    v, turn, quaternion = temporary(3), temporary(4), temporary(4)
    bodies, work = system.bodies, system.work
    for b in range(len(bodies)):
        body = bodies[b]
        if body[col.ASLEEP] != 0.0:
            continue
        rotate(work[b, col.W_V : col.W_V + 9], work[b, col.W_F + 3 : col.W_F + 6], v)
        for k in range(3):
            acceleration = work[b, col.W_A + 2 * k + 1] + work[b, col.W_F + k] / body[col.MASS]
            body[col.VEL + k] += step * acceleration
            body[col.VEL + 3 + k] += step * (work[b, col.W_A + 2 * k + 7] + v[k])
            body[col.FORCE + k] = body[col.FORCE + 3 + k] = 0.0
        for k in range(3):
            body[col.POS + k] += step * body[col.VEL + k]
        for k in range(3):
            turn[k] = 0.5 * step * body[col.VEL + 3 + k]
        turn[3] = 1.0
        multiply(turn, body[col.QUAT : col.QUAT + 4], quaternion)
        length = math.sqrt(
            quaternion[0] ** 2 + quaternion[1] ** 2 + quaternion[2] ** 2 + quaternion[3] ** 2
        )
        for k in range(4):
            body[col.QUAT + k] = quaternion[k] / length
        _decay(body[col.VEL : col.VEL + 3], body[col.DECAY])
        _decay(body[col.VEL + 3 : col.VEL + 6], body[col.DECAY + 1])
        for k in range(6):  # what has pushed out of contacts is no velocity
            body[col.VEL + k] += step * (work[b, col.W_A + 2 * k] - work[b, col.W_A + 2 * k + 1])
    for j in range(len(system.joints)):
        system.joints[j, col.EFFORT] = 0.0


@compiled
def _place_frame(row: Array, a: float, b: float, c: float) -> None:
    """Where a link's frame is, and its velocity: as pose.compose and pose.velocity_at, to the bit.

    Args:
        row: of a body in a record.
        a, b, c: the frame from the center of mass [m].
    """
    x, y, z, w = row[col.QUAT], row[col.QUAT + 1], row[col.QUAT + 2], row[col.QUAT + 3]
    i, j, k = 2.0 * (y * c - z * b), 2.0 * (z * a - x * c), 2.0 * (x * b - y * a)
    row[col.SR_POS] = row[col.POS] + a + w * i + y * k - z * j
    row[col.SR_POS + 1] = row[col.POS + 1] + b + w * j + z * i - x * k
    row[col.SR_POS + 2] = row[col.POS + 2] + c + w * k + x * j - y * i
    multiply(row[col.QUAT : col.VEL], UNTURNED, row[col.SR_QUAT : col.SR_VEL])
    p, q, r = row[col.VEL + 3], row[col.VEL + 4], row[col.VEL + 5]
    x, y, z = (
        row[col.SR_POS] - row[col.POS],
        row[col.SR_POS + 1] - row[col.POS + 1],
        row[col.SR_POS + 2] - row[col.POS + 2],
    )
    row[col.SR_VEL] = row[col.VEL] + q * z - r * y
    row[col.SR_VEL + 1] = row[col.VEL + 1] + r * x - p * z
    row[col.SR_VEL + 2] = row[col.VEL + 2] + p * y - q * x


@compiled
def _record(system: System, inward: Array, efforts: Array, count: int, record: Array) -> None:
    """Record the state after a step, with a number of efforts: see State.states."""
    at = 0
    for b in range(len(system.bodies)):
        row = record[at : at + col.SR_BODY]
        for k in range(col.PLACE):
            row[k] = system.bodies[b, k]
        _place_frame(row, inward[b, 0], inward[b, 1], inward[b, 2])
        at += col.SR_BODY
    for j in range(len(system.joints)):
        joint = system.joints[j]
        record[at], record[at + 1] = joint[col.ANGLE], joint[col.RATE]
        for k in range(col.SR_JOINT - 2):
            record[at + 2 + k] = joint[col.MOTOR + k]
        at += col.SR_JOINT
    for j in range(len(system.joints)):
        record[at + j] = math.nan
    for k in range(count):
        record[at + int(efforts[k, col.PID_JOINT])] = efforts[k, col.PID_APPLIED]


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
        Number of steps made; it also stops after a step in which a body has fallen asleep. With a
        count of 0 joints are measured where bodies are.
    """
    (settings, gravity, sequence, system, scene, contacts, constraints, blocks, islands, marks,
     result, efforts, active, recorded, states, taken, inward, held, holding,
     contact_records) = _state_at(table)  # fmt: skip
    islands.step[0], islands.counts[1] = step, iterations
    made = count
    if count == 0:  # bodies were put elsewhere
        joints.measure(system)
    for done in range(count):
        if watch and is_near(system.bodies, scene) and given < 0:
            made = done
            break
        if holding[0] > 0 and (done > 0 or holding[1] != 0):
            hold_velocities(held, holding[0], system)
            if 0 < taken[1] <= taken[0]:  # what is told of the step before is told after that
                _record(system, inward, efforts, active[0], states[taken[1] - 1])
        apply_efforts(step, efforts, active, recorded, system.joints)
        joints.impose(step, system)
        _prepare(gravity, system)
        place_solids(system, scene)
        n = find_contacts(step, system, sequence, scene, contacts, max(given, 0))
        fell = sleepy and _fall_asleep(step, n, system.bodies, contacts.owners, marks[0])
        m = add_rows(n, system, contacts, constraints, islands, marks, sequence, settings)
        fell = fell and _stays_asleep(system.bodies)
        solve_islands(system, sequence, constraints, blocks, islands, settings)
        _keep_impulses(m, system, constraints)
        _measure_contacts(m, n, system.bodies, contacts, constraints)
        _move(step, system)
        joints.measure(system)
        if taken[1] < taken[0]:
            _record(system, inward, efforts, active[0], states[taken[1]])
            if len(contact_records.bodies) > 0:
                record_contacts(
                    n, taken[1], sequence, system.bodies, scene, contacts, contact_records
                )
            taken[1] += 1
        result[0] = n
        given = -1
        if fell:
            made = done + 1
            break
    end_islands(islands)
    return made


@threaded
def serve(table: Array) -> int:
    """Help advance() in another thread until it is told to end, see islands.py; table: as there."""
    state = _state_at(table)
    settings, sequence, system, constraints = state[0], state[2], state[3], state[6]
    blocks, islands = state[7], state[8]
    return help_solve(system, sequence, constraints, blocks, islands, settings)
