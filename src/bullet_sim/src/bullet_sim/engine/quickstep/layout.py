"""Columns of the arrays of quickstep, its codes and its constants; used as `col.NAME`.

Columns of one quantity are named by their first: bodies[b, col.VEL : col.VEL + 3]. Units: m, kg, s,
rad; world axes if nothing else is said.
"""

# codes of joints and of shapes; of OTHER the caller finds the contacts, PLANE is one for rays alone
from __future__ import annotations

from bullet_sim.pose import Array

HINGE, SLIDER, FIXED, SCREW, GEARS = 0, 1, 2, 3, 4
SPHERE, CYLINDER, BOX, MESH, OTHER, PLANE, FIELD = range(7)
# what is done with two bodies: they never collide; collided here; collided by the caller
PAIR_FILTERED, PAIR_NATIVE, PAIR_EXTERNAL = range(3)

# bodies: center of mass, quaternion, linear and angular velocity, its place in the last step's
# order, time and steps for which it has to rest until it sleeps, whether it sleeps, mass, inertia
# and its inverse in the body's axes, whether gravity acts, bound of the push out of contacts, depth
# that is left, radius of a sphere around the shapes, whether it may sleep, external force and
# torque of the next step, fractions of the linear and angular velocity that it loses in a step
POS, QUAT, VEL, PLACE, REST, REST_STEPS, ASLEEP = 0, 3, 7, 13, 14, 15, 16
MASS, INERTIA, INVERSE, GRAVITY = 17, 18, 27, 36
MAX_VEL, MIN_DEPTH, RADIUS, MAY_SLEEP, FORCE, DECAY, B_SIZE = 37, 38, 39, 40, 41, 47, 49
# working values of bodies: rotation, inertia and inverse in world axes, force and torque, wanted
# accelerations, those of the solutions (of each axis both; in whole lines of the cache)
W_R, W_I, W_V, W_F, W_T, W_A, W_SIZE = 0, 9, 18, 27, 33, 40, 56
# joints: anchor in both bodies (from their centers; of the world: its coordinates), axis in both,
# quaternion of the first in the second at 0, limits, damping, the motor's effort and velocity,
# effort of the next step, position, velocity, commanded position and where it is by now, its
# speed, last impulses of both solutions, the motor's last effort, force and torque on the first
# body, whether damping is a constraint (else it is an effort of the last velocity), velocity that
# the first body is given before each step (NaN: none), ERP and CFM of the limits, how much of the
# motor's effort away from them acts there, stiffness of a spring and where it is at rest, ERP and
# CFM of its rows (negative: the world's), restitution at its limits, thread of a screw [rad/m] or
# ratio of gears
ANCHOR1, ANCHOR2, AXIS1, AXIS2, QREL, LOWER, UPPER, DAMPING = 0, 3, 6, 9, 12, 16, 17, 18
FMAX, SPEED, EFFORT, ANGLE, RATE, TARGET, REACHED, MAX_SPEED = 19, 20, 21, 22, 23, 24, 25, 26
WARM, WARM2, MOTOR, WRENCH, IMPLICIT, IMPOSED = 27, 34, 41, 42, 48, 49
STOP_ERP, STOP_CFM, STOP_PUSH, STIFFNESS, AT_REST, ERP, CFM, BOUNCE = 50, 51, 52, 53, 54, 55, 56, 57
PITCH, J_SIZE = 58, 59
# records of states: of bodies what comes before PLACE, then position, orientation and velocity of
# the link's frame; of joints ANGLE, RATE, MOTOR and WRENCH, of efforts what was applied (NaN: none)
SR_POS, SR_QUAT, SR_VEL, SR_BODY, SR_JOINT, SR_EFFORT = 13, 16, 20, 23, 9, 1
# of gears instead: row of the body that both rotate against (-1: the world), quaternion of the
# second body in it at 0 (that of the first is QREL), rotation of the second (of the first: ANGLE)
GEAR_BASE, GEAR_QREL, GEAR_ANGLE = 0, 1, 25
# shapes: size, center in the body (from its center of mass), rotation, mu, mu2, fdir1, kp, kd,
# slip1, slip2, restitution and from what speed on, torsional friction: coefficient, radius of the
# patch, of the surface, whether the patch's counts, slip; contacts of a pair at most
G_SIZE, G_OFFSET, G_ROTATION, G_MU, G_FDIR, G_KP, G_KD = 0, 3, 6, 15, 17, 20, 21
G_SLIP, G_BOUNCE, G_TORSION, G_PATCH, G_RADIUS, G_BY_PATCH, G_TWIST_SLIP, G_MOST, G_COLUMNS = (
    22, 24, 26, 27, 28, 29, 30, 31, 32,
)  # fmt: skip
# planes: normal, distance from the origin; as a shape's the rest
P_PLANE, P_MU, P_FDIR, P_KP, P_KD, P_SLIP = 0, 4, 6, 9, 10, 11
P_BOUNCE, P_TORSION, P_PATCH, P_RADIUS, P_BY_PATCH, P_TWIST_SLIP, P_MOST, P_COLUMNS = (
    13, 15, 16, 17, 18, 19, 20, 21,
)  # fmt: skip
# solids: half the edges, or radius and half the length; center; rotation
B_HALF, B_CENTER, B_ROTATION, B_COLUMNS = 0, 3, 6, 15
# spaces of shapes: place in ODE's order, level, lower and upper corner, number of shapes
K_RANK, K_LEVEL, K_LOW, K_HIGH, K_COUNT, K_COLUMNS = 0, 1, 2, 5, 8, 9
MIN_LEVEL, MAX_LEVEL = -2, 8  # of cells of 2^level m; what is larger is in none
# candidates for contacts of a mesh: point, normal, depth, weight of the normal
F_NORMAL, F_DEPTH, F_WEIGHT, F_COLUMNS = 3, 6, 7, 8
# heightmaps: size along x, along -y (ODE's z), between points of the grid [m]; points along both,
# the first height
FD_SIZE_X, FD_SIZE_Z, FD_STEP_X, FD_STEP_Z, FD_COUNT_X, FD_COUNT_Z, FD_FIRST, FD_COLUMNS = range(8)
# points of its grid near a shape: height, whether it needs no contact of its own; triangles: plane
# in the grid's frame, highest point, first point and in which direction the others are, whether it
# needs nothing more, the first triangle in the same plane, of such a one the plane's highest point
V_HEIGHT, V_DONE, V_COLUMNS = range(3)
T_TOP, T_X, T_Z, T_SIGN, T_DONE, T_PLANE, T_PLANE_TOP, T_COLUMNS = range(4, 12)
# contacts: point, normal towards the first body, depth, mu, mu2, fdir1 (world), erp, cfm, bound
# of the push, force on the first body, slip1 and slip2, restitution and from what speed on,
# torsional friction: coefficient (0: none), radius of the patch, of the surface (0: the patch's
# counts), slip
C_POINT, C_NORMAL, C_DEPTH, C_MU, C_FDIR, C_ERP, C_CFM, C_MAX, C_FORCE, C_SLIP, C_BOUNCE = (
    0, 3, 6, 7, 9, 12, 13, 14, 15, 18, 20,
)  # fmt: skip
C_TORSION, C_PATCH, C_RADIUS, C_TWIST_SLIP, C_SIZE = 22, 23, 24, 25, 26
# constraint rows: Jacobian of both bodies, inverse mass times it, right sides, relaxed CFM,
# bounds, impulses
R_J, R_M, R_RHS, R_RHS2, R_CFM, R_LOW, R_HIGH, R_L, R_L2, R_C, R_MAX, R_SIZE = (
    0, 12, 24, 25, 26, 27, 28, 29, 30, 31, 32, 33,
)  # fmt: skip
BILATERAL, UNILATERAL = -1, -2  # instead of the index of the normal's row
# blocks: where their numbers are, of the accelerations of both bodies, and of the impulses of the
# normal that bounds a friction (-1: none), whether there are a second body and a second row (of a
# contact) or a CFM (of a joint), how many blocks before it have to be solved one after the other
BLOCK_AT, BLOCK_ONE, BLOCK_TWO, BLOCK_NORMAL, BLOCK_BOTH, BLOCK_PAIR, BLOCK_LEVEL = range(7)
BLOCK_SIZE = 7
# numbers of a joint's block: six rows, each of the first five without bounds. Two rows in four
# lanes: of each of 12 columns the Jacobian, so three times; for each row 12 times inverse mass
# times it (twice, for both solutions); right sides, impulses; bounds of the last two; for each row
# what its impulse changes by its CFM, in all rows
JB_M, JB_RHS, JB_L, JB_LOW, JB_HIGH, JB_CFM, JB_SIZE = 144, 288, 300, 312, 316, 320, 392
# numbers of a contact's block: two rows
CB_M, CB_RHS, CB_L, CB_CFM, CB_LOW, CB_HIGH, CB_COUPLING, CB_SIZE = (
    48, 96, 100, 104, 108, 112, 116, 120,
)  # fmt: skip
WEIGHTS = 8  # numbers before the first block: of new and old impulses of contacts
BLOCK_ROWS, MAX_JOINT_ROWS = 6, 7  # of a joint's block; of a joint
MAX_CONTACT_ROWS = 4  # normal, two directions of friction, torsion
TORSION = 3.0 * 3.141592653589793 / 16.0  # its moment by radius, coefficient and normal force
# rows of efforts: number of the joint, limits of its velocity and effort in Gazebo (0: none), what
# a PID's errors are of and its target, the joint's limits and the way of position_error(), the
# PID's gains and bounds, what effort_bounds() takes, and the state
PID_JOINT, PID_TOP_SPEED, PID_TOP_EFFORT, PID_GOAL, PID_TARGET = range(5)
PID_LOWER, PID_UPPER, PID_WAY = range(5, 8)
PID_P, PID_I, PID_D, PID_LOW, PID_HIGH, PID_ANTIWINDUP = range(8, 14)
PID_LIMIT, PID_MIN, PID_MAX, PID_SPEED = range(14, 18)
PID_SOFT_MIN, PID_SOFT_MAX, PID_K_POSITION, PID_K_VELOCITY = range(18, 22)
PID_STATE = 22
PID_LAST, PID_INTEGRAL, PID_RATE, PID_BY_ERROR, PID_BY_INTEGRAL, PID_BY_RATE = range(22, 28)
PID_OUTPUT, PID_APPLIED, PID_SIZE = 28, 29, 30
GOAL_POSITION, GOAL_VELOCITY, GOAL_EFFORT = range(3)  # what errors are of; an effort, no PID
GOALS = {"position": GOAL_POSITION, "velocity": GOAL_VELOCITY, "": GOAL_EFFORT}
# bodies whose velocity is set between steps: row of the root link, the first row of bodies and that
# after the last, those of joints, velocity forward and to the left, yaw rate
HELD_ROOT, HELD_FIRST, HELD_END, HELD_JOINT, HELD_JOINT_END = range(5)
HELD_FORWARD, HELD_LEFT, HELD_TURN, HELD_SIZE = range(5, 9)
# contacts that are recorded: owners as those of a step, row of the body that they are told of, and
# whether it is the first of both
CR_BODY, CR_FIRST, CR_SIZE = 4, 5, 6
# settings of a world: relaxation, fraction of a joint's error that is corrected in a step, CFM of
# joints, whether the inertias of hinged bodies are moved closer to each other, largest velocity of
# a joint's rows
S_RELAXATION, S_ERP, S_CFM, S_RESCALE, S_MAX, S_SIZE = 0, 1, 2, 3, 4, 5

