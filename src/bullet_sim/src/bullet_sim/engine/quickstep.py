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
constraint; the constants below are their columns. Units: m, kg, s, rad; world axes if nothing else
is said. numba compiles the functions. No operation is reordered, so that results are the same on
all processors.
"""

import math

import numpy as np
from numba import njit

from bullet_sim.pose import Array

HINGE, SLIDER, FIXED = 0, 1, 2  # types of joints
SPHERE, CYLINDER, BOX, MESH, OTHER = range(5)  # types of shapes; of OTHER the caller finds contacts

# bodies: centre of mass, quaternion, linear and angular velocity, its place in the last step's
# order, time and steps for which it has to rest until it sleeps, whether it sleeps, mass, inertia
# and its inverse in the body's axes, whether gravity acts, bound of the push out of contacts, depth
# that is left, radius of a sphere around the shapes, whether it may sleep, external force and
# torque of the next step
POS, QUAT, VEL, PLACE, REST, REST_STEPS, ASLEEP = 0, 3, 7, 13, 14, 15, 16
MASS, INERTIA, INVERSE, GRAVITY = 17, 18, 27, 36
MAX_VEL, MIN_DEPTH, RADIUS, MAY_SLEEP, FORCE, B_SIZE = 37, 38, 39, 40, 41, 47
# joints: anchor in both bodies (from their centres; of the world: its coordinates), axis in both,
# quaternion of the first in the second at 0, limits, damping, the motor's effort and velocity,
# effort of the next step, position, velocity, commanded position and where it is by now, its
# speed, last impulses of both solutions, the motor's last effort, force and torque on the first
# body, whether damping is a constraint (else it is an effort of the last velocity), velocity that
# the first body is given before each step (NaN: none)
ANCHOR1, ANCHOR2, AXIS1, AXIS2, QREL, LOWER, UPPER, DAMPING = 0, 3, 6, 9, 12, 16, 17, 18
FMAX, SPEED, EFFORT, ANGLE, RATE, TARGET, REACHED, MAX_SPEED = 19, 20, 21, 22, 23, 24, 25, 26
WARM, WARM2, MOTOR, WRENCH, IMPLICIT, IMPOSED, J_SIZE = 27, 34, 41, 42, 48, 49, 50
# shapes: size, centre in the body (from its centre of mass), rotation, mu, mu2, fdir1, kp, kd,
# slip1, slip2
G_SIZE, G_OFFSET, G_ROTATION, G_MU, G_FDIR, G_KP, G_KD = 0, 3, 6, 15, 17, 20, 21
G_SLIP, G_COLUMNS = 22, 24
# planes: normal, distance from the origin; as a shape's the rest
P_PLANE, P_MU, P_FDIR, P_KP, P_KD, P_SLIP, P_COLUMNS = 0, 4, 6, 9, 10, 11, 13
# contacts: point, normal towards the first body, depth, mu, mu2, fdir1 (world), erp, cfm, bound
# of the push, force on the first body, slip1 and slip2
C_POINT, C_NORMAL, C_DEPTH, C_MU, C_FDIR, C_ERP, C_CFM, C_MAX, C_FORCE, C_SLIP, C_SIZE = (
    0, 3, 6, 7, 9, 12, 13, 14, 15, 18, 20,
)  # fmt: skip
# constraint rows: Jacobian of both bodies, inverse mass times it, right sides, relaxed CFM,
# bounds, impulses
R_J, R_M, R_RHS, R_RHS2, R_CFM, R_LOW, R_HIGH, R_L, R_L2, R_C, R_MAX, R_SIZE = (
    0, 12, 24, 25, 26, 27, 28, 29, 30, 31, 32, 33,
)  # fmt: skip
# working values of bodies: rotation, inertia and inverse in world axes, force and torque,
# accelerations
W_R, W_I, W_V, W_F, W_T, W_A, W_A2, W_SIZE = 0, 9, 18, 27, 33, 39, 45, 51

BILATERAL, UNILATERAL = -1, -2  # instead of the index of the normal's row
INFINITE = 1e300
# settings of a world: relaxation, fraction of a joint's error that is corrected in a step, CFM of
# joints, whether the inertias of hinged bodies are moved closer to each other
S_RELAXATION, S_ERP, S_CFM, S_EVEN, S_SIZE = 0, 1, 2, 3, 4
FRICTION_SCALE = 0.25
FRICTION_ITERATIONS = 10
SMOOTHING = 0.01
WARM_START = 0.5
MESH_CONTACTS = 10  # of a mesh with a plane, sdformat's max_contacts of a collision
INERTIA_RATIO = 200.0  # above which inertias across a hinge are moved closer
REST_TIME, REST_COUNT = 1.0, 5  # [s], steps, for which what is slower than the next sleeps then
REST_SPEED = 0.1  # [m/s, rad/s]
_PARALLEL = 1e-7
_STANDING = 0.9  # cosine between a cylinder's axis and a normal, above which its disc touches
_SAME_DIRECTION = 0.98  # cosine between normals that are one
_CLOSE = 0.01  # [m] between a contact and the face that it is with
_SEAM = 1e-6  # [m] by which a triangle is larger on all sides
_SAME = 1e-4  # [m] between contacts that are one
COVERED = 32  # boxes that one cover contains


@njit(cache=True)
def _cross(a: Array, b: Array, out: Array) -> None:
    x = a[1] * b[2] - a[2] * b[1]
    y = a[2] * b[0] - a[0] * b[2]
    z = a[0] * b[1] - a[1] * b[0]
    out[0], out[1], out[2] = x, y, z


@njit(cache=True)
def _rotate(m: Array, v: Array, out: Array) -> None:
    """out = m v, of a matrix as nine numbers."""
    x = m[0] * v[0] + m[1] * v[1] + m[2] * v[2]
    y = m[3] * v[0] + m[4] * v[1] + m[5] * v[2]
    z = m[6] * v[0] + m[7] * v[1] + m[8] * v[2]
    out[0], out[1], out[2] = x, y, z


@njit(cache=True)
def _matrix(q: Array, out: Array) -> None:
    """Rotation matrix (nine numbers) of a quaternion (x, y, z, w)."""
    x, y, z, w = q[0], q[1], q[2], q[3]
    out[0], out[1], out[2] = 1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)
    out[3], out[4], out[5] = 2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)
    out[6], out[7], out[8] = 2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)


@njit(cache=True)
def _multiply(a: Array, b: Array, out: Array) -> None:
    """Quaternion product a b."""
    x = a[3] * b[0] + a[0] * b[3] + a[1] * b[2] - a[2] * b[1]
    y = a[3] * b[1] - a[0] * b[2] + a[1] * b[3] + a[2] * b[0]
    z = a[3] * b[2] + a[0] * b[1] - a[1] * b[0] + a[2] * b[3]
    w = a[3] * b[3] - a[0] * b[0] - a[1] * b[1] - a[2] * b[2]
    out[0], out[1], out[2], out[3] = x, y, z, w


@njit(cache=True)
def _similar(r: Array, m: Array, out: Array) -> None:
    """out = r m r^T, of matrices as nine numbers."""
    for i in range(3):
        for j in range(3):
            total = 0.0
            for k in range(3):
                for n in range(3):
                    total += r[3 * i + k] * m[3 * k + n] * r[3 * j + n]
            out[3 * i + j] = total


@njit(cache=True)
def _plane_space(n: Array, p: Array, q: Array) -> None:
    """Two unit vectors across n and across each other, as ODE chooses them."""
    if abs(n[2]) > math.sqrt(0.5):
        a = n[1] * n[1] + n[2] * n[2]
        k = 1.0 / math.sqrt(a)
        p[0], p[1], p[2] = 0.0, -n[2] * k, n[1] * k
        q[0], q[1], q[2] = a * k, -n[0] * p[2], n[0] * p[1]
    else:
        a = n[0] * n[0] + n[1] * n[1]
        k = 1.0 / math.sqrt(a)
        p[0], p[1], p[2] = -n[1] * k, n[0] * k, 0.0
        q[0], q[1], q[2] = -n[2] * p[1], n[2] * p[0], a * k


@njit(cache=True)
def _invert(m: Array, out: Array) -> None:
    """Inverse of a symmetric matrix (nine numbers)."""
    a, b, c, d, e, f = m[0], m[1], m[2], m[4], m[5], m[8]
    det = a * (d * f - e * e) - b * (b * f - c * e) + c * (b * e - c * d)
    out[0], out[1], out[2] = (d * f - e * e) / det, (c * e - b * f) / det, (b * e - c * d) / det
    out[3], out[4], out[5] = out[1], (a * f - c * c) / det, (b * c - a * e) / det
    out[6], out[7], out[8] = out[2], out[5], (a * d - b * b) / det


@njit(cache=True)
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
        _invert(work[body, W_I : W_I + 9], work[body, W_V : W_V + 9])


@njit(cache=True)
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


@njit(cache=True)
def _set_position(
    j: int, position: float, bodies: Array, joints: Array, types: Array, below: Array
) -> None:
    """Put what is below a joint where a position says."""
    rotation, axis, anchor, arm = np.empty(9), np.empty(3), np.empty(3), np.empty(3)
    turn, quaternion = np.empty(4), np.empty(4)
    change = position - joints[j, ANGLE]
    if change == 0.0:
        return
    joints[j, ANGLE] = position
    first = types[j, 1]
    _matrix(bodies[first, QUAT : QUAT + 4], rotation)
    _rotate(rotation, joints[j, AXIS1 : AXIS1 + 3], axis)
    _rotate(rotation, joints[j, ANCHOR1 : ANCHOR1 + 3], anchor)
    for k in range(3):
        anchor[k] += bodies[first, POS + k]
    if types[j, 0] == HINGE:
        sine = math.sin(0.5 * change)
        turn[0], turn[1], turn[2] = axis[0] * sine, axis[1] * sine, axis[2] * sine
        turn[3] = math.cos(0.5 * change)
        _matrix(turn, rotation)
    for b in range(len(bodies)):
        if not below[b]:
            continue
        if types[j, 0] == HINGE:
            for k in range(3):
                arm[k] = bodies[b, POS + k] - anchor[k]
            _rotate(rotation, arm, arm)
            for k in range(3):
                bodies[b, POS + k] = anchor[k] + arm[k]
            _multiply(turn, bodies[b, QUAT : QUAT + 4], quaternion)
            bodies[b, QUAT : QUAT + 4] = quaternion
        else:
            for k in range(3):
                bodies[b, POS + k] += change * axis[k]


@njit(cache=True)
def _set_velocity(j: int, velocity: float, bodies: Array, joints: Array, types: Array) -> None:
    """Give the body below a joint the motion of the one above, and a velocity along the joint.

    As Gazebo's Joint::SetVelocity.
    """
    rotation, axis, arm, turn = np.empty(9), np.empty(3), np.empty(3), np.empty(3)
    first, second = types[j, 1], types[j, 2]
    child = bodies[first]
    _matrix(child[QUAT : QUAT + 4], rotation)
    _rotate(rotation, joints[j, AXIS1 : AXIS1 + 3], axis)
    for k in range(3):
        child[VEL + k] = bodies[second, VEL + k] if second >= 0 else 0.0
    if types[j, 0] != HINGE:
        for k in range(3):
            child[VEL + k] += velocity * axis[k]
        return
    for k in range(3):
        spin = bodies[second, VEL + 3 + k] if second >= 0 else 0.0
        child[VEL + 3 + k] = spin + velocity * axis[k]
    _rotate(rotation, joints[j, ANCHOR1 : ANCHOR1 + 3], arm)
    _cross(arm, child[VEL + 3 : VEL + 6], turn)
    for k in range(3):
        child[VEL + k] += turn[k]
    if second >= 0:
        _matrix(bodies[second, QUAT : QUAT + 4], rotation)
        _rotate(rotation, joints[j, ANCHOR2 : ANCHOR2 + 3], arm)
        _cross(bodies[second, VEL + 3 : VEL + 6], arm, turn)
        for k in range(3):
            child[VEL + k] += turn[k]


@njit(cache=True)
def _prepare(gravity: Array, bodies: Array, joints: Array, types: Array, work: Array) -> None:
    """Rotations, inertias and forces of all bodies for a step."""
    spin, axis, arm = np.empty(3), np.empty(3), np.empty(3)
    for b in range(len(bodies)):
        _matrix(bodies[b, QUAT : QUAT + 4], work[b, W_R : W_R + 9])
        _similar(work[b, W_R : W_R + 9], bodies[b, INERTIA : INERTIA + 9], work[b, W_I : W_I + 9])
        _similar(work[b, W_R : W_R + 9], bodies[b, INVERSE : INVERSE + 9], work[b, W_V : W_V + 9])
        _rotate(work[b, W_I : W_I + 9], bodies[b, VEL + 3 : VEL + 6], spin)
        _cross(spin, bodies[b, VEL + 3 : VEL + 6], work[b, W_F + 3 : W_F + 6])  # gyroscopic
        for k in range(3):
            weight = bodies[b, MASS] * gravity[k] * bodies[b, GRAVITY]
            work[b, W_F + k] = weight + bodies[b, FORCE + k]
            work[b, W_F + 3 + k] += bodies[b, FORCE + 3 + k]
    for j in range(len(joints)):
        effort = joints[j, EFFORT]
        if joints[j, IMPLICIT] == 0.0:
            effort -= joints[j, DAMPING] * joints[j, RATE]
        if effort == 0.0:
            continue
        first, second = types[j, 1], types[j, 2]
        _rotate(work[first, W_R : W_R + 9], joints[j, AXIS1 : AXIS1 + 3], axis)
        shift = 3 if types[j, 0] == HINGE else 0
        for k in range(3):
            work[first, W_F + shift + k] += effort * axis[k]
            if second >= 0:
                work[second, W_F + shift + k] -= effort * axis[k]
        if shift == 0 and second >= 0:  # both forces on one line
            for k in range(3):
                arm[k] = 0.5 * (bodies[second, POS + k] - bodies[first, POS + k])
            _cross(arm, axis, spin)
            for k in range(3):
                work[first, W_F + 3 + k] += effort * spin[k]
                work[second, W_F + 3 + k] += effort * spin[k]


@njit(cache=True)
def softness(step: float, kp1: float, kd1: float, kp2: float, kd2: float) -> tuple[float, float]:
    """ERP and CFM of a contact of two surfaces: their springs kp [N/m] in series, kd [N s/m]."""
    kp = 1.0 / (1.0 / kp1 + 1.0 / kp2)
    kd = kd1 + kd2
    return step * kp / (step * kp + kd), 1.0 / (step * kp + kd)


@njit(cache=True)
def _add_contact(
    step: float,
    n: int,
    contacts: Array,
    owners: Array,
    bodies: Array,
    shapes: Array,
    s: int,
    planes: Array,
    p: int,
    body: int,
    point: Array,
    depth: float,
    work: Array,
) -> None:
    """Contact of a shape with a plane, row n."""
    row, plane, shape = contacts[n], planes[p], shapes[s]
    owners[n, 0], owners[n, 1], owners[n, 2], owners[n, 3] = body, -1, s, p
    for k in range(3):
        row[C_POINT + k], row[C_NORMAL + k] = point[k], plane[P_PLANE + k]
        row[C_FDIR + k] = 0.0
    row[C_DEPTH] = depth - bodies[body, MIN_DEPTH]
    for k in range(2):
        row[C_MU + k] = min(shape[G_MU + k], plane[P_MU + k])
        row[C_SLIP + k] = shape[G_SLIP + k] + plane[P_SLIP + k]
    row[C_ERP], row[C_CFM] = softness(step, shape[G_KP], shape[G_KD], plane[P_KP], plane[P_KD])
    row[C_MAX] = bodies[body, MAX_VEL]
    if shape[G_FDIR] != 0.0 or shape[G_FDIR + 1] != 0.0 or shape[G_FDIR + 2] != 0.0:
        across = np.empty(3)
        _rotate(shape[G_ROTATION : G_ROTATION + 9], shape[G_FDIR : G_FDIR + 3], across)
        _rotate(work[body, W_R : W_R + 9], across, row[C_FDIR : C_FDIR + 3])
    elif plane[P_FDIR] != 0.0 or plane[P_FDIR + 1] != 0.0 or plane[P_FDIR + 2] != 0.0:
        row[C_FDIR : C_FDIR + 3] = plane[P_FDIR : P_FDIR + 3]


@njit(cache=True)
def _mesh_contacts(
    step: float,
    n: int,
    s: int,
    p: int,
    below: float,
    body: int,
    bodies: Array,
    shapes: Array,
    kinds: Array,
    points: Array,
    planes: Array,
    contacts: Array,
    owners: Array,
    work: Array,
) -> int:
    """Contacts of the vertices of a mesh with a plane; the number of all contacts then.

    The first ten below the plane; if there are more, the deepest of the rest in place of the tenth.
    """
    offset, at = np.empty(3), np.empty(3)
    found, deepest, last = 0, 0.0, n
    a, b, c = planes[p, 0], planes[p, 1], planes[p, 2]
    for v in range(kinds[s, 2], kinds[s, 3]):
        _rotate(work[body, W_R : W_R + 9], points[v], offset)
        depth = below - (a * offset[0] + b * offset[1] + c * offset[2])
        if depth <= 0.0 or found >= MESH_CONTACTS and depth <= deepest:
            continue
        for k in range(3):
            at[k] = bodies[body, POS + k] + offset[k]
        if found < MESH_CONTACTS:
            last, found = n, found + 1
            n += 1
            deepest = depth
        deepest = max(deepest, depth)
        _add_contact(step, last, contacts, owners, bodies, shapes, s, planes, p, body, at, depth,
                     work)  # fmt: skip
    return n


@njit(cache=True)
def _box_contacts(
    step: float,
    n: int,
    s: int,
    p: int,
    below: float,
    centre: Array,
    body: int,
    bodies: Array,
    shapes: Array,
    planes: Array,
    contacts: Array,
    owners: Array,
    work: Array,
) -> int:
    """Contacts of a box with a plane: the deepest corner, its neighbours along the two sides that
    are the least inclined, and the corner opposite to it; the number of all contacts then.

    Args:
        below: depth of its centre [m].
    """
    sides, edge, corner, point = np.empty((3, 3)), np.empty(3), np.empty(3), np.empty(3)
    rise, order = np.empty(3), np.empty(3, np.int64)
    depth = below
    for k in range(3):
        corner[k] = centre[k]
    for i in range(3):  # sides that point up from the deepest corner
        for k in range(3):
            edge[k] = shapes[s, G_ROTATION + 3 * k + i]
        _rotate(work[body, W_R : W_R + 9], edge, sides[i])
        along = 0.0
        for k in range(3):
            along += planes[p, k] * sides[i, k]
        size = shapes[s, G_SIZE + i]
        rise[i] = abs(along) * size
        for k in range(3):
            sides[i, k] *= size if along > 0.0 else -size
            corner[k] -= 0.5 * sides[i, k]
        depth += 0.5 * rise[i]
    if depth < 0.0:
        return n
    order[0], order[1] = 0, 1
    if rise[0] < rise[1]:
        if rise[2] < rise[0]:
            order[0], order[1] = 2, 0
        elif rise[1] >= rise[2]:
            order[1] = 2
    elif rise[2] < rise[1]:
        order[0], order[1] = 2, 1
    else:
        order[0], order[1] = 1, 0 if rise[0] < rise[2] else 2
    _add_contact(step, n, contacts, owners, bodies, shapes, s, planes, p, body, corner, depth,
                 work)  # fmt: skip
    n += 1
    for i in range(2):
        if depth - rise[order[i]] < 0.0:
            return n
        for k in range(3):
            point[k] = corner[k] + sides[order[i], k]
        _add_contact(step, n, contacts, owners, bodies, shapes, s, planes, p, body, point,
                     depth - rise[order[i]], work)  # fmt: skip
        n += 1
    depth -= rise[order[0]] + rise[order[1]]
    if depth > 0.0:
        for k in range(3):
            point[k] += sides[order[0], k]
        _add_contact(step, n, contacts, owners, bodies, shapes, s, planes, p, body, point, depth,
                     work)  # fmt: skip
        n += 1
    return n


@njit(cache=True)
def _axis_of(s: int, body: int, shapes: Array, plane: Array, work: Array, axis: Array) -> float:
    """A cylinder's axis; the cosine between it and a plane's normal."""
    for k in range(3):
        axis[k] = shapes[s, G_ROTATION + 3 * k + 2]
    _rotate(work[body, W_R : W_R + 9], axis, axis)
    return axis[0] * plane[0] + axis[1] * plane[1] + axis[2] * plane[2]


@njit(cache=True)
def _lowest_line(
    s: int, centre: Array, axis: Array, along: float, shapes: Array, plane: Array, ends: Array
) -> None:
    """The line of a cylinder that is deepest below a plane, (2, 3); axis, along: _axis_of()."""
    rim = np.empty(3)
    for k in range(3):
        rim[k] = axis[k] * along - plane[k]
    length = math.sqrt(rim[0] ** 2 + rim[1] ** 2 + rim[2] ** 2)
    radius, half = shapes[s, G_SIZE], 0.5 * shapes[s, G_SIZE + 1]
    for k in range(3):
        ends[0, k] = centre[k] + half * axis[k] + rim[k] * (radius / length)
        ends[1, k] = centre[k] - half * axis[k] + rim[k] * (radius / length)


@njit(cache=True)
def _cylinder_contacts(
    step: float,
    n: int,
    s: int,
    p: int,
    centre: Array,
    body: int,
    bodies: Array,
    shapes: Array,
    planes: Array,
    contacts: Array,
    owners: Array,
    work: Array,
) -> int:
    """Contacts of a cylinder with a plane: the lowest point of each rim, or four of the lower disc
    if it stands; the number of all contacts then."""
    axis, rim, other, point = np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    a, b, c, d = planes[p, 0], planes[p, 1], planes[p, 2], planes[p, 3]
    radius, half = shapes[s, G_SIZE], 0.5 * shapes[s, G_SIZE + 1]
    along = _axis_of(s, body, shapes, planes[p], work, axis)
    if abs(abs(along) - 1.0) < _PARALLEL:
        sign = -1.0 if along > 0.0 else 1.0
        for k in range(3):
            point[k] = centre[k] + sign * half * axis[k]
        if d - (a * point[0] + b * point[1] + c * point[2]) < 0.0:
            return n
        for k in range(3):
            other[k] = axis[k]
        other[0 if abs(axis[0]) < _PARALLEL else 1] += 1.0
        _cross(other, axis, rim)
        length = math.sqrt(rim[0] ** 2 + rim[1] ** 2 + rim[2] ** 2)
        for k in range(3):
            rim[k] *= radius / length
        _cross(rim, axis, other)
        for corner in range(4):
            for k in range(3):
                reach = other[k] if corner < 2 else rim[k]
                reach = reach if corner % 2 == 0 else -reach
                point[k] = centre[k] + sign * half * axis[k] + reach
            depth = d - (a * point[0] + b * point[1] + c * point[2])
            if depth > 0.0:
                _add_contact(step, n, contacts, owners, bodies, shapes, s, planes, p, body, point,
                             depth, work)  # fmt: skip
                n += 1
        return n
    ends = np.empty((2, 3))
    _lowest_line(s, centre, axis, along, shapes, planes[p], ends)
    for end in (1, 0):
        depth = d - (a * ends[end, 0] + b * ends[end, 1] + c * ends[end, 2])
        if depth >= 0.0:
            _add_contact(step, n, contacts, owners, bodies, shapes, s, planes, p, body, ends[end],
                         depth, work)  # fmt: skip
            n += 1
    return n


@njit(cache=True)
def _find_contacts(
    step: float,
    bodies: Array,
    sequence: Array,
    shapes: Array,
    kinds: Array,
    firsts: Array,
    points: Array,
    planes: Array,
    touches: Array,
    contacts: Array,
    owners: Array,
    start: int,
    work: Array,
) -> int:
    """Contacts of all shapes but OTHER with planes, from row `start`; the number of all.

    Their order is that of Gazebo: bodies as in the last step, of a body the last shape first, of
    all meshes after the others.
    """
    n = start
    centre, point = np.empty(3), np.empty(3)
    for meshes in (False, True):
        for body in sequence:
            if bodies[body, ASLEEP] != 0.0:
                continue
            for s in range(firsts[body + 1] - 1, firsts[body] - 1, -1):
                kind = kinds[s, 1]
                if kind == OTHER or (kind == MESH) != meshes:
                    continue
                _rotate(work[body, W_R : W_R + 9], shapes[s, G_OFFSET : G_OFFSET + 3], centre)
                for k in range(3):
                    centre[k] += bodies[body, POS + k]
                size = shapes[s, G_SIZE : G_SIZE + 3]
                for p in range(len(planes)):
                    if not touches[s, p]:
                        continue
                    below = planes[p, P_PLANE + 3]
                    for k in range(3):
                        below -= planes[p, k] * (bodies[body, POS + k] if meshes else centre[k])
                    if below + bodies[body, RADIUS] < 0.0:
                        continue
                    if meshes:
                        n = _mesh_contacts(step, n, s, p, below, body, bodies, shapes, kinds,
                                           points, planes, contacts, owners, work)  # fmt: skip
                    elif kind == SPHERE:
                        if below + size[0] >= 0.0:
                            for k in range(3):
                                point[k] = centre[k] - planes[p, k] * size[0]
                            _add_contact(step, n, contacts, owners, bodies, shapes, s, planes, p,
                                         body, point, below + size[0], work)  # fmt: skip
                            n += 1
                    elif kind == CYLINDER:
                        n = _cylinder_contacts(step, n, s, p, centre, body, bodies, shapes, planes,
                                               contacts, owners, work)  # fmt: skip
                    else:
                        n = _box_contacts(step, n, s, p, below, centre, body, bodies, shapes,
                                          planes, contacts, owners, work)  # fmt: skip
    return n


@njit(cache=True)
def _is_on(point: Array, normal: Array, corners: Array) -> bool:
    """Whether a point is above or below a triangle of nine numbers."""
    edge, arm, across = np.empty(3), np.empty(3), np.empty(3)
    for i in range(3):
        following = 3 * ((i + 1) % 3)
        for k in range(3):
            edge[k] = corners[following + k] - corners[3 * i + k]
            arm[k] = point[k] - corners[3 * i + k]
        _cross(edge, arm, across)
        inward = across[0] * normal[0] + across[1] * normal[1] + across[2] * normal[2]
        length = math.sqrt(edge[0] ** 2 + edge[1] ** 2 + edge[2] ** 2)
        if inward < -_SEAM * length:
            return False
    return True


@njit(cache=True)
def _clip(ends: Array, plane: Array, corners: Array) -> bool:
    """Shorten a line (2, 3) to what is below a triangle of nine numbers; whether there is some."""
    edge, inward = np.empty(3), np.empty(3)
    first, last = 0.0, 1.0
    for i in range(-1, 3):
        if i < 0:
            a, b = plane[3], plane[3]
            for k in range(3):
                a -= plane[k] * ends[0, k]
                b -= plane[k] * ends[1, k]
        else:
            following = 3 * ((i + 1) % 3)
            for k in range(3):
                edge[k] = corners[following + k] - corners[3 * i + k]
            _cross(plane[:3], edge, inward)
            a = b = 0.0
            for k in range(3):
                a += inward[k] * (ends[0, k] - corners[3 * i + k])
                b += inward[k] * (ends[1, k] - corners[3 * i + k])
        if a < 0.0 and b < 0.0:
            return False
        if a < 0.0:
            first = max(first, a / (a - b))
        elif b < 0.0:
            last = min(last, a / (a - b))
    if first > last:
        return False
    for k in range(3):
        a, b = ends[0, k], ends[1, k]
        ends[0, k], ends[1, k] = a + first * (b - a), a + last * (b - a)
    return True


@njit(cache=True)
def _is_known(n: int, first: int, contacts: Array) -> bool:
    """Whether contact n is one of those from row `first` on: same point, same normal."""
    for i in range(first, n):
        same = True
        for k in range(6):
            if abs(contacts[i, C_POINT + k] - contacts[n, C_POINT + k]) > _SAME:
                same = False
        if same:
            return True
    return False


@njit(cache=True)
def _triangle_contacts(
    step: float,
    n: int,
    s: int,
    t: int,
    height: float,
    centre: Array,
    body: int,
    bodies: Array,
    shapes: Array,
    kinds: Array,
    triangles: Array,
    slopes: Array,
    contacts: Array,
    owners: Array,
    work: Array,
) -> int:
    """Contacts of a sphere or cylinder with a triangle's plane; the number of all contacts then."""
    plane, point, axis, ends = slopes[t], np.empty(3), np.empty(3), np.empty((2, 3))
    if kinds[s, 1] == SPHERE:
        depth = shapes[s, G_SIZE] - height
        if depth >= 0.0:
            for k in range(3):
                point[k] = centre[k] - plane[k] * shapes[s, G_SIZE]
            _add_contact(step, n, contacts, owners, bodies, shapes, s, slopes, t, body, point,
                         depth, work)  # fmt: skip
            n += 1
        return n
    along = _axis_of(s, body, shapes, plane, work, axis)
    if abs(along) > _STANDING:
        return _cylinder_contacts(step, n, s, t, centre, body, bodies, shapes, slopes, contacts,
                                  owners, work)  # fmt: skip
    _lowest_line(s, centre, axis, along, shapes, plane, ends)
    if _clip(ends, plane, triangles[t]):
        for end in range(2):
            depth = plane[3]
            for k in range(3):
                depth -= plane[k] * ends[end, k]
            _add_contact(step, n, contacts, owners, bodies, shapes, s, slopes, t, body, ends[end],
                         max(depth, 0.0), work)  # fmt: skip
            n += 1
    return n


