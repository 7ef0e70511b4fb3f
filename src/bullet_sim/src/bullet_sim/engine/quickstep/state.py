"""Everything that a step reads and writes, in arrays, and tables of where these are.

Compiled code is given one table of the addresses and lengths of all its arrays; a kind says what
they have to be: "f8.2" is a float64 array with two dimensions, in C's order.
"""

from typing import Any, NamedTuple

import numpy as np

from bullet_sim.engine.quickstep.layout import SMOOTHING, Scene, Trees
from bullet_sim.pose import Array

# blocks: where their numbers are, of the accelerations of both bodies, and of the impulses of the
# normal that bounds a friction (-1: none), whether there are a second body and a second row (of a
# contact) or a CFM (of a joint), how many blocks before it have to be solved one after the other
B_AT, B_ONE, B_TWO, B_NORMAL, B_BOTH, B_PAIR, B_LEVEL, B_COLUMNS = 0, 1, 2, 3, 4, 5, 6, 7
# numbers of a joint's block: six rows, each of the first five without bounds. Two rows in four
# lanes: of each of 12 columns the Jacobian, so three times; for each row 12 times inverse mass
# times it (twice, for both solutions); right sides, impulses; bounds of the last two; for each row
# what its impulse changes by its CFM, in all rows
J_M, J_RHS, J_L, J_LOW, J_HIGH, J_CFM, J_SIZE = 144, 288, 300, 312, 316, 320, 392
# numbers of a contact's block: two rows
C_M, C_RHS, C_L, C_CFM, C_LOW, C_HIGH, C_COUPLING, C_SIZE = 48, 96, 100, 104, 108, 112, 116, 120
WEIGHTS = 8  # numbers before the first block: of new and old impulses of contacts
ROWS, ROWS_MOST = 6, 7  # of a joint's block; of a joint
POSITION, VELOCITY, EFFORT_ALONE = range(3)  # what the errors are of; no PID, a constant effort
GOALS = {"position": POSITION, "velocity": VELOCITY, "": EFFORT_ALONE}
# rows of PIDs: number of the joint, limits of its velocity and effort in Gazebo, and the attributes
# of effort_row.EffortRow in their order
P_JOINT, P_TOP_SPEED, P_TOP_EFFORT, P_GOAL, P_TARGET, P_LOWER, P_UPPER, P_LINEAR = range(8)
P_P, P_I, P_D, P_LOW, P_HIGH, P_ANTIWINDUP = range(8, 14)
P_LIMIT, P_MIN, P_MAX, P_SPEED = range(14, 18)
P_STATE = 18
P_LAST, P_INTEGRAL, P_RATE, P_BY_ERROR, P_BY_INTEGRAL, P_BY_RATE = range(18, 24)
P_OUTPUT, P_APPLIED, P_SIZE = 24, 25, 26


class Blocks(NamedTuple):
    """Blocks in the order in which they are solved: joints, normals, friction.

    Attributes:
        places: (b, B_COLUMNS).
        numbers: (n,) of all blocks.
        ends: (3,) number of blocks up to the joints' last, the normals' last and the last.
        work: (n W_SIZE,) working values of all bodies.
        unsorted: (b, B_COLUMNS), levels: (n,) and counts: (b + 1,) to sort blocks with.
    """

    places: Array
    numbers: Array
    ends: Array
    work: Array
    unsorted: Array
    levels: Array
    counts: Array


def make_blocks(joints: int, contacts: int, work: Array) -> Blocks:
    """Room for the blocks of a number of joints and contacts, between bodies with working values.

    Args:
        work: (n, W_SIZE); the last row is of no body.
    """
    most = ROWS_MOST * joints + 2 * contacts  # joints' rows one by one; a normal and its friction
    size = WEIGHTS + ROWS_MOST * joints * J_SIZE + 2 * contacts * C_SIZE
    raw = np.zeros(size + 8)
    begin = -raw.ctypes.data // 8 % 8  # at a multiple of 64 bytes, which a processor loads at once
    numbers = raw[begin : begin + size]
    numbers[:WEIGHTS] = (1.0 - SMOOTHING, 1.0) * 2 + (SMOOTHING, 0.0) * 2
    places, unsorted = np.zeros((2, most, B_COLUMNS), np.int64)
    ends, levels, counts = (np.zeros(n, np.int64) for n in (3, len(work), most + 1))
    return Blocks(places, numbers, ends, work.reshape(-1), unsorted, levels, counts)


