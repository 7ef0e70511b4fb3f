"""Columns of the arrays of quickstep, and what they are of.

Units: m, kg, s, rad; world axes if nothing else is said.
"""

from typing import NamedTuple

from bullet_sim.pose import Array

HINGE, SLIDER, FIXED = 0, 1, 2  # types of joints
SPHERE, CYLINDER, BOX, MESH, OTHER = range(5)  # types of shapes; of OTHER the caller finds contacts
# bodies: center of mass, quaternion, linear and angular velocity, its place in the last step's
# order, time and steps for which it has to rest until it sleeps, whether it sleeps, mass, inertia
# and its inverse in the body's axes, whether gravity acts, bound of the push out of contacts, depth
# that is left, radius of a sphere around the shapes, whether it may sleep, external force and
# torque of the next step, fractions of the linear and angular velocity that it loses in a step
POS, QUAT, VEL, PLACE, REST, REST_STEPS, ASLEEP = 0, 3, 7, 13, 14, 15, 16
MASS, INERTIA, INVERSE, GRAVITY = 17, 18, 27, 36
MAX_VEL, MIN_DEPTH, RADIUS, MAY_SLEEP, FORCE, DECAY, B_SIZE = 37, 38, 39, 40, 41, 47, 49
# joints: anchor in both bodies (from their centers; of the world: its coordinates), axis in both,
# quaternion of the first in the second at 0, limits, damping, the motor's effort and velocity,
# effort of the next step, position, velocity, commanded position and where it is by now, its
# speed, last impulses of both solutions, the motor's last effort, force and torque on the first
# body, whether damping is a constraint (else it is an effort of the last velocity), velocity that
# the first body is given before each step (NaN: none), ERP and CFM of the limits, how much of the
# motor's effort away from them acts there, stiffness of a spring and where it is at rest
ANCHOR1, ANCHOR2, AXIS1, AXIS2, QREL, LOWER, UPPER, DAMPING = 0, 3, 6, 9, 12, 16, 17, 18
FMAX, SPEED, EFFORT, ANGLE, RATE, TARGET, REACHED, MAX_SPEED = 19, 20, 21, 22, 23, 24, 25, 26
WARM, WARM2, MOTOR, WRENCH, IMPLICIT, IMPOSED = 27, 34, 41, 42, 48, 49
STOP_ERP, STOP_CFM, STOP_PUSH, STIFFNESS, AT_REST, J_SIZE = 50, 51, 52, 53, 54, 55
# shapes: size, center in the body (from its center of mass), rotation, mu, mu2, fdir1, kp, kd,
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
# working values of bodies: rotation, inertia and inverse in world axes, force and torque, wanted
# accelerations, those of the solutions (of each axis both)
W_R, W_I, W_V, W_F, W_T, W_A, W_SIZE = 0, 9, 18, 27, 33, 39, 51
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
EPSILON = 2.220446049250313e-16
EDGE_FACTOR = 1.05  # by which edges of boxes have to overlap less than faces
MESH_CONTACTS = 10  # of a pair with a mesh, sdformat's max_contacts of a collision
MOST_FOUND = 250  # of such a pair that are looked for
COPLANAR = 1e-6  # distance from a triangle's plane, times twice its area [m^3], that counts as 0
INERTIA_RATIO = 200.0  # above which inertias across a hinge are moved closer
DECAY_SPEED = 0.01  # [m/s, rad/s] up to which no velocity decays
REST_TIME, REST_COUNT = 1.0, 5  # [s], steps, for which what is slower than the next sleeps then
REST_SPEED = 0.1  # [m/s, rad/s]
PARALLEL = 1e-7
STANDING = 0.9  # cosine between a cylinder's axis and a normal, above which its disc touches
SAME = 1e-4  # [m] between contacts that are one, and between their normals
COVERED = 32  # boxes that one cover contains
CHUNK = 32  # vertices of a mesh that follow each other
ROUNDING = 1e-9  # [m] by which two ways to compute a depth may differ
APART, FOUND, LEFT = range(3)  # contacts of two bodies: none, found here, found by the caller
# solids: half the edges, or radius and half the length; center; rotation
B_HALF, B_CENTER, B_ROTATION, B_COLUMNS = 0, 3, 6, 15
# contacts of a mesh that are looked for: point, normal, depth, weight of the normal
F_NORMAL, F_DEPTH, F_WEIGHT, F_COLUMNS = 3, 6, 7, 8
NEAR_BOXES = 64  # up to which the triangles of a mesh are compared with another mesh one by one
NO_CHILD = -(2**40)  # of a node with a single triangle