@njit(cache=True)
def is_on_face(
    point: Array,
    direction: Array,
    slopes: Array,
    ranges: Array,
    covers: Array,
    boxes: Array,
) -> bool:
    """Whether a contact is one with the side of a triangle, by its normal, and not with an edge."""
    for i in range(len(covers)):
        if not _reaches(point, _CLOSE, covers[i]):
            continue
        for at in range(i * COVERED, min((i + 1) * COVERED, len(boxes))):
            if not _reaches(point, _CLOSE, boxes[at]):
                continue
            for t in range(ranges[at, 0], ranges[at, 1]):
                across, height = 0.0, -slopes[t, P_PLANE + 3]
                for k in range(3):
                    across += slopes[t, k] * direction[k]
                    height += slopes[t, k] * point[k]
                if abs(across) > _SAME_DIRECTION and abs(height) < _CLOSE:
                    return True
    return False


@njit(cache=True)
def find_on_meshes(
    step: float,
    bodies: Array,
    sequence: Array,
    shapes: Array,
    kinds: Array,
    firsts: Array,
    round_: Array,
    triangles: Array,
    slopes: Array,
    meshes: Array,
    ranges: Array,
    covers: Array,
    boxes: Array,
    contacts: Array,
    owners: Array,
    most: int,
    work: Array,
) -> int:
    """Contacts of spheres and cylinders with meshes that never move, from row 0; their number.

    Of a cylinder those are the ends of its lowest line, as far as that is below the triangle; of
    others those with the triangle's plane that are on it. Only what is above a triangle touches it.

    Args:
        round_: (n,) which shapes count.
        triangles: (t, 9) corners.
        slopes: (t, P_COLUMNS) their planes.
        meshes: (t,) number of the mesh, for the contacts' owners.
        ranges: (b, 2) first triangle of each box and the one after its last.
        covers, boxes: as of _is_near().
        most: number of contacts.
    """
    n = 0
    centre = np.empty(3)
    for body in sequence:
        for s in range(firsts[body + 1] - 1, firsts[body] - 1, -1):
            if not round_[s]:
                continue
            kind, first = kinds[s, 1], n
            _matrix(bodies[body, QUAT : QUAT + 4], work[body, W_R : W_R + 9])
            _rotate(work[body, W_R : W_R + 9], shapes[s, G_OFFSET : G_OFFSET + 3], centre)
            for k in range(3):
                centre[k] += bodies[body, POS + k]
            radius = shapes[s, G_SIZE]
            reach = radius if kind == SPHERE else math.hypot(radius, 0.5 * shapes[s, G_SIZE + 1])
            for i in range(len(covers)):
                if not _reaches(centre, reach, covers[i]):
                    continue
                for at in range(i * COVERED, min((i + 1) * COVERED, len(boxes))):
                    if ranges[at, 0] == ranges[at, 1] or not _reaches(centre, reach, boxes[at]):
                        continue
                    for t in range(ranges[at, 0], ranges[at, 1]):
                        normal = slopes[t, P_PLANE : P_PLANE + 3]
                        height = -slopes[t, P_PLANE + 3]
                        for k in range(3):
                            height += normal[k] * centre[k]
                        if height <= 0.0 or height > reach or n + 4 > most:
                            continue
                        found = _triangle_contacts(step, n, s, t, height, centre, body, bodies,
                                                   shapes, kinds, triangles, slopes, contacts,
                                                   owners, work)  # fmt: skip
                        for row in range(n, found):
                            contacts[n] = contacts[row]
                            owners[n, 0], owners[n, 1], owners[n, 2], owners[n, 3] = (
                                body, -1, -1, meshes[t],
                            )  # fmt: skip
                            at_triangle = _is_on(
                                contacts[n, C_POINT : C_POINT + 3], normal, triangles[t]
                            )
                            if at_triangle and not _is_known(n, first, contacts):
                                n += 1
    return n