class State(NamedTuple):
    """Everything that a step reads and writes.

    Attributes:
        gravity: (3,).
        sequence: (n,) the bodies in the order of the last step, which the contacts follow.
        types: (j, 3) type, first and second body (-1: the world) of each joint.
        starts: (n + 1,) first place in `lists` of each body's joints.
        below: (j, n) whether a body is below a joint.
        owners: (c, 4) bodies, shape and plane, or -1 and the number of what never moves.
        links: (m, 6) of each row the bodies, BILATERAL, UNILATERAL or the normal's row, the joint,
            which row of it, and where its impulses are in the blocks.
        first_row: (c,) of each contact.
        marks: (4, k) numbers to work with.
        result: (1,) number of contacts of the last step.
        pids: (j, P_SIZE), active, noted: see apply_pids().
    """

    settings: Array
    gravity: Array
    bodies: Array
    sequence: Array
    joints: Array
    types: Array
    starts: Array
    lists: Array
    below: Array
    scene: Scene
    contacts: Array
    owners: Array
    rows: Array
    links: Array
    first_row: Array
    blocks: Blocks
    work: Array
    marks: Array
    result: Array
    pids: Array
    active: Array
    noted: Array


class Casting(NamedTuple):
    """What rays.cast() reads, and `ranges`, which it shortens.

    Attributes:
        center: (3,) [m].
        directions: (n, 3) unit vectors.
        low, high: (3,) corners of a box that contains the rays [m].
        centers, frames: (s, 3) [m] and (s, 3, 3) of the shapes in the world.
        sizes: (s, 3) half the edges; radius; radius and half the length [m].
        radii: (s,) of spheres around them [m].
        kinds: (s,) BOX, SPHERE or CYLINDER; others are left out.
        starts: (s,) distance from which on a hit counts [m].
        ranges: (n,) distances [m].
    """

    center: Array
    directions: Array
    low: Array
    high: Array
    centers: Array
    frames: Array
    sizes: Array
    radii: Array
    kinds: Array
    starts: Array
    ranges: Array


class Building(NamedTuple):
    """What trees.build_tree() reads and writes.

    Attributes:
        corners: (n, 3, 3) of triangles, single precision [m].
        order: (n,) gets the numbers of the triangles in the tree's order.
        nodes: (max(1, n - 1), 6) get boxes: center and half the edges [m].
        children: (max(1, n - 1), 2) get the numbers of nodes, or -1 - the place of a triangle in
            the order; NO_CHILD: none.
        todo: (n + 1, 5) to work with: start, end, parent, which child, depth.
        means: (7,) to work with, single precision.
    """

    corners: Array
    order: Array
    nodes: Array
    children: Array
    todo: Array
    means: Array


_1, _2, _3, _N1, _N2 = "f8.1", "f8.2", "f8.3", "i8.1", "i8.2"
KINDS: dict[Any, tuple[Any, ...]] = {
    Trees: (_2, _2, _N2, _N1, _N2, _2, _N1, _N2, _N1, _N1),
    Scene: (
        *(_2, _N2, _N1, _2, _2, _2, _N1, _2, _N2, _N2, _N1, _N2, _2, _N1, _2, _2, _N1, _N1, _N1),
        *(_N1, Trees, _2, _N1, _N2, _N1, _2),
    ),
    Blocks: (_N2, _1, _N1, _1, _N2, _N1, _N1),
    State: (
        *(_1, _1, _2, _N1, _2, _N2, _N1, _N1, "b1.2", Scene, _2, _N2, _2, _N2, _N1),
        *(Blocks, _2, _N2, _N1, _2, _N1, _2),
    ),
    Casting: (_1, _2, _1, _1, _2, _3, _2, _1, _N1, _1, _1),
    Building: ("f4.3", _N1, _2, _N2, _N2, "f4.1"),
}
# functions that Python calls -> kinds of numbers that they are given before their table
CALLS = {"advance": ("i8", "i8", "f8", "i8", "b1", "b1"), "cast": ("f8",), "build_tree": ()}


def make_table(arrays: Any) -> Array:
    """Table (int64) of the arrays of one of KINDS, which have to outlive it: of each its address
    and its lengths.

    Raises:
        TypeError: an array is of another kind; it is named.
    """
    numbers: list[int] = []
    _append(numbers, arrays)
    return np.array(numbers, np.int64)


def _append(numbers: list[int], arrays: Any) -> None:
    for name, each, wanted in zip(arrays._fields, arrays, KINDS[type(arrays)], strict=True):
        if isinstance(each, tuple):
            _append(numbers, each)
            continue
        found = f"{each.dtype.str[1:]}.{each.ndim}"
        if found != wanted or not each.flags.c_contiguous:
            order = "" if each.flags.c_contiguous else ", not in C's order"
            raise TypeError(f"{name} is {found}{order}, must be {wanted}")
        numbers += each.ctypes.data, *each.shape