# groups of islands: the first row, the first place in the sequence of bodies, the first number of
# their blocks, the number of blocks before the first, up to the joints' last, the normals' last and
# the last
I_ROW, I_BODY, I_NUMBER, I_ENDS, I_SIZE = 0, 1, 2, 3, 6
GROUP_ROWS = 64  # at most, of a group of several islands: its blocks fit a processor's first cache
# what threads share: semaphore, whether steps are made, whether helpers end, how many there are,
# groups that nobody has taken, groups that are not solved; in a cache line each
T_SEMAPHORE, T_AWAKE, T_ENDED, T_HELPERS, T_OFFERED, T_UNDONE, T_SIZE = 0, 8, 16, 24, 32, 40, 48
SPINS = 100  # looks before others may have the processor

INFINITE = 1e300
EPSILON = 2.220446049250313e-16
# the iteration
FRICTION_SCALE = 0.25
FRICTION_ITERATIONS = 10
SMOOTHING = 0.01
WARM_START = 0.5
INERTIA_RATIO = 200.0  # above which inertias across a hinge are moved closer
# motion
DECAY_SPEED = 0.01  # [m/s, rad/s] up to which no velocity decays
REST_TIME, REST_COUNT = 1.0, 5  # [s], steps, for which what is slower than the next sleeps then
REST_SPEED = 0.1  # [m/s, rad/s]
FALLING = 2.0  # ASLEEP of a body in the step in which it has fallen asleep
# collision
MPR_TOLERANCE, MPR_ITERATIONS = 1e-6, 500  # of cylinders with cylinders
EDGE_FACTOR = 1.05  # by which edges of boxes have to overlap less than faces
MAX_CONTACTS = 10  # of a pair of shapes, sdformat's max_contacts of a collision
MAX_COLLIDE_RETURNS = 250  # of such a pair that are looked for, as in Gazebo
MAX_FIELD_RETURNS = 10  # of a plane of a heightmap, ODE's HEIGHTFIELDMAXCONTACTPERCELL
RAY_EPSILON = 1e-6  # volume below which OPCODE's ray is in a triangle's plane
FEW_SQUARES = 1.5  # of a heightmap, above which its points count for a larger shape
COPLANAR = 1e-6  # distance from a triangle's plane, times twice its area [m^3], that counts as 0
PARALLEL = 1e-7
STANDING = 0.9  # cosine between a cylinder's axis and a normal, above which its disc touches
SAME_CONTACT = 1e-4  # [m] between contacts that are one, and between their normals
AABB_GROUP = 32  # boxes of what never moves that one larger box is around
CHUNK = 32  # vertices of a mesh that follow each other
ROUNDING = 1e-9  # [m] by which two ways to compute a depth may differ
MAX_NEAR_BOXES = 64  # up to which the triangles of a mesh are compared with another mesh one by one
NO_CHILD = -(2**40)  # of a node with a single triangle