@njit(cache=True)
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


@njit(cache=True)
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
    arm, arm2, t, q = np.empty(3), np.empty(3), np.empty(3), np.empty(3)
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
            _cross(normal, fdir, q)
            if q[0] == 0.0 and q[1] == 0.0 and q[2] == 0.0:
                _plane_space(normal, t, q)
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
        _cross(arm, t, row[R_J + 3 : R_J + 6])
        if two >= 0:
            _cross(arm2, t, row[R_J + 9 : R_J + 12])
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


@njit(cache=True)
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
    a1, a2, ax1, ax2, p, q, u = (
        np.empty(3), np.empty(3), np.empty(3), np.empty(3), np.empty(3), np.empty(3), np.empty(3),
    )  # fmt: skip
    r1, at1 = work[one, W_R : W_R + 9], bodies[one, POS : POS + 3]
    _rotate(r1, joint[ANCHOR1 : ANCHOR1 + 3], a1)
    _rotate(r1, joint[AXIS1 : AXIS1 + 3], ax1)
    if two >= 0:
        _rotate(work[two, W_R : W_R + 9], joint[ANCHOR2 : ANCHOR2 + 3], a2)
        _rotate(work[two, W_R : W_R + 9], joint[AXIS2 : AXIS2 + 3], ax2)
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
            _cross(a1, u, row[R_J + 3 : R_J + 6])
            error = a2[i] - at1[i] - a1[i]
            if two >= 0:
                row[R_J + 6 + i] = -1.0
                _cross(a2, u, row[R_J + 9 : R_J + 12])
                for k in range(3):
                    row[R_J + 9 + k] = -row[R_J + 9 + k]
                error = bodies[two, POS + i] + a2[i] - at1[i] - a1[i]
            row[R_C] = gain * error
            m += 1
    if kind == HINGE:  # the axes meet
        _plane_space(ax1, p, q)
        _cross(ax1, ax2, u)
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
        error4, inverse = np.empty(4), np.empty(4)
        if two >= 0:
            _multiply(bodies[two, QUAT : QUAT + 4], joint[QREL : QREL + 4], error4)
        else:
            error4[:] = joint[QREL : QREL + 4]
        for k in range(3):
            inverse[k] = -bodies[one, QUAT + k]
        inverse[3] = bodies[one, QUAT + 3]
        _multiply(error4, inverse, error4)
        sign = -2.0 if error4[3] < 0.0 else 2.0
        for i in range(3):
            row = rows[m]
            row[R_J + 3 + i] = 1.0
            if two >= 0:
                row[R_J + 9 + i] = -1.0
            row[R_C] = gain * sign * error4[i]
            m += 1
    if kind == SLIDER:  # the anchors meet, but along the axis
        _plane_space(ax1, p, q)
        for k in range(3):
            ax2[k] = (bodies[two, POS + k] if two >= 0 else 0.0) - at1[k]
        for i in range(2):
            t = p if i == 0 else q
            row = rows[m]
            _cross(ax2, t, u)
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