class Tree(NamedTuple):
    """A mesh in its own frame, scaled.

    Attributes:
        corners: (t, 9) triangles [m] in the order of the tree.
        nodes: (k, 6) center and half the edges of boxes [m].
        children: (k, 2) numbers of nodes, or -1 - the number of a triangle; NO_CHILD: none.
        depth: how deep it is.
    """

    corners: Array
    nodes: Array
    children: Array
    depth: int


class Trees(NamedTuple):
    """The trees of all meshes after each other, and room to work with.

    Attributes:
        corners, nodes, children: as those of a Tree.
        depth: (1,) of the deepest.
        todo: (w, 3) room for what is still to be looked at, for 4 times that depth and 8.
        found: (MOST_FOUND, F_COLUMNS) room for contacts of a pair.
        parents: (t + k,) of each triangle, the last first, and of each box: t and the number of the
            box that it is in, or -1.
        marks: (t + k, 2) of these: the last call that had to look at them, in its first tree and in
            its second.
        calls: (1,) number of the call that marks.
        near: (NEAR_BOXES,) room for numbers of boxes.
    """

    corners: Array
    nodes: Array
    children: Array
    depth: Array
    todo: Array
    found: Array
    parents: Array
    marks: Array
    calls: Array
    near: Array


class Scene(NamedTuple):
    """Shapes of bodies, and what never moves.

    Attributes:
        shapes: (s, G_COLUMNS).
        kinds: (s, 5) body, type, first vertex and the one after the last, first row of chunks.
        firsts: (n + 1,) first shape of each body; those of a body follow each other.
        points: (v, 3) vertices of meshes, from their bodies' centers of mass.
        chunks: (c, 6) center and half the edges of boxes around CHUNK vertices each of a mesh.
        extents: (s, 6) center and half the edges of a box around each shape, in its body.
        models: (n,) number of each body's model.
        around: (s, 6) lower and upper corners of boxes around the shapes where they are.
        meet: (n, n) whether two bodies may touch: APART, FOUND (here), or LEFT to the caller.
        close: (c, 2) pairs of bodies that are close, whose contacts are found here.
        counts: (2,) number of these; and of boxes whose contacts the caller finds.
        pairs: (m, 3) shapes, with a row of solids, or -1 - that of a plane, and the body of which
            the solid is, or -1.
        planes: (p, P_COLUMNS).
        plane_bits: (p,) as bits.
        solids: (b, B_COLUMNS) shapes but planes and OTHER: those that never move, then of bodies.
        faces: (b, P_COLUMNS) their surfaces.
        owners: (b,) number of what never moves, for the contacts.
        solid_kinds: (b,) SPHERE, CYLINDER, BOX or MESH.
        solid_of: (s,) each shape's row of solids, -1 of OTHER.
        roots: (b,) of the trees of meshes, else -1.
        trees: meshes.
        boxes: (m, 6) lower and upper corners of boxes around what never moves, but for planes.
        contents: (m,) the solid in a box, -1: something of which the caller finds the contacts.
        hosts: (m, 2) model of each box, whose own bodies do not touch it, and its bits.
        bits: (s,) of shapes, which touch only what shares one.
        covers: (c, 6) boxes around COVERED of these each, in their order.
    """

    shapes: Array
    kinds: Array
    firsts: Array
    points: Array
    chunks: Array
    extents: Array
    models: Array
    around: Array
    meet: Array
    close: Array
    counts: Array
    pairs: Array
    planes: Array
    plane_bits: Array
    solids: Array
    faces: Array
    owners: Array
    solid_kinds: Array
    solid_of: Array
    roots: Array
    trees: Trees
    boxes: Array
    contents: Array
    hosts: Array
    bits: Array
    covers: Array


def softness(step: float, kp1: float, kd1: float, kp2: float, kd2: float) -> tuple[float, float]:
    """ERP and CFM of a contact of two surfaces: their springs kp [N/m] in series, kd [N s/m]."""
    kp = 1.0 / (1.0 / kp1 + 1.0 / kp2)
    kd = kd1 + kd2
    return step * kp / (step * kp + kd), 1.0 / (step * kp + kd)