def softness(step: float, kp1: float, kd1: float, kp2: float, kd2: float) -> tuple[float, float]:
    """ERP and CFM of a contact of two surfaces: their springs kp [N/m] in series, kd [N s/m]."""
    kp = 1.0 / (1.0 / kp1 + 1.0 / kp2)
    kd = kd1 + kd2
    return step * kp / (step * kp + kd), 1.0 / (step * kp + kd)


def set_torsion(row: Array, shape: Array, plane: Array) -> None:
    """Torsional friction of a contact, of its surfaces' rows: the smaller coefficient, both slips
    and the larger patch, or the surfaces' radii in series where one of both says so."""
    row[C_TORSION] = min(shape[G_TORSION], plane[P_TORSION])
    row[C_PATCH] = max(shape[G_PATCH], plane[P_PATCH])
    row[C_RADIUS] = 0.0
    row[C_TWIST_SLIP] = shape[G_TWIST_SLIP] + plane[P_TWIST_SLIP]
    if shape[G_BY_PATCH] == 0.0 or plane[P_BY_PATCH] == 0.0:
        row[C_PATCH] = 0.0
        if shape[G_RADIUS] > 0.0 and plane[P_RADIUS] > 0.0:
            row[C_RADIUS] = 1.0 / (1.0 / shape[G_RADIUS] + 1.0 / plane[P_RADIUS])