@njit(cache=True)
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
    damped = joint[IMPLICIT] != 0.0 and joint[DAMPING] > 0.0 and limit == 0
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
        arm = np.empty(3)
        for k in range(3):
            arm[k] = 0.5 * (bodies[two, POS + k] - bodies[one, POS + k])
        _cross(arm, axis, row[R_J + 3 : R_J + 6])
        for k in range(3):
            row[R_J + 9 + k] = row[R_J + 3 + k]
    row[R_MAX], row[R_CFM] = INFINITE, settings[S_CFM]
    if damped:  # a limit at both sides that yields with the velocity
        row[R_C], row[R_CFM] = 0.0, 1.0 / joint[DAMPING]
        row[R_LOW], row[R_HIGH], links[m, 2] = -INFINITE, INFINITE, UNILATERAL
    elif limit:
        if powered:  # the motor pushes with its whole effort
            push = joint[FMAX]
            if joint[SPEED] > 0.0 or (joint[SPEED] == 0.0 and limit == 2):
                push = -push
            for k in range(3):
                work[one, W_F + shift + k] -= push * axis[k]
                if two >= 0:
                    work[two, W_F + shift + k] += push * axis[k]
        stop = joint[LOWER] if limit == 1 else joint[UPPER]
        row[R_C], links[m, 2] = -settings[S_ERP] / step * (position - stop), BILATERAL
        row[R_LOW] = 0.0 if limit == 1 and joint[LOWER] < joint[UPPER] else -INFINITE
        row[R_HIGH] = 0.0 if limit == 2 and joint[LOWER] < joint[UPPER] else INFINITE
    else:
        row[R_C] = joint[SPEED]
        row[R_LOW], row[R_HIGH], links[m, 2] = -joint[FMAX], joint[FMAX], BILATERAL
    return m + 1


