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
from typing import NamedTuple

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
MPR_TOLERANCE, MPR_ITERATIONS = 1e-6, 500  # of cylinders with cylinders
_EPSILON = 2.220446049250313e-16
EDGE_FACTOR = 1.05  # by which edges of boxes have to overlap less than faces
MESH_CONTACTS = 10  # of a mesh with a plane, sdformat's max_contacts of a collision
INERTIA_RATIO = 200.0  # above which inertias across a hinge are moved closer
REST_TIME, REST_COUNT = 1.0, 5  # [s], steps, for which what is slower than the next sleeps then
REST_SPEED = 0.1  # [m/s, rad/s]
_PARALLEL = 1e-7
_STANDING = 0.9  # cosine between a cylinder's axis and a normal, above which its disc touches
_SAME = 1e-4  # [m] between contacts that are one, and between their normals
COVERED = 32  # boxes that one cover contains
CHUNK = 32  # vertices of a mesh that follow each other
_ROUNDING = 1e-9  # [m] by which two ways to compute a depth may differ
# what a box around what never moves contains: something else, triangles of a mesh, a solid, a solid
# of a model that has meshes, too
UNKNOWN, TRIANGLES, SOLID, MIXED = range(4)
NOTHING, SOLIDS, ALL = range(3)  # what contacts of a shape are found here
APART, FOUND, LEFT = range(3)  # contacts of two bodies: none, found here, found by the caller
# solids: half the edges, or radius and half the length; centre; rotation
B_HALF, B_CENTRE, B_ROTATION, B_COLUMNS = 0, 3, 6, 15