@njit(cache=True)
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


@njit(cache=True)
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
    v = np.empty(3)
    for b in range(len(bodies)):
        _rotate(work[b, W_V : W_V + 9], work[b, W_F + 3 : W_F + 6], v)
        for k in range(3):
            work[b, W_T + k] = work[b, W_F + k] / bodies[b, MASS] + bodies[b, VEL + k] / step
            work[b, W_T + 3 + k] = v[k] + bodies[b, VEL + 3 + k] / step
        for k in range(6):
            work[b, W_A + k] = work[b, W_A2 + k] = 0.0
    for i in range(m):
        row, one, two = rows[i], links[i, 0], links[i, 1]
        total = diagonal = 0.0
        for k in range(6):
            total += row[R_J + k] * work[one, W_T + k]
        for k in range(3):
            row[R_M + k] = row[R_J + k] / bodies[one, MASS]
        _rotate(work[one, W_V : W_V + 9], row[R_J + 3 : R_J + 6], row[R_M + 3 : R_M + 6])
        for k in range(6):
            diagonal += row[R_M + k] * row[R_J + k]
        if two >= 0:
            for k in range(6):
                total += row[R_J + 6 + k] * work[two, W_T + k]
            for k in range(3):
                row[R_M + 6 + k] = row[R_J + 6 + k] / bodies[two, MASS]
            _rotate(work[two, W_V : W_V + 9], row[R_J + 9 : R_J + 12], row[R_M + 9 : R_M + 12])
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
                work[one, W_A + k] += row[R_L] * row[R_M + k]
                work[one, W_A2 + k] += row[R_L2] * row[R_M + k]
            if two >= 0:
                for k in range(6):
                    work[two, W_A + k] += row[R_L] * row[R_M + 6 + k]
                    work[two, W_A2 + k] += row[R_L2] * row[R_M + 6 + k]


@njit(cache=True)
def _iterate(m: int, iterations: int, rows: Array, links: Array, order: Array, work: Array) -> None:
    """Projected Gauss-Seidel on both solutions."""
    n = 0
    for i in range(m):
        if links[i, 2] == BILATERAL:
            order[n] = i
            n += 1
    for i in range(m - 1, -1, -1):
        if links[i, 2] == UNILATERAL:
            order[n] = i
            n += 1
    friction = n
    for i in range(m):
        if links[i, 2] >= 0:
            order[n] = i
            n += 1
    for iteration in range(iterations + FRICTION_ITERATIONS):
        for place in range(friction if iteration >= iterations else 0, m):
            i = order[place]
            row = rows[i]
            one, two, normal = links[i, 0], links[i, 1], links[i, 2]
            a = work[one]
            old, old2 = row[R_L], row[R_L2]
            x = row[R_J] * a[W_A] + row[R_J + 1] * a[W_A + 1]
            x += row[R_J + 2] * a[W_A + 2] + row[R_J + 3] * a[W_A + 3]
            x += row[R_J + 4] * a[W_A + 4] + row[R_J + 5] * a[W_A + 5]
            y = row[R_J] * a[W_A2] + row[R_J + 1] * a[W_A2 + 1]
            y += row[R_J + 2] * a[W_A2 + 2] + row[R_J + 3] * a[W_A2 + 3]
            y += row[R_J + 4] * a[W_A2 + 4] + row[R_J + 5] * a[W_A2 + 5]
            if two >= 0:
                b = work[two]
                x += row[R_J + 6] * b[W_A] + row[R_J + 7] * b[W_A + 1]
                x += row[R_J + 8] * b[W_A + 2] + row[R_J + 9] * b[W_A + 3]
                x += row[R_J + 10] * b[W_A + 4] + row[R_J + 11] * b[W_A + 5]
                y += row[R_J + 6] * b[W_A2] + row[R_J + 7] * b[W_A2 + 1]
                y += row[R_J + 8] * b[W_A2 + 2] + row[R_J + 9] * b[W_A2 + 3]
                y += row[R_J + 10] * b[W_A2 + 4] + row[R_J + 11] * b[W_A2 + 5]
            new = old + (row[R_RHS] - old * row[R_CFM] - x)
            new2 = old2 + (row[R_RHS2] - old2 * row[R_CFM] - y)
            if normal >= 0:
                high = abs(row[R_HIGH] * rows[normal, R_L])
                high2 = abs(row[R_HIGH] * rows[normal, R_L2])
                low, low2 = -high, -high2
            else:
                high = high2 = row[R_HIGH]
                low = low2 = row[R_LOW]
            new = min(max(new, low), high)
            new2 = min(max(new2, low2), high2)
            change, change2 = new - old, new2 - old2
            row[R_L] = new if normal == BILATERAL else (1.0 - SMOOTHING) * new + SMOOTHING * old
            row[R_L2] = new2
            for k in range(6):
                a[W_A + k] += change * row[R_M + k]
                a[W_A2 + k] += change2 * row[R_M + k]
            if two >= 0:
                b = work[two]
                for k in range(6):
                    b[W_A + k] += change * row[R_M + 6 + k]
                    b[W_A2 + k] += change2 * row[R_M + 6 + k]