class Scene(NamedTuple):
    """Shapes of bodies, and what never moves.

    Attributes:
        shapes: (s, G_COLUMNS).
        kinds: (s, 5) body, type, first vertex and the one after the last, first row of chunks.
        firsts: (n + 1,) first shape of each body; those of a body follow each other.
        points: (v, 3) vertices of meshes, from their bodies' centres of mass.
        chunks: (c, 6) centre and half the edges of boxes around CHUNK vertices each of a mesh.
        extents: (s, 6) centre and half the edges of a box around each shape, in its body.
        knows: (s,) of what never moves, besides planes, the contacts are found here: NOTHING,
            SOLIDS, or ALL.
        models: (n,) number of each body's model.
        around: (s, 6) lower and upper corners of boxes around the shapes where they are.
        meet: (n, n) whether two bodies may touch: APART, FOUND (here), or LEFT to the caller.
        close: (c, 2) pairs of bodies that are close, whose contacts are found here.
        counts: (1,) number of these.
        planes: (p, P_COLUMNS).
        touches: (s, p) whether a shape touches a plane.
        triangles: (t, 9) corners.
        slopes: (t, P_COLUMNS) their planes.
        meshes: (t,) number of the mesh, for the contacts' owners.
        solids: (b, B_COLUMNS) boxes, spheres, cylinders: those that never move, then of bodies.
        faces: (b, P_COLUMNS) their surfaces.
        boxes_of: (b,) as meshes.
        solid_kinds: (b,) SPHERE, CYLINDER or BOX.
        solid_of: (s,) each shape's row of solids, -1 of meshes and OTHER.
        boxes: (m, 6) lower and upper corners of boxes around what never moves, but for planes.
        ranges: (m, 3) what is in a box, and the first and the one after the last of these.
        hosts: (m,) model of each box, whose own bodies do not touch it.
        covers: (c, 6) boxes around COVERED of these each, in their order.
    """

    shapes: Array
    kinds: Array
    firsts: Array
    points: Array
    chunks: Array
    extents: Array
    knows: Array
    models: Array
    around: Array
    meet: Array
    close: Array
    counts: Array
    planes: Array
    touches: Array
    triangles: Array
    slopes: Array
    meshes: Array
    solids: Array
    faces: Array
    boxes_of: Array
    solid_kinds: Array
    solid_of: Array
    boxes: Array
    ranges: Array
    hosts: Array
    covers: Array


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
    scene: Scene,
    contacts: Array,
    owners: Array,
    work: Array,
) -> int:
    """Contacts of the vertices of a mesh with a plane; the number of all contacts then.

    The first ten below the plane; if there are more, the deepest of the rest in place of the tenth.
    """
    offset, at, local = np.empty(3), np.empty(3), np.empty(3)
    found, deepest, last = 0, 0.0, n
    planes = scene.planes
    a, b, c = planes[p, 0], planes[p, 1], planes[p, 2]
    for k in range(3):  # the plane's normal in the body
        local[k] = (
            work[body, W_R + k] * a + work[body, W_R + 3 + k] * b + work[body, W_R + 6 + k] * c
        )
    first, end = scene.kinds[s, 2], scene.kinds[s, 3]
    for start in range(first, end, CHUNK):
        box = scene.chunks[scene.kinds[s, 4] + (start - first) // CHUNK]
        highest = below + _ROUNDING
        for k in range(3):
            highest += abs(local[k]) * box[3 + k] - local[k] * box[k]
        if highest <= 0.0:
            continue
        for v in range(start, min(start + CHUNK, end)):
            point = scene.points[v]
            depth = below - (local[0] * point[0] + local[1] * point[1] + local[2] * point[2])
            if depth < -_ROUNDING:
                continue
            _rotate(work[body, W_R : W_R + 9], point, offset)
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
            _add_contact(step, last, contacts, owners, bodies, scene.shapes, s, planes, p, body, at,
                         depth, work)  # fmt: skip
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
def _closest(point: Array, corners: Array, out: Array) -> None:
    """The point of a triangle of nine numbers that is closest to a point.

    C. Ericson, "Real-Time Collision Detection" (2004), 5.1.5.
    """
    ab, ac, arm = np.empty(3), np.empty(3), np.empty(3)
    d = np.zeros(6)  # of both edges with the arm from each corner
    for k in range(3):
        ab[k] = corners[3 + k] - corners[k]
        ac[k] = corners[6 + k] - corners[k]
    for i in range(3):
        for k in range(3):
            arm[k] = point[k] - corners[3 * i + k]
            d[2 * i] += ab[k] * arm[k]
            d[2 * i + 1] += ac[k] * arm[k]
    va, vb = d[2] * d[5] - d[4] * d[3], d[4] * d[1] - d[0] * d[5]
    vc = d[0] * d[3] - d[2] * d[1]
    v = w = 0.0
    if d[0] <= 0.0 and d[1] <= 0.0:
        v = w = 0.0
    elif d[2] >= 0.0 and d[3] <= d[2]:
        v = 1.0
    elif vc <= 0.0 and d[0] >= 0.0 and d[2] <= 0.0:
        v = d[0] / (d[0] - d[2])
    elif d[5] >= 0.0 and d[4] <= d[5]:
        w = 1.0
    elif vb <= 0.0 and d[1] >= 0.0 and d[5] <= 0.0:
        w = d[1] / (d[1] - d[5])
    elif va <= 0.0 and d[3] >= d[2] and d[4] >= d[5]:
        w = (d[3] - d[2]) / ((d[3] - d[2]) + (d[4] - d[5]))
        v = 1.0 - w
    else:
        v, w = vb / (va + vb + vc), vc / (va + vb + vc)
    for k in range(3):
        out[k] = corners[k] + v * ab[k] + w * ac[k]


@njit(cache=True)
def _try_axis(
    x: float, y: float, z: float, hull: Array, count: int, cylinder: Array, best: Array
) -> bool:
    """Whether a cylinder and the hull of points overlap along a direction.

    Args:
        hull: (count, 3) from the cylinder's centre [m].
        cylinder: (5,) its axis, radius and half its length.
        best: (6,) the least overlap so far [m], half the extents of the cylinder and of the hull
            along its direction, and that, from the cylinder towards the hull.
    """
    length = math.sqrt(x * x + y * y + z * z)
    if length < 1e-5:
        return True
    x, y, z = x / length, y / length, z / length
    cosine = cylinder[0] * x + cylinder[1] * y + cylinder[2] * z
    own = abs(cylinder[4] * cosine) + cylinder[3] * math.sqrt(max(0.0, 1.0 - cosine * cosine))
    low, high = INFINITE, -INFINITE
    for i in range(count):
        at = hull[i, 0] * x + hull[i, 1] * y + hull[i, 2] * z
        low, high = min(low, at), max(high, at)
    middle, half = 0.5 * (low + high), 0.5 * (high - low)
    depth = own + half - abs(middle)
    if depth < 0.0:
        return False
    if depth < best[0]:
        sign = -1.0 if middle < 0.0 else 1.0
        best[0], best[1], best[2] = depth, own, half
        best[3], best[4], best[5] = sign * x, sign * y, sign * z
    return True


@njit(cache=True)
def _try_rims(start: Array, end: Array, hull: Array, count: int, cylinder: Array, best: Array,
              end_of_axis: float) -> bool:  # fmt: skip
    """As _try_axis, across an edge and the tangent of a rim where the edge meets its plane."""
    edge, gap, tangent, across = np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    length = along = reach = 0.0
    for k in range(3):
        edge[k] = end[k] - start[k]
        length += edge[k] * edge[k]
    length = math.sqrt(length)
    if length == 0.0:
        return True
    for k in range(3):
        edge[k] /= length
        along += edge[k] * cylinder[k]
        reach += (end_of_axis * cylinder[k] - start[k]) * cylinder[k]
    if abs(along) < 1e-5:
        return True
    for k in range(3):
        gap[k] = end_of_axis * cylinder[k] - start[k] - edge[k] * reach / along
    _cross(gap, cylinder[:3], tangent)
    _cross(tangent, edge, across)
    return _try_axis(across[0], across[1], across[2], hull, count, cylinder, best)


@njit(cache=True)
def _side_line(best: Array, cylinder: Array, ends: Array) -> bool:
    """The line of a cylinder's side, (2, 3) from its centre, closest to the hull; whether it is."""
    cosine, length, across = 0.0, 0.0, np.empty(3)
    for k in range(3):
        cosine += cylinder[k] * best[3 + k]
    for k in range(3):
        across[k] = best[3 + k] - cylinder[k] * cosine
        length += across[k] * across[k]
    length = math.sqrt(length)
    if length < 1e-5:
        return False
    for k in range(3):
        ends[0, k] = across[k] * (cylinder[3] / length) + cylinder[k] * cylinder[4]
        ends[1, k] = across[k] * (cylinder[3] / length) - cylinder[k] * cylinder[4]
    return True


@njit(cache=True)
def _clip_line(x: float, y: float, z: float, distance: float, ends: Array) -> bool:
    """Shorten a line (2, 3) to where (x, y, z) p + distance >= 0; whether there is some."""
    a = x * ends[0, 0] + y * ends[0, 1] + z * ends[0, 2] + distance
    b = x * ends[1, 0] + y * ends[1, 1] + z * ends[1, 2] + distance
    if a < 0.0 and b < 0.0:
        return False
    if a < 0.0 < b or b < 0.0 < a:
        cut = 0 if a < 0.0 else 1
        for k in range(3):
            ends[cut, k] = ends[0, k] - (ends[0, k] - ends[1, k]) * (a / (a - b))
    return True


@njit(cache=True)
def _clip_polygon(
    x: float, y: float, z: float, distance: float, points: Array, count: int, out: Array
) -> int:
    """Corners of the part of a polygon where (x, y, z) p + distance >= 0; their number."""
    n, before = 0, count - 1
    for i in range(count):
        p, q = points[before], points[i]
        a = x * p[0] + y * p[1] + z * p[2] + distance
        b = x * q[0] + y * q[1] + z * q[2] + distance
        if a >= 0.0:
            out[n] = p
            n += 1
        if a < 0.0 < b or b < 0.0 < a:
            for k in range(3):
                out[n, k] = p[k] - (p[k] - q[k]) * (a / (a - b))
            n += 1
        before = i
    return n


@njit(cache=True)
def _disc_points(
    polygon: Array, count: int, turn: Array, cylinder: Array, best: Array, other: Array
) -> int:
    """Points of a polygon below a disc of a cylinder, which counts as an octagon; their number.

    Args:
        polygon: (16, 3) corners from the cylinder's centre; gets the points.
        turn: (9,) the cylinder's rotation.
        other: (16, 3) numbers to work with.
    """
    cosine = 0.0
    for k in range(3):
        cosine += cylinder[k] * best[3 + k]
    sign, half = 1.0 if cosine > 0.0 else -1.0, cylinder[4]
    x, y, z = -sign * cylinder[0], -sign * cylinder[1], -sign * cylinder[2]
    count = _clip_polygon(x, y, z, half, polygon, count, other)
    for i in range(8):
        c, s = math.cos(math.pi * (i + 0.5) / 4.0), math.sin(math.pi * (i + 0.5) / 4.0)
        x, y, z = (
            -c * turn[0] - s * turn[1], -c * turn[3] - s * turn[4], -c * turn[6] - s * turn[7],
        )  # fmt: skip
        if i % 2 == 0:
            count = _clip_polygon(x, y, z, cylinder[3], other, count, polygon)
        else:
            count = _clip_polygon(x, y, z, cylinder[3], polygon, count, other)
    for i in range(count):
        polygon[i] = other[i]
    return count


@njit(cache=True)
def _hull_points(
    hull: Array, count: int, is_line: bool, centre: Array, best: Array, points: Array
) -> int:
    """Of contacts of a cylinder at `hull` (count, 3) from its centre: their points and depths in
    (16, 4); their number."""
    n = 0
    for i in range(count):
        along = 0.0
        for k in range(3):
            along += best[3 + k] * hull[i, k]
            points[n, k] = centre[k] + hull[i, k]
        depth = max(0.0, best[0] - best[1] + along) if is_line else best[1] - abs(along)
        points[n, 3] = depth
        if depth > 0.0 or is_line:
            n += 1
    return n


@njit(cache=True)
def _add_points(
    step: float,
    n: int,
    points: Array,
    count: int,
    normal: Array,
    sign: float,
    s: int,
    body: int,
    surfaces: Array,
    p: int,
    other: int,
    bodies: Array,
    scene: Scene,
    contacts: Array,
    owners: Array,
    work: Array,
) -> int:
    """Contacts of shape s of a body at points (count, 4), with `sign` times a normal, with surface
    p of what `other` is the number of; the number of all then."""
    for i in range(count):
        if n >= len(contacts):
            break
        _add_contact(step, n, contacts, owners, bodies, scene.shapes, s, surfaces, p, body,
                     points[i, :3], points[i, 3], work)  # fmt: skip
        for k in range(3):
            contacts[n, C_NORMAL + k] = sign * normal[k]
        owners[n, 2], owners[n, 3] = -1, other
        n += 1
    return n


@njit(cache=True)
def _cylinder_on_triangle(
    step: float,
    n: int,
    s: int,
    t: int,
    body: int,
    bodies: Array,
    scene: Scene,
    contacts: Array,
    owners: Array,
    work: Array,
) -> int:
    """Contacts of a cylinder with a triangle that it is in front of; the number of all then.

    The direction of the least overlap is the normal; points are those of the cylinder's line, or of
    the triangle below its disc.
    """
    corners, normal = scene.triangles[t], scene.slopes[t, P_PLANE : P_PLANE + 3]
    solid, points = scene.solids[scene.solid_of[s]], np.empty((16, 4))
    centre, turn = solid[B_CENTRE : B_CENTRE + 3], solid[B_ROTATION : B_ROTATION + 9]
    cylinder, best, ends = np.empty(5), np.empty(6), np.empty((2, 3))
    hull, edges, axis = np.empty((16, 3)), np.empty((3, 3)), np.empty(3)
    for k in range(3):
        cylinder[k] = turn[3 * k + 2]
        for i in range(3):
            hull[i, k] = corners[3 * i + k] - centre[k]
    cylinder[3], cylinder[4] = solid[B_HALF], solid[B_HALF + 1]
    best[0] = INFINITE
    if not _try_axis(-normal[0], -normal[1], -normal[2], hull, 3, cylinder, best):
        return n
    for i in range(3):
        for k in range(3):
            edges[i, k] = hull[(i + 1) % 3, k] - hull[i, k]
        _cross(cylinder[:3], edges[i], axis)
        if not _try_axis(axis[0], axis[1], axis[2], hull, 3, cylinder, best):
            return n
    for i in range(3):  # across the cylinder's axis, towards a corner
        along = 0.0
        for k in range(3):
            along += hull[i, k] * cylinder[k]
        for k in range(3):
            axis[k] = along * cylinder[k] - hull[i, k]
        if not _try_axis(axis[0], axis[1], axis[2], hull, 3, cylinder, best):
            return n
    if not _try_axis(cylinder[0], cylinder[1], cylinder[2], hull, 3, cylinder, best):
        return n
    for side in range(2):
        end = cylinder[4] if side == 0 else -cylinder[4]
        for i in range(3):
            if not _try_rims(hull[i], hull[(i + 1) % 3], hull, 3, cylinder, best, end):
                return n
    cosine = 0.0
    for k in range(3):
        cosine += cylinder[k] * best[3 + k]
    if abs(cosine) >= _STANDING:
        count = _disc_points(hull, 3, turn, cylinder, best, np.empty((16, 3)))
        count = _hull_points(hull, count, False, centre, best, points)
        return _add_points(step, n, points, count, best[3:], -1.0, s, body, scene.slopes, t,
                           scene.meshes[t], bodies, scene, contacts, owners, work)  # fmt: skip
    if not _side_line(best, cylinder, ends):
        return n
    distance = 0.0
    for k in range(3):
        distance += normal[k] * hull[0, k]
    if not _clip_line(-normal[0], -normal[1], -normal[2], distance, ends):
        return n
    for i in range(3):
        _cross(normal, edges[i], axis)
        distance = 1e-5
        for k in range(3):
            distance -= axis[k] * hull[i, k]
        if not _clip_line(axis[0], axis[1], axis[2], distance, ends):
            return n
    count = _hull_points(ends, 2, True, centre, best, points)
    return _add_points(step, n, points, count, best[3:], -1.0, s, body, scene.slopes, t,
                       scene.meshes[t], bodies, scene, contacts, owners, work)  # fmt: skip


@njit(cache=True)
def _cylinder_with_box(round_: Array, solid: Array, points: Array, normal: Array) -> int:
    """Contacts of a cylinder with a box, as _cylinder_on_triangle(): points (16, 4) and the normal
    towards the cylinder; their number."""
    centre, turn = round_[B_CENTRE : B_CENTRE + 3], round_[B_ROTATION : B_ROTATION + 9]
    cylinder, best, ends = np.empty(5), np.empty(6), np.empty((2, 3))
    hull, middle, axis, local = np.empty((16, 3)), np.empty(3), np.empty(3), np.empty(3)
    for k in range(3):
        cylinder[k] = turn[3 * k + 2]
        middle[k] = solid[B_CENTRE + k] - centre[k]
    cylinder[3], cylinder[4] = round_[B_HALF], round_[B_HALF + 1]
    for i in range(8):
        for k in range(3):
            hull[i, k] = middle[k]
            for j in range(3):
                sign = 1.0 if (i >> j) & 1 else -1.0
                hull[i, k] += sign * solid[B_HALF + j] * solid[B_ROTATION + 3 * k + j]
    best[0], face = INFINITE, 0
    for j in range(3):
        least = best[0]
        if not _try_axis(solid[B_ROTATION + j], solid[B_ROTATION + 3 + j],
                         solid[B_ROTATION + 6 + j], hull, 8, cylinder, best):  # fmt: skip
            return 0
        if best[0] < least:
            face = j
    # above the middle of a face no other direction has less overlap
    reach, inside = math.hypot(cylinder[3], cylinder[4]), True
    for j in range(3):
        local[j] = 0.0
        for k in range(3):
            local[j] += middle[k] * solid[B_ROTATION + 3 * k + j]
        if j != face and abs(local[j]) + reach > solid[B_HALF + j]:
            inside = False
    if not inside and not _try_other_axes(hull, solid, cylinder, best):
        return 0
    cosine = 0.0
    for k in range(3):
        cosine += cylinder[k] * best[3 + k]
    for k in range(3):
        normal[k] = -best[3 + k]
    if abs(cosine) >= _STANDING:
        count = _face_of(solid, middle, best, hull)
        count = _disc_points(hull, count, turn, cylinder, best, np.empty((16, 3)))
        return _hull_points(hull, count, False, centre, best, points)
    if not _side_line(best, cylinder, ends):
        return 0
    for side in range(2):
        sign = 1.0 if side == 0 else -1.0
        for j in range(3):
            for k in range(3):
                axis[k] = sign * solid[B_ROTATION + 3 * k + j]
            distance = solid[B_HALF + j] + sign * local[j]
            if not _clip_line(-axis[0], -axis[1], -axis[2], distance, ends):
                return 0
    return _hull_points(ends, 2, True, centre, best, points)


@njit(cache=True)
def _try_other_axes(hull: Array, solid: Array, cylinder: Array, best: Array) -> bool:
    """Whether a cylinder and a box overlap along all directions but those across its faces."""
    axis, side = np.empty(3), np.empty(3)
    if not _try_axis(cylinder[0], cylinder[1], cylinder[2], hull, 8, cylinder, best):
        return False
    for j in range(3):
        for k in range(3):
            side[k] = solid[B_ROTATION + 3 * k + j]
        _cross(cylinder[:3], side, axis)
        if not _try_axis(axis[0], axis[1], axis[2], hull, 8, cylinder, best):
            return False
    for i in range(8):
        along = 0.0
        for k in range(3):
            along += hull[i, k] * cylinder[k]
        for k in range(3):
            axis[k] = along * cylinder[k] - hull[i, k]
        if not _try_axis(axis[0], axis[1], axis[2], hull, 8, cylinder, best):
            return False
    for rim in range(2):
        end = cylinder[4] if rim == 0 else -cylinder[4]
        for i in range(8):
            for j in range(3):
                other = i | 1 << j
                if other != i and not _try_rims(hull[i], hull[other], hull, 8, cylinder, best, end):
                    return False
    return True


@njit(cache=True)
def _face_of(solid: Array, middle: Array, best: Array, hull: Array) -> int:
    """Corners of the face of a box that is the closest along a direction; their number."""
    most, face, sign = -1.0, 0, 1.0
    for j in range(3):
        along = 0.0
        for k in range(3):
            along += best[3 + k] * solid[B_ROTATION + 3 * k + j]
        if abs(along) > most:
            most, face, sign = abs(along), j, -1.0 if along > 0.0 else 1.0
    one, two = (face + 1) % 3, (face + 2) % 3
    for i in range(4):
        first = 1.0 if i in (0, 3) else -1.0
        second = 1.0 if i >= 2 else -1.0
        for k in range(3):
            row = B_ROTATION + 3 * k
            hull[i, k] = middle[k] + sign * solid[B_HALF + face] * solid[row + face]
            hull[i, k] += first * solid[B_HALF + one] * solid[row + one]
            hull[i, k] += second * solid[B_HALF + two] * solid[row + two]
    return 4


@njit(cache=True)
def _sphere_on_triangle(
    step: float,
    n: int,
    s: int,
    t: int,
    body: int,
    bodies: Array,
    scene: Scene,
    contacts: Array,
    owners: Array,
    work: Array,
) -> int:
    """Contact of a sphere with a triangle that it is in front of; the number of all then."""
    radius, normal, point = scene.shapes[s, G_SIZE], scene.slopes[t], np.empty(3)
    centre = scene.solids[scene.solid_of[s], B_CENTRE : B_CENTRE + 3]
    _closest(centre, scene.triangles[t], point)
    distance = along = 0.0
    for k in range(3):
        gap = centre[k] - point[k]
        distance += gap * gap
        along += gap * normal[k]
    distance = math.sqrt(distance)
    if distance > radius or distance == 0.0 or along < 0.0:
        return n
    depth = (radius - distance) * (along / distance)
    _add_contact(step, n, contacts, owners, bodies, scene.shapes, s, scene.slopes, t, body, point,
                 depth, work)  # fmt: skip
    owners[n, 2], owners[n, 3] = -1, scene.meshes[t]
    return n + 1


@njit(cache=True)
def _sphere_with_box(ball: Array, solid: Array, points: Array, normal: Array) -> int:
    """Contact of a sphere with a box, as _cylinder_with_box()."""
    centre, radius, local = ball[B_CENTRE : B_CENTRE + 3], ball[B_HALF], np.empty(3)
    is_outside, least, face = False, INFINITE, 0
    for j in range(3):
        local[j] = 0.0
        for k in range(3):
            local[j] += (centre[k] - solid[B_CENTRE + k]) * solid[B_ROTATION + 3 * k + j]
        half = solid[B_HALF + j]
        if half - abs(local[j]) < least:
            least, face = half - abs(local[j]), j
        if abs(local[j]) > half:
            local[j] = half if local[j] > 0.0 else -half
            is_outside = True
    if is_outside:
        distance = 0.0
        for k in range(3):
            points[0, k] = solid[B_CENTRE + k]
            for j in range(3):
                points[0, k] += solid[B_ROTATION + 3 * k + j] * local[j]
            normal[k] = centre[k] - points[0, k]
            distance += normal[k] * normal[k]
        distance = math.sqrt(distance)
        points[0, 3] = radius - distance
        if points[0, 3] < 0.0 or distance == 0.0:
            return 0
        for k in range(3):
            normal[k] /= distance
    else:
        points[0, 3] = least + radius
        for k in range(3):
            points[0, k] = centre[k]
            side = solid[B_ROTATION + 3 * k + face]
            normal[k] = side if local[face] > 0.0 else -side
    return 1


@njit(cache=True)
def _sphere_with_sphere(one: Array, two: Array, points: Array, normal: Array) -> int:
    """Contact of two spheres, halfway between their surfaces, as _cylinder_with_box()."""
    distance = 0.0
    for k in range(3):
        normal[k] = one[B_CENTRE + k] - two[B_CENTRE + k]
        distance += normal[k] * normal[k]
    distance = math.sqrt(distance)
    points[0, 3] = one[B_HALF] + two[B_HALF] - distance
    if points[0, 3] < 0.0:
        return 0
    if distance <= 0.0:
        normal[0], distance = 1.0, 1.0
    for k in range(3):
        normal[k] /= distance
        points[0, k] = one[B_CENTRE + k]
        points[0, k] += normal[k] * 0.5 * (two[B_HALF] - one[B_HALF] - distance)
    return 1


@njit(cache=True)
def _cylinder_with_sphere(round_: Array, ball: Array, points: Array, normal: Array) -> int:
    """Contact of a cylinder with a sphere: on its side, a disc or a rim."""
    radius, length, reach = round_[B_HALF], 2.0 * round_[B_HALF + 1], ball[B_HALF]
    axis, across = np.empty(3), np.empty(3)
    along, away = 0.5 * length, 0.0  # of the sphere's centre: from the first disc, from the axis
    for k in range(3):
        axis[k] = round_[B_ROTATION + 3 * k + 2]
        along += (ball[B_CENTRE + k] - round_[B_CENTRE + k]) * axis[k]
    for k in range(3):
        across[k] = round_[B_CENTRE + k] + (along - 0.5 * length) * axis[k] - ball[B_CENTRE + k]
        away += across[k] * across[k]
    away = math.sqrt(away)
    if along < -reach or along > length + reach or away > radius + reach:
        return 0
    if away > radius and (along < 0.0 or along > length):
        beyond = along if along <= 0.0 else along - length
        distance = math.hypot(beyond, away - radius)
        points[0, 3] = reach - distance
        if points[0, 3] < 0.0:
            return 0
        for k in range(3):
            points[0, k] = round_[B_CENTRE + k] - across[k] / away * radius
            points[0, k] += axis[k] * (-0.5 * length if along <= 0.0 else 0.5 * length)
            normal[k] = (points[0, k] - ball[B_CENTRE + k]) / distance
        return 1
    if radius - away <= along and radius - away <= length - along:
        points[0, 3] = reach + radius - away
        for k in range(3):
            normal[k] = across[k] / away
            way = normal[k] * reach if away > reach + _PARALLEL else across[k]
            points[0, k] = ball[B_CENTRE + k] + way
        return 1
    sign = 1.0 if along <= 0.5 * length else -1.0
    points[0, 3] = reach + (along if sign > 0.0 else length - along)
    if points[0, 3] < 0.0:
        return 0
    for k in range(3):
        normal[k] = sign * axis[k]
        points[0, k] = ball[B_CENTRE + k] + normal[k] * reach
    return 1


@njit(cache=True)
def _support(one: Array, two: Array, direction: Array, vertex: Array) -> None:
    """The farthest point of the Minkowski difference of two cylinders along a direction.

    Args:
        vertex: (9,) gets it, and the points of both cylinders that it is the difference of.
    """
    local = np.empty(3)
    for i in range(2):
        body, sign = (one, 1.0) if i == 0 else (two, -1.0)
        for j in range(3):
            local[j] = 0.0
            for k in range(3):
                local[j] += sign * direction[k] * body[B_ROTATION + 3 * k + j]
        flat = math.sqrt(local[0] * local[0] + local[1] * local[1])
        scale = 0.0 if flat < _EPSILON else body[B_HALF] / flat
        x, y = scale * local[0], scale * local[1]
        z = 0.0 if abs(local[2]) < _EPSILON else body[B_HALF + 1]
        z = -z if local[2] < 0.0 else z
        for k in range(3):
            row = B_ROTATION + 3 * k
            vertex[3 + 3 * i + k] = body[B_CENTRE + k]
            vertex[3 + 3 * i + k] += body[row] * x + body[row + 1] * y + body[row + 2] * z
    for k in range(3):
        vertex[k] = vertex[3 + k] - vertex[6 + k]


@njit(cache=True)
def _dot(a: Array, b: Array) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@njit(cache=True)
def _normalize(a: Array) -> None:
    length = math.sqrt(_dot(a, a))
    for k in range(3):
        a[k] /= length


@njit(cache=True)
def _portal_direction(portal: Array, direction: Array) -> None:
    """Unit vector across the portal's face, away from its inner point."""
    first, second = np.empty(3), np.empty(3)
    for k in range(3):
        first[k] = portal[2, k] - portal[1, k]
        second[k] = portal[3, k] - portal[1, k]
    _cross(first, second, direction)
    _normalize(direction)


@njit(cache=True)
def _expand_portal(portal: Array, vertex: Array) -> None:
    """Replace that corner of the portal's face behind which the ray to the origin does not pass."""
    across = np.empty(3)
    _cross(vertex[:3], portal[0, :3], across)
    if _dot(portal[1], across) > 0.0:
        place = 1 if _dot(portal[2], across) > 0.0 else 3
    else:
        place = 2 if _dot(portal[3], across) > 0.0 else 1
    portal[place] = vertex


@njit(cache=True)
def _is_at_surface(portal: Array, vertex: Array, direction: Array) -> bool:
    """Whether a farther point along a direction is not farther than the portal's face."""
    nearest = INFINITE
    for i in range(1, 4):
        nearest = min(nearest, _dot(vertex, direction) - _dot(portal[i], direction))
    return nearest <= MPR_TOLERANCE


@njit(cache=True)
def _find_portal(one: Array, two: Array, portal: Array) -> int:
    """A tetrahedron in the Minkowski difference of two cylinders, from its inner point (row 0)
    with a face that the ray to the origin passes.

    Returns:
        0; 1: the origin is on the line from the inner point to row 1; -1: they are apart.
    """
    direction, first, second = np.empty(3), np.empty(3), np.empty(3)
    for k in range(3):
        portal[0, 3 + k], portal[0, 6 + k] = one[B_CENTRE + k], two[B_CENTRE + k]
        portal[0, k] = one[B_CENTRE + k] - two[B_CENTRE + k]
    if abs(portal[0, 0]) + abs(portal[0, 1]) + abs(portal[0, 2]) < _EPSILON:
        portal[0, 0] += 10.0 * _EPSILON
    for k in range(3):
        direction[k] = -portal[0, k]
    _normalize(direction)
    _support(one, two, direction, portal[1])
    if _dot(portal[1], direction) < _EPSILON:
        return -1
    _cross(portal[0, :3], portal[1, :3], direction)
    if _dot(direction, direction) < _EPSILON:
        return 1
    _normalize(direction)
    _support(one, two, direction, portal[2])
    if _dot(portal[2], direction) < _EPSILON:
        return -1
    for k in range(3):
        first[k], second[k] = portal[1, k] - portal[0, k], portal[2, k] - portal[0, k]
    _cross(first, second, direction)
    _normalize(direction)
    if _dot(direction, portal[0]) > 0.0:
        for k in range(9):
            portal[1, k], portal[2, k] = portal[2, k], portal[1, k]
        for k in range(3):
            direction[k] = -direction[k]
    for _ in range(MPR_ITERATIONS):
        _support(one, two, direction, portal[3])
        if _dot(portal[3], direction) < _EPSILON:
            return -1
        _cross(portal[1, :3], portal[3, :3], first)
        replaced = 2 if _dot(first, portal[0]) <= -_EPSILON else 0
        if replaced == 0:
            _cross(portal[3, :3], portal[2, :3], first)
            replaced = 1 if _dot(first, portal[0]) <= -_EPSILON else 0
        if replaced == 0:
            return 0
        portal[replaced] = portal[3]
        for k in range(3):
            first[k], second[k] = portal[1, k] - portal[0, k], portal[2, k] - portal[0, k]
        _cross(first, second, direction)
        _normalize(direction)
    return -1


@njit(cache=True)
def _cylinder_with_cylinder(one: Array, two: Array, points: Array, normal: Array) -> int:
    """Contact of two cylinders by Minkowski portal refinement, as _cylinder_with_box().

    Source: G. Snethen, "XenoCollide" (Game Programming Gems 7, 2008), with the tolerances of
    libccd, which ODE asks.
    """
    portal, vertex, direction = np.empty((4, 9)), np.empty(9), np.empty(3)
    corners, weights = np.empty(9), np.empty(4)
    found = _find_portal(one, two, portal)
    if found < 0:
        return 0
    if found == 1:  # the deepest point is known
        depth = math.sqrt(_dot(portal[1], portal[1]))
        for k in range(3):
            points[0, k] = 0.5 * (portal[1, 3 + k] + portal[1, 6 + k])
            normal[k] = -portal[1, k] / depth if depth > 0.0 else 0.0
        points[0, 3] = depth
        return 1
    is_inside = False
    for _ in range(2 * MPR_ITERATIONS):
        _portal_direction(portal, direction)
        is_inside = is_inside or _dot(direction, portal[1]) > -_EPSILON
        _support(one, two, direction, vertex)
        if not is_inside and _dot(vertex, direction) < -_EPSILON:
            return 0
        if _is_at_surface(portal, vertex, direction):
            break
        _expand_portal(portal, vertex)
    if not is_inside:
        return 0
    for i in range(3):
        corners[3 * i : 3 * i + 3] = portal[1 + i, :3]
    origin = np.zeros(3)
    _closest(origin, corners, vertex[:3])
    points[0, 3] = math.sqrt(_dot(vertex, vertex))
    for k in range(3):
        normal[k] = -vertex[k] / points[0, 3] if points[0, 3] >= _EPSILON else 0.0
    _portal_weights(portal, direction, weights)
    for k in range(3):
        points[0, k] = 0.0
        for i in range(4):
            points[0, k] += 0.5 * weights[i] * (portal[i, 3 + k] + portal[i, 6 + k])
    return 1


@njit(cache=True)
def _portal_weights(portal: Array, direction: Array, weights: Array) -> None:
    """Barycentric coordinates (4,) of the origin in the portal."""
    across = np.empty(3)
    for i, (a, b, c) in enumerate(((1, 2, 3), (3, 2, 0), (0, 1, 3), (2, 1, 0))):
        _cross(portal[a, :3], portal[b, :3], across)
        weights[i] = _dot(across, portal[c])
    total = weights[0] + weights[1] + weights[2] + weights[3]
    if total < _EPSILON:
        weights[0] = 0.0
        for i, (a, b) in enumerate(((2, 3), (3, 1), (1, 2))):
            _cross(portal[a, :3], portal[b, :3], across)
            weights[1 + i] = _dot(across, direction)
        total = weights[1] + weights[2] + weights[3]
    for i in range(4):
        weights[i] /= total


@njit(cache=True)
def _box_overlap(one: Array, two: Array, margin: float, found: Array) -> int:
    """The direction in which two solids overlap least, of 15; its number, -1 if they do not.

    Source: Gottschalk et al., "OBBTree" (1996). Edges count as in ODE only if they overlap 5 %
    less than faces do.

    Args:
        margin: added to the cosines between their edges, so that no rounding parts them.
        found: (4,) gets the direction, from the first to the second, and the overlap [m].

    Returns:
        0 to 2 for a face of the first, 3 to 5 of the second, 6 + 3 i + j for the edges i and j.
    """
    gap, r, q, axis = np.empty(3), np.empty((3, 3)), np.empty((3, 3)), np.empty(3)
    most, code, sign = -INFINITE, -1, 1.0
    for i in range(3):
        gap[i] = 0.0
        for k in range(3):
            away = two[B_CENTRE + k] - one[B_CENTRE + k]
            gap[i] += one[B_ROTATION + 3 * k + i] * away
        for j in range(3):
            r[i, j] = 0.0
            for k in range(3):
                r[i, j] += one[B_ROTATION + 3 * k + i] * two[B_ROTATION + 3 * k + j]
            q[i, j] = abs(r[i, j]) + margin
    for i in range(3):
        over = abs(gap[i]) - one[i] - two[0] * q[i, 0] - two[1] * q[i, 1] - two[2] * q[i, 2]
        if over > 0.0:
            return -1
        if over > most:
            most, code, sign = over, i, -1.0 if gap[i] < 0.0 else 1.0
    for j in range(3):
        along = 0.0
        for k in range(3):
            away = two[B_CENTRE + k] - one[B_CENTRE + k]
            along += two[B_ROTATION + 3 * k + j] * away
        over = abs(along) - two[j] - one[0] * q[0, j] - one[1] * q[1, j] - one[2] * q[2, j]
        if over > 0.0:
            return -1
        if over > most:
            most, code, sign = over, 3 + j, -1.0 if along < 0.0 else 1.0
    for i in range(3):
        i1, i2 = (i + 1) % 3, (i + 2) % 3
        for j in range(3):
            j1, j2 = (j + 1) % 3, (j + 2) % 3
            along = gap[i2] * r[i1, j] - gap[i1] * r[i2, j]
            over = abs(along) - one[i1] * q[i2, j] - one[i2] * q[i1, j]
            over -= two[j1] * q[i, j2] + two[j2] * q[i, j1]
            if over > 0.0:
                return -1
            length = math.sqrt(r[i1, j] * r[i1, j] + r[i2, j] * r[i2, j])
            if length > 0.0 and over / length * EDGE_FACTOR > most:
                most, code, sign = over / length, 6 + 3 * i + j, -1.0 if along < 0.0 else 1.0
                axis[i], axis[i1], axis[i2] = 0.0, -r[i2, j] / length, r[i1, j] / length
    for k in range(3):
        if code < 3:
            found[k] = sign * one[B_ROTATION + 3 * k + code]
        elif code < 6:
            found[k] = sign * two[B_ROTATION + 3 * k + code - 3]
        else:
            _rotate(one[B_ROTATION : B_ROTATION + 9], axis, found)
    if code >= 6:
        for k in range(3):
            found[k] *= sign
    found[3] = -most
    return code


@njit(cache=True)
def _edge_point(one: Array, two: Array, code: int, found: Array, points: Array) -> None:
    """Where two edges of solids are closest to each other, in the middle; its depth."""
    a, b, gap = np.empty(3), np.empty(3), np.empty(3)
    i, j = (code - 6) // 3, (code - 6) % 3
    cosine = first = second = 0.0
    for k in range(3):
        a[k], b[k] = one[B_CENTRE + k], two[B_CENTRE + k]
    for side in range(3):
        along = across = 0.0
        for k in range(3):
            along += found[k] * one[B_ROTATION + 3 * k + side]
            across += found[k] * two[B_ROTATION + 3 * k + side]
        for k in range(3):
            reach = one[side] if along > 0.0 else -one[side]
            a[k] += reach * one[B_ROTATION + 3 * k + side]
            reach = -two[side] if across > 0.0 else two[side]
            b[k] += reach * two[B_ROTATION + 3 * k + side]
    for k in range(3):
        gap[k] = b[k] - a[k]
        u, v = one[B_ROTATION + 3 * k + i], two[B_ROTATION + 3 * k + j]
        cosine += u * v
        first += u * gap[k]
        second -= v * gap[k]
    rest = 1.0 - cosine * cosine
    alpha = beta = 0.0
    if rest > 1e-4:
        alpha, beta = (first + cosine * second) / rest, (cosine * first + second) / rest
    for k in range(3):
        a[k] += alpha * one[B_ROTATION + 3 * k + i]
        b[k] += beta * two[B_ROTATION + 3 * k + j]
        points[0, k] = 0.5 * (a[k] + b[k])
    points[0, 3] = found[3]


@njit(cache=True)
def _clip_to_face(polygon: Array, reach: Array) -> int:
    """Corners of the part of a quadrilateral (16, 2) in a rectangle of half the edges `reach`;
    their number. They begin and go around as ODE's."""
    count, out = 4, np.empty((16, 2))
    for along in range(2):
        for side in range(2):
            sign, n = -1.0 if side == 0 else 1.0, 0
            for i in range(count):
                p, q = polygon[i], polygon[(i + 1) % count]
                is_inside = sign * p[along] < reach[along]
                if is_inside:
                    out[n] = p
                    n += 1
                if is_inside != (sign * q[along] < reach[along]):
                    slope = (q[1 - along] - p[1 - along]) / (q[along] - p[along])
                    out[n, 1 - along] = p[1 - along] + slope * (sign * reach[along] - p[along])
                    out[n, along] = sign * reach[along]
                    n += 1
            count = n
            for i in range(count):
                polygon[i] = out[i]
    return count


@njit(cache=True)
def _face_points(one: Array, two: Array, found: Array, face: int, points: Array) -> int:
    """Points of the second solid's face that are in the first one, within its face; their number.

    Args:
        found: direction across the first's face, from the first to the second.
        points: (16, 4) get the points and their depths.
    """
    polygon, reach, middle = np.empty((16, 2)), np.empty(2), np.empty(3)
    c, m = np.zeros(2), np.zeros((2, 2))
    sides = (1 if face == 0 else 0, 1 if face == 2 else 2)
    most, other, sign = -1.0, 0, 1.0
    for j in range(3):
        along = 0.0
        for k in range(3):
            along += found[k] * two[B_ROTATION + 3 * k + j]
        if abs(along) > most:
            most, other, sign = abs(along), j, 1.0 if along < 0.0 else -1.0
    a1, a2 = 1 if other == 0 else 0, 1 if other == 2 else 2
    for k in range(3):
        middle[k] = two[B_CENTRE + k] - one[B_CENTRE + k]
        middle[k] += sign * two[other] * two[B_ROTATION + 3 * k + other]
    for i in range(2):
        reach[i] = one[sides[i]]
        for k in range(3):
            axis = one[B_ROTATION + 3 * k + sides[i]]
            c[i] += middle[k] * axis
            m[i, 0] += axis * two[B_ROTATION + 3 * k + a1]
            m[i, 1] += axis * two[B_ROTATION + 3 * k + a2]
    for i in range(4):
        first = -two[a1] if i < 2 else two[a1]
        second = two[a2] if i in (1, 2) else -two[a2]
        for k in range(2):
            polygon[i, k] = c[k] + first * m[k, 0] + second * m[k, 1]
    count, n = _clip_to_face(polygon, reach), 0
    determinant = m[0, 0] * m[1, 1] - m[0, 1] * m[1, 0]
    for i in range(count):
        x, y = polygon[i, 0] - c[0], polygon[i, 1] - c[1]
        first = (m[1, 1] * x - m[0, 1] * y) / determinant
        second = (m[0, 0] * y - m[1, 0] * x) / determinant
        depth = one[face]
        for k in range(3):
            row = B_ROTATION + 3 * k
            points[n, k] = middle[k] + first * two[row + a1] + second * two[row + a2]
            depth -= found[k] * points[n, k]
            points[n, k] += one[B_CENTRE + k]
        points[n, 3] = depth
        if depth >= 0.0:
            n += 1
    return n


@njit(cache=True)
def _box_with_box(one: Array, two: Array, points: Array, normal: Array) -> int:
    """Contacts of two boxes: where edges meet, or corners of a face in the other's face, as
    _cylinder_with_box()."""
    found = np.empty(4)
    code = _box_overlap(one, two, 0.0, found)
    for k in range(3):
        normal[k] = -found[k]
    if code < 0:
        return 0
    if code >= 6:
        _edge_point(one, two, code, found, points)
        return 1
    if code < 3:
        return _face_points(one, two, found, code, points)
    return _face_points(two, one, normal, code - 3, points)


@njit(cache=True)
def _solid_contacts(
    step: float,
    n: int,
    s: int,
    b: int,
    body: int,
    bodies: Array,
    scene: Scene,
    contacts: Array,
    owners: Array,
    work: Array,
) -> int:
    """Contacts of a box, sphere or cylinder of a body with a solid; the number of all then."""
    a = scene.solid_of[s]
    one, two, kind, other = (
        scene.solids[a],
        scene.solids[b],
        scene.solid_kinds[a],
        scene.solid_kinds[b],
    )
    points, normal, sign = np.empty((16, 4)), np.empty(3), 1.0
    if kind == BOX and other != BOX or kind == SPHERE and other == CYLINDER:
        one, two, kind, other, sign = two, one, other, kind, -1.0
    if kind == BOX:
        count = _box_with_box(one, two, points, normal)
    elif kind == SPHERE:
        if other == BOX:
            count = _sphere_with_box(one, two, points, normal)
        else:
            count = _sphere_with_sphere(one, two, points, normal)
    elif other == BOX:
        count = _cylinder_with_box(one, two, points, normal)
    elif other == SPHERE:
        count = _cylinder_with_sphere(one, two, points, normal)
    else:
        sign = -1.0  # what was there first is the first, whose way to the contact differs
        count = _cylinder_with_cylinder(two, one, points, normal)
    return _add_points(step, n, points, count, normal, sign, s, body, scene.faces, b,
                       scene.boxes_of[b], bodies, scene, contacts, owners, work)  # fmt: skip


@njit(cache=True)
def _place_solids(bodies: Array, scene: Scene, work: Array) -> None:
    """Put the solids of bodies, and their directions of friction, where they are."""
    across = np.empty(3)
    for s in range(len(scene.solid_of)):
        b = scene.solid_of[s]
        if b < 0:
            continue
        body, shape = scene.kinds[s, 0], scene.shapes[s]
        turn, solid = work[body, W_R : W_R + 9], scene.solids[b]
        _rotate(turn, shape[G_OFFSET : G_OFFSET + 3], solid[B_CENTRE : B_CENTRE + 3])
        _rotate(shape[G_ROTATION : G_ROTATION + 9], shape[G_FDIR : G_FDIR + 3], across)
        _rotate(turn, across, scene.faces[b, P_FDIR : P_FDIR + 3])
        for i in range(3):
            solid[B_CENTRE + i] += bodies[body, POS + i]
            for j in range(3):
                total = 0.0
                for k in range(3):
                    total += turn[3 * i + k] * shape[G_ROTATION + 3 * k + j]
                solid[B_ROTATION + 3 * i + j] = total


@njit(cache=True)
def _pair_contacts(
    step: float,
    n: int,
    one: int,
    two: int,
    bodies: Array,
    scene: Scene,
    contacts: Array,
    owners: Array,
    work: Array,
) -> int:
    """Contacts of two bodies of boxes, spheres and cylinders; the number of all then."""
    for s in range(scene.firsts[one + 1] - 1, scene.firsts[one] - 1, -1):
        box = scene.around[s]
        for t in range(scene.firsts[two + 1] - 1, scene.firsts[two] - 1, -1):
            if n + 16 > len(contacts) or not _overlap(box[:3], box[3:], scene.around[t]):
                continue
            first = n
            n = _solid_contacts(step, n, s, scene.solid_of[t], one, bodies, scene, contacts, owners,
                                work)  # fmt: skip
            for i in range(first, n):
                owners[i, 1] = two
                contacts[i, C_MAX] = min(bodies[one, MAX_VEL], bodies[two, MAX_VEL])
                left = min(bodies[one, MIN_DEPTH], bodies[two, MIN_DEPTH])
                contacts[i, C_DEPTH] += bodies[one, MIN_DEPTH] - left
    return n


@njit(cache=True)
def _thin_out(first: int, n: int, contacts: Array, owners: Array) -> int:
    """Leave one, the deepest, of contacts at the same point, and MESH_CONTACTS of all from row
    `first` on: the first ones, and the deepest of the rest; the number of all contacts then."""
    kept = first
    for i in range(first, n):
        hidden = False
        for j in range(first, n):
            if j == i or j < i and j >= kept:
                continue
            same = True
            for k in range(6):
                if abs(contacts[i, C_POINT + k] - contacts[j, C_POINT + k]) >= _SAME:
                    same = False
            deeper = contacts[j, C_DEPTH] - contacts[i, C_DEPTH]
            if same and (deeper > 0.0 or deeper == 0.0 and j < i):
                hidden = True
        if hidden:
            continue
        if kept - first >= MESH_CONTACTS:
            last = first + MESH_CONTACTS - 1
            if contacts[i, C_DEPTH] > contacts[last, C_DEPTH]:
                contacts[last], owners[last] = contacts[i], owners[i]
            continue
        if kept != i:
            contacts[kept], owners[kept] = contacts[i], owners[i]
        kept += 1
    return kept


@njit(cache=True)
def _still_contacts(
    step: float,
    n: int,
    s: int,
    meshes: bool,
    centre: Array,
    body: int,
    bodies: Array,
    scene: Scene,
    contacts: Array,
    owners: Array,
    work: Array,
) -> int:
    """Contacts of a sphere, cylinder or box with meshes, or boxes, that never move; the number of
    all.

    A triangle counts only in front of it.
    """
    kind, low, high = scene.kinds[s, 1], scene.around[s, :3], scene.around[s, 3:]
    first, last_mesh = n, -1
    for i in range(len(scene.covers)):
        if not _overlap(low, high, scene.covers[i]):
            continue
        for at in range(i * COVERED, min((i + 1) * COVERED, len(scene.boxes))):
            found = scene.ranges[at, 0]
            if found == UNKNOWN or (found == TRIANGLES) != meshes:
                continue
            if found == MIXED and kind == BOX or scene.hosts[at] == scene.models[body]:
                continue
            if not _overlap(low, high, scene.boxes[at]):
                continue
            for t in range(scene.ranges[at, 1], scene.ranges[at, 2]):
                if n + 16 > len(contacts):
                    break
                if not meshes:
                    n = _solid_contacts(step, n, s, t, body, bodies, scene, contacts, owners,
                                        work)  # fmt: skip
                    continue
                height = -scene.slopes[t, P_PLANE + 3]
                for k in range(3):
                    height += scene.slopes[t, k] * centre[k]
                if height < 0.0:
                    continue
                if scene.meshes[t] != last_mesh:
                    n = _thin_out(first, n, contacts, owners) if kind == CYLINDER else n
                    first, last_mesh = n, scene.meshes[t]
                if kind == SPHERE:
                    n = _sphere_on_triangle(step, n, s, t, body, bodies, scene, contacts, owners,
                                            work)  # fmt: skip
                else:
                    n = _cylinder_on_triangle(step, n, s, t, body, bodies, scene, contacts,
                                              owners, work)  # fmt: skip
    if meshes and kind == CYLINDER:
        n = _thin_out(first, n, contacts, owners)
    return n


@njit(cache=True)
def _find_contacts(
    step: float,
    bodies: Array,
    sequence: Array,
    scene: Scene,
    contacts: Array,
    owners: Array,
    start: int,
    work: Array,
) -> int:
    """Contacts from row `start`; the number of all.

    With what never moves: of all shapes but OTHER with planes; of spheres and cylinders with boxes
    and meshes, of boxes with boxes. And of bodies that are close to each other, which come first.
    Their order is that of Gazebo: bodies as in the last step, of a body the last shape first, those
    of meshes after the others.
    """
    n = start
    shapes, kinds, planes = scene.shapes, scene.kinds, scene.planes
    centre, point = np.empty(3), np.empty(3)
    for i in range(scene.counts[0]):
        n = _pair_contacts(step, n, scene.close[i, 0], scene.close[i, 1], bodies, scene, contacts,
                           owners, work)  # fmt: skip
    for meshes in (False, True):
        for body in sequence:
            if bodies[body, ASLEEP] != 0.0:
                continue
            for s in range(scene.firsts[body + 1] - 1, scene.firsts[body] - 1, -1):
                kind = kinds[s, 1]
                if kind == OTHER:
                    continue
                _rotate(work[body, W_R : W_R + 9], shapes[s, G_OFFSET : G_OFFSET + 3], centre)
                for k in range(3):
                    centre[k] += bodies[body, POS + k]
                size = shapes[s, G_SIZE : G_SIZE + 3]
                for p in range(len(planes) if (kind == MESH) == meshes else 0):
                    if not scene.touches[s, p]:
                        continue
                    below = planes[p, P_PLANE + 3]
                    for k in range(3):
                        below -= planes[p, k] * (bodies[body, POS + k] if meshes else centre[k])
                    if below + bodies[body, RADIUS] < 0.0:
                        continue
                    if meshes:
                        n = _mesh_contacts(step, n, s, p, below, body, bodies, scene, contacts,
                                           owners, work)  # fmt: skip
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
                if scene.knows[s] == ALL or scene.knows[s] == SOLIDS and not meshes:
                    n = _still_contacts(step, n, s, meshes, centre, body, bodies, scene, contacts,
                                        owners, work)  # fmt: skip
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
def _overlap(low: Array, high: Array, box: Array) -> bool:
    """Whether a box overlaps one of six numbers: its lower and its upper corner."""
    for k in range(3):
        if low[k] > box[3 + k] or high[k] < box[k]:
            return False
    return True


@njit(cache=True)
def _place_boxes(b: int, bodies: Array, scene: Scene) -> None:
    """Boxes around a body's shapes where they are."""
    turn = np.empty(9)
    _matrix(bodies[b, QUAT : QUAT + 4], turn)
    for s in range(scene.firsts[b], scene.firsts[b + 1]):
        for i in range(3):
            middle, reach = bodies[b, POS + i], 0.0
            for k in range(3):
                middle += turn[3 * i + k] * scene.extents[s, k]
                reach += abs(turn[3 * i + k]) * scene.extents[s, 3 + k]
            scene.around[s, i], scene.around[s, 3 + i] = middle - reach, middle + reach


@njit(cache=True)
def _solid_around(s: int, body: Array, scene: Scene, solid: Array) -> None:
    """The box around a shape, turned with its body, as a row of solids."""
    turn = solid[B_ROTATION : B_ROTATION + 9]
    _matrix(body[QUAT : QUAT + 4], turn)
    _rotate(turn, scene.extents[s, :3], solid[B_CENTRE : B_CENTRE + 3])
    for k in range(3):
        solid[B_CENTRE + k] += body[POS + k]
        solid[B_HALF + k] = scene.extents[s, 3 + k]


@njit(cache=True)
def _is_near(bodies: Array, scene: Scene) -> bool:
    """Whether a body may touch what the caller finds the contacts of; notes what else is close."""
    found, count = False, 0
    for b in range(len(bodies)):
        if bodies[b, RADIUS] <= 0.0:
            continue
        _place_boxes(b, bodies, scene)
        if bodies[b, ASLEEP] != 0.0 or found:
            continue
        for s in range(scene.firsts[b], scene.firsts[b + 1]):
            box = scene.around[s]
            if _is_near_still(box[:3], box[3:], scene.knows[s], scene.models[b], scene):
                found = True
    for b in range(len(bodies)):
        for other in range(b):
            if bodies[b, ASLEEP] * bodies[other, ASLEEP] != 0.0 or scene.meet[b, other] == APART:
                continue
            distance = 0.0
            for k in range(3):
                gap = bodies[b, POS + k] - bodies[other, POS + k]
                distance += gap * gap
            reach = bodies[b, RADIUS] + bodies[other, RADIUS]
            if distance > reach * reach or not _may_touch(b, other, bodies, scene):
                continue
            if scene.meet[b, other] == LEFT:
                found = True
            elif count < len(scene.close):
                scene.close[count, 0], scene.close[count, 1] = b, other
                count += 1
    scene.counts[0] = count
    return found


@njit(cache=True)
def _may_touch(b: int, other: int, bodies: Array, scene: Scene) -> bool:
    """Whether boxes around shapes of two bodies, turned with them, overlap."""
    one, two, found = np.empty(B_COLUMNS), np.empty(B_COLUMNS), np.empty(4)
    for s in range(scene.firsts[b], scene.firsts[b + 1]):
        box = scene.around[s]
        for t in range(scene.firsts[other], scene.firsts[other + 1]):
            if _overlap(box[:3], box[3:], scene.around[t]):
                _solid_around(s, bodies[b], scene, one)
                _solid_around(t, bodies[other], scene, two)
                if _box_overlap(one, two, _PARALLEL, found) >= 0:
                    return True
    return False


@njit(cache=True)
def _is_near_still(low: Array, high: Array, knows: int, model: int, scene: Scene) -> bool:
    """Whether a box around a shape overlaps what never moves and the caller has to look at."""
    for i in range(len(scene.covers)):
        if not _overlap(low, high, scene.covers[i]):
            continue
        for at in range(i * COVERED, min((i + 1) * COVERED, len(scene.boxes))):
            found = scene.ranges[at, 0]
            if knows == ALL and found != UNKNOWN or knows == SOLIDS and found == SOLID:
                continue
            if scene.hosts[at] == model:
                continue
            if _overlap(low, high, scene.boxes[at]):
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
    scene: Scene,
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
        given: number of contacts, in the first rows, that the caller has found for the next step;
            -1: none were looked for, and it stops before a step for which they are needed.
        watch: whether there is something of which the caller finds the contacts.
        sleepy: whether there are bodies that may sleep.
        result: gets the number of contacts of the last step.

    Returns:
        Number of steps made; it also stops after a step in which a body has fallen asleep.
    """
    for done in range(count):
        if watch and _is_near(bodies, scene) and given < 0:
            return done
        _impose(step, bodies, joints, types, below)
        _prepare(gravity, bodies, joints, types, work)
        _place_solids(bodies, scene, work)
        n = _find_contacts(step, bodies, sequence, scene, contacts, owners, max(given, 0), work)
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