@njit(cache=True)
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
    v, turn, quaternion = np.empty(3), np.empty(4), np.empty(4)
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
            _rotate(work[one, W_I : W_I + 9], row[R_M + 3 : R_M + 6], v)
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
        _rotate(work[b, W_V : W_V + 9], work[b, W_F + 3 : W_F + 6], v)
        for k in range(3):
            body[VEL + k] += step * (work[b, W_A2 + k] + work[b, W_F + k] / body[MASS])
            body[VEL + 3 + k] += step * (work[b, W_A2 + 3 + k] + v[k])
            body[FORCE + k] = body[FORCE + 3 + k] = 0.0
        for k in range(3):
            body[POS + k] += step * body[VEL + k]
        for k in range(3):
            turn[k] = 0.5 * step * body[VEL + 3 + k]
        turn[3] = 1.0
        _multiply(turn, body[QUAT : QUAT + 4], quaternion)
        length = math.sqrt(
            quaternion[0] ** 2 + quaternion[1] ** 2 + quaternion[2] ** 2 + quaternion[3] ** 2
        )
        for k in range(4):
            body[QUAT + k] = quaternion[k] / length
        for k in range(6):  # what has pushed out of contacts is no velocity
            body[VEL + k] += step * (work[b, W_A + k] - work[b, W_A2 + k])
    for j in range(len(joints)):
        joints[j, EFFORT] = 0.0
    measure_joints(bodies, joints, types)


@njit(cache=True)
def measure_joints(bodies: Array, joints: Array, types: Array) -> None:
    """Positions and velocities of the joints; positions of hinges count whole rotations."""
    error, inverse, rotation = np.empty(4), np.empty(4), np.empty(9)
    axis, a2 = np.empty(3), np.empty(3)
    for j in range(len(joints)):
        kind, one, two = types[j, 0], types[j, 1], types[j, 2]
        joint = joints[j]
        _matrix(bodies[one, QUAT : QUAT + 4], rotation)
        _rotate(rotation, joint[AXIS1 : AXIS1 + 3], axis)
        shift = 3 if kind == HINGE else 0
        rate = 0.0
        for k in range(3):
            relative = bodies[one, VEL + shift + k]
            if two >= 0:
                relative -= bodies[two, VEL + shift + k]
            rate += axis[k] * relative
        if kind == HINGE:
            if two >= 0:
                _multiply(bodies[two, QUAT : QUAT + 4], joint[QREL : QREL + 4], error)
            else:
                error[:] = joint[QREL : QREL + 4]
            for k in range(3):
                inverse[k] = -error[k]
            inverse[3] = error[3]
            _multiply(inverse, bodies[one, QUAT : QUAT + 4], error)
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
                _matrix(bodies[two, QUAT : QUAT + 4], rotation)
                _rotate(rotation, joint[ANCHOR2 : ANCHOR2 + 3], a2)
                for k in range(3):
                    a2[k] += bodies[two, POS + k]
            for k in range(3):
                position += axis[k] * (bodies[one, POS + k] - a2[k])
            joint[ANGLE] = position
        joint[RATE] = rate


@njit(cache=True)
def _reaches(centre: Array, radius: float, box: Array) -> bool:
    """Whether a sphere reaches a box of six numbers: its lower and its upper corner."""
    outside = 0.0
    for k in range(3):
        gap = max(box[k] - centre[k], centre[k] - box[3 + k], 0.0)
        outside += gap * gap
    return outside <= radius * radius


@njit(cache=True)
def _is_near(bodies: Array, covers: Array, boxes: Array, groups: Array) -> bool:
    """Whether a body may touch what the caller finds the contacts of.

    Args:
        boxes: (n, 6) boxes around what never moves, but for planes.
        covers: (m, 6) boxes around COVERED of these each, in their order.
        groups: (n,) model of each body; those of one model do not count.
    """
    for b in range(len(bodies)):
        radius, sleeps = bodies[b, RADIUS], bodies[b, ASLEEP] != 0.0
        if radius <= 0.0:
            continue
        centre = bodies[b, POS : POS + 3]
        for i in range(0 if sleeps else len(covers)):
            if _reaches(centre, radius, covers[i]):
                for at in range(i * COVERED, min((i + 1) * COVERED, len(boxes))):
                    if _reaches(centre, radius, boxes[at]):
                        return True
        for other in range(b):
            if groups[other] == groups[b] or bodies[other, RADIUS] <= 0.0:
                continue
            if sleeps and bodies[other, ASLEEP] != 0.0:
                continue
            distance = 0.0
            for k in range(3):
                gap = bodies[b, POS + k] - bodies[other, POS + k]
                distance += gap * gap
            reach = radius + bodies[other, RADIUS]
            if distance <= reach * reach:
                return True
    return False


@njit(cache=True)
def advance(
    count: int,
    step: float,
    iterations: int,
    settings: Array,
    gravity: Array,
    bodies: Array,
    sequence: Array,
    joints: Array,
    types: Array,
    starts: Array,
    lists: Array,
    below: Array,
    shapes: Array,
    kinds: Array,
    firsts: Array,
    points: Array,
    planes: Array,
    touches: Array,
    covers: Array,
    boxes: Array,
    groups: Array,
    contacts: Array,
    owners: Array,
    given: int,
    watch: bool,
    sleepy: bool,
    rows: Array,
    links: Array,
    first_row: Array,
    order: Array,
    work: Array,
    marks: Array,
    result: Array,
) -> int:
    """Make up to `count` steps.

    Args:
        sequence: (n,) the bodies in the order of the last step, which the contacts follow.
        firsts: (n + 1,) first shape of each body; those of a body follow each other.
        points: (n, 3) vertices of meshes, from their bodies' centres of mass.
        given: number of contacts, in the first rows, that the caller has found for the next step;
            -1: none were looked for, and it stops before a step for which they are needed.
        watch: whether there is something of which the caller finds the contacts.
        sleepy: whether there are bodies that may sleep.
        result: gets the number of contacts of the last step.

    Returns:
        Number of steps made; it also stops after a step in which a body has fallen asleep.
    """
    for done in range(count):
        if watch and given < 0 and _is_near(bodies, covers, boxes, groups):
            return done
        _impose(step, bodies, joints, types, below)
        _prepare(gravity, bodies, joints, types, work)
        n = _find_contacts(step, bodies, sequence, shapes, kinds, firsts, points, planes, touches,
                           contacts, owners, max(given, 0), work)  # fmt: skip
        fell = sleepy and _fall_asleep(step, n, bodies, owners, marks[0])
        m = _build(step, n, bodies, joints, types, starts, lists, contacts, owners, rows, links,
                   first_row, work, marks, sequence, settings)  # fmt: skip
        _relax(step, m, bodies, joints, rows, links, work, settings)
        _iterate(m, iterations, rows, links, order, work)
        _move(step, m, n, bodies, joints, types, contacts, first_row, rows, links, work)
        result[0] = n
        given = -1
        if fell:
            return done + 1
    return count
