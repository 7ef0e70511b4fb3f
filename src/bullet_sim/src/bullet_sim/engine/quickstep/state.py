"""Everything that a step reads and writes, in records of arrays, and tables of where these are.

Compiled code is given one table of the addresses and lengths of all its arrays; a kind says what
they have to be: "f8.2" is a float64 array with two dimensions, in C's order.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from bullet_sim.engine.quickstep import layout as col
from bullet_sim.pose import Array


class System(NamedTuple):
    """Bodies, and the joints that connect them.

    Attributes:
        bodies: (n, B_SIZE).
        work: (n + 1, W_SIZE) working values of bodies; the last row is of no body.
        joints: (j, J_SIZE).
        types: (j, 3) type, first and second body (-1: the world) of each joint.
        starts: (n + 1,) first place in `lists` of each body's joints.
        lists: (k,) numbers of joints.
        below: (j, n) whether a body is below a joint.
    """

    bodies: Array
    work: Array
    joints: Array
    types: Array
    starts: Array
    lists: Array
    below: Array


class Trees(NamedTuple):
    """The trees of all meshes after each other, and room to work with.

    Attributes:
        corners: (t, 9) triangles [m] in the order of the trees.
        nodes: (k, 6) center and half the edges of boxes [m].
        children: (k, 2) numbers of nodes, or -1 - the number of a triangle; NO_CHILD: none.
        depth: (1,) of the deepest.
        todo: (w, 3) room for what is still to be looked at, for 4 times that depth and 8.
        found: (MAX_COLLIDE_RETURNS, F_COLUMNS) room for contacts of a pair.
        parents: (t + k,) of each triangle, the last first, and of each box: t and the number of the
            box that it is in, or -1.
        marks: (t + k, 2) of these: the last call that had to look at them, in its first tree and in
            its second.
        calls: (1,) number of the call that marks.
        near: (MAX_NEAR_BOXES,) room for numbers of boxes.
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


class Fields(NamedTuple):
    """Heightmaps, and room to collide with one of them.

    Attributes:
        rows: (f, FD_COLUMNS).
        heights: of all [m], row by row along x, those at +y first.
        zone: (4,) first and last point of the grid near a shape, along x and along -y.
        points, triangles: (p, V_COLUMNS) and (t, T_COLUMNS) of a zone.
        order: (t,) first triangles of its planes.
        plane: (1, P_COLUMNS) a plane of it in the world.
    """

    rows: Array
    heights: Array
    zone: Array
    points: Array
    triangles: Array
    order: Array
    plane: Array


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
        aabbs: (s, 6) lower and upper corners of boxes around the shapes where they are.
        may_collide: (n, n) PAIR_FILTERED, PAIR_NATIVE or PAIR_EXTERNAL, for each two bodies.
        close_pairs: (c, 2) bodies that are close to each other, whose contacts are found here.
        counts: (3,) number of these; of boxes whose contacts the caller finds; of spaces of what
            never moves.
        pairs: (m, 3) shapes, with a row of solids, or -1 - that of a plane, and the body of which
            the solid is, or -1.
        planes: (p, P_COLUMNS).
        plane_bits: (p,) collide_bitmask of planes.
        solids: (b, B_COLUMNS) shapes but planes and OTHER: those that never move, then of bodies.
        faces: (b, P_COLUMNS) their surfaces.
        owners: (b,) number of what never moves, for the contacts.
        solid_kinds: (b,) SPHERE, CYLINDER, BOX, MESH or FIELD.
        solid_of: (s,) each shape's row of solids, -1 of OTHER.
        roots: (b,) of the trees of meshes, rows of heightmaps, else -1.
        trees: meshes.
        fields: heightmaps.
        static_aabbs: (m, 6) lower and upper corners of boxes around what never moves, but planes.
        static_solid: (m,) the solid in each, -1: something of which the caller finds the contacts.
        static_owner: (m, 2) its model, whose own bodies do not touch it, and its collide_bitmask.
        bits: (s,) collide_bitmask of shapes, which touch only what shares a bit.
        aabb_groups: (c, 6) boxes around AABB_GROUP of static_aabbs each, in their order.
        spaces: (k, K_COLUMNS) of shapes: first those of what never moves, in the order in which
            they were made.
        space_of: (n,) space of each body.
        items: (b + p, 2) space of each solid and then of each plane, and its place in what never
            moves, or number of the shape.
    """

    shapes: Array
    kinds: Array
    firsts: Array
    points: Array
    chunks: Array
    extents: Array
    models: Array
    aabbs: Array
    may_collide: Array
    close_pairs: Array
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
    fields: Fields
    static_aabbs: Array
    static_solid: Array
    static_owner: Array
    bits: Array
    aabb_groups: Array
    spaces: Array
    space_of: Array
    items: Array


class Contacts(NamedTuple):
    """Contacts of a step.

    Attributes:
        rows: (c, C_SIZE).
        owners: (c, 4) bodies (second -1: none), then shape and plane, or -1 and the number of what
            never moves.
        first_row: (c,) constraint row of the normal; -1: it sleeps.
    """

    rows: Array
    owners: Array
    first_row: Array


class Constraints(NamedTuple):
    """Rows of constraints of a step.

    Attributes:
        rows: (m, R_SIZE).
        links: (m, 6) the bodies, BILATERAL, UNILATERAL or the normal's row, the joint, which row of
            it, and where the row's impulses are in the blocks.
    """

    rows: Array
    links: Array


class Blocks(NamedTuple):
    """Blocks in the order in which they are solved: joints, normals, friction.

    Attributes:
        places: (b, BLOCK_SIZE).
        numbers: (n,) of all blocks.
        work: (n W_SIZE,) working values of all bodies.
        unsorted: (b, BLOCK_SIZE), levels: (n,) and counts: (b + g,) to sort blocks with.
    """

    places: Array
    numbers: Array
    work: Array
    unsorted: Array
    levels: Array
    counts: Array


class Islands(NamedTuple):
    """Groups of islands of bodies, see islands.py.

    Attributes:
        starts: (g + 1, I_SIZE) where each begins, and where the last one ends.
        counts: (2,) groups of a step; iterations, as advance() is told.
        step: (1,) time step [s], likewise.
        shared: (T_SIZE,) what threads share.
    """

    starts: Array
    counts: Array
    step: Array
    shared: Array


class ContactRecords(NamedTuple):
    """Contacts of some bodies after recorded steps, see touching.record_contacts().

    Attributes:
        bodies: (b,) their rows.
        chosen: (c, CR_SIZE); numbers: (c, 16) as of Touching.
        ends: (m,) how many there are up to each recorded step.
        spaces: (k,) of what never moves, by its number; -1: none.
    """

    bodies: Array
    chosen: Array
    numbers: Array
    ends: Array
    spaces: Array


class State(NamedTuple):
    """Everything that a step reads and writes.

    Attributes:
        settings: (S_SIZE,).
        gravity: (3,) [m/s^2].
        sequence: (n,) the bodies in the order of the last step, which the contacts follow.
        marks: (4, k) numbers to work with.
        result: (1,) number of contacts of the last step.
        efforts, active, recorded: see apply_efforts().
        states: (m, n SR_BODY + j SR_JOINT + j) records of the states after steps.
        taken: (2,) how many are to be recorded, and were.
        inward: (n, 3) frames of the links, from the centers of mass of the bodies [m].
        held: (n, HELD_SIZE) bodies whose velocity is set between two steps.
        holding: (2,) how many there are, and whether it is set before the first step, too.
    """

    settings: Array
    gravity: Array
    sequence: Array
    system: System
    scene: Scene
    contacts: Contacts
    constraints: Constraints
    blocks: Blocks
    islands: Islands
    marks: Array
    result: Array
    efforts: Array
    active: Array
    recorded: Array
    states: Array
    taken: Array
    inward: Array
    held: Array
    holding: Array
    contact_records: ContactRecords


class Casting(NamedTuple):
    """What rays.cast() reads, and `ranges`, which it fills. Shapes are in the order of the tree of
    boxes around them; planes follow.

    Attributes:
        center: (3,) [m] from which the rays come; directions: (n, 3) unit vectors.
        ranges: (n,) distances [m].
        bodies: (b, B_SIZE) of the solver.
        rows: (s,) each shape's row of bodies, -1: it never moves.
        places, turns: (s, 3) [m] and (s, 3, 3) of shapes in their bodies, from the center of mass.
        centers, frames: (s, 3) [m] and (s, 3, 3) of shapes in the world, set for what moves.
        kinds: (s,) BOX, SPHERE, CYLINDER, MESH, else a plane.
        sizes: (s, 3) half the edges; radius; radius and half the length [m].
        roots: (s,) of meshes' trees.
        origins: (s, 3) room for the center in the shapes' frames.
        extents: (t, 6) center and half the edges of a box around each shape but planes, in its
            frame.
        boxes: (a + t, 6) room for lower and upper corners of boxes in the world: those of a tree,
            then those of the shapes, which are its leaves.
        branches: (a, 2) rows of boxes in each box of the tree; children come after their parents.
        triangles: (c, 9) a corner and two edges of triangles of all meshes [m].
        nodes, children: (k + c, 6) and (k, 2) as boxes and branches, of all meshes; the leaves are
            the triangles.
        todo, entries: (w,) room for boxes that a ray still has to be tested with, and the distances
            at which it enters them.
    """

    center: Array
    directions: Array
    ranges: Array
    bodies: Array
    rows: Array
    places: Array
    turns: Array
    centers: Array
    frames: Array
    kinds: Array
    sizes: Array
    roots: Array
    origins: Array
    extents: Array
    boxes: Array
    branches: Array
    triangles: Array
    nodes: Array
    children: Array
    todo: Array
    entries: Array


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


class Touching(NamedTuple):
    """What touching.list_contacts() reads and writes.

    Attributes:
        rows, owners: of Contacts; result: of State; bodies: of System.
        chosen: (c, 4) get rows of owners.
        numbers: (c, 16) get position [m] and normal (3,), depth [m], force (3,) [N] and the wrench
            (6,) about the body's center of mass in its axes [N, N m].
    """

    rows: Array
    owners: Array
    result: Array
    bodies: Array
    chosen: Array
    numbers: Array


_1, _2, _3, _N1, _N2 = "f8.1", "f8.2", "f8.3", "i8.1", "i8.2"
KINDS: dict[Any, tuple[Any, ...]] = {  # of the fields of each record, in their order
    System: (_2, _2, _2, _N2, _N1, _N1, "b1.2"),
    Trees: (_2, _2, _N2, _N1, _N2, _2, _N1, _N2, _N1, _N1),
    Fields: (_2, _1, _N1, _2, _2, _N1, _2),
    Scene: (
        *(_2, _N2, _N1, _2, _2, _2, _N1, _2, _N2, _N2, _N1, _N2, _2, _N1, _2, _2, _N1, _N1, _N1),
        *(_N1, Trees, Fields, _2, _N1, _N2, _N1, _2, _2, _N1, _N2),
    ),
    Contacts: (_2, _N2, _N1),
    Constraints: (_2, _N2),
    Blocks: (_N2, _1, _1, _N2, _N1, _N1),
    Islands: (_N2, _N1, _1, _N1),
    ContactRecords: (_N1, _N2, _2, _N1, _N1),
    State: (
        *(_1, _1, _N1, System, Scene, Contacts, Constraints, Blocks, Islands),
        *(_N2, _N1, _2, _N1, _2, _2, _N1, _2, _2, _N1, ContactRecords),
    ),
    Casting: (
        *(_1, _2, _1, _2, _N1, _2, _3, _2, _3, _N1, _2, _N1, _2),
        *(_2, _2, _N2, _2, _2, _N2, _N1, _1),
    ),
    Building: ("f4.3", _N1, _2, _N2, _N2, "f4.1"),
    Touching: (_2, _N2, _N1, _2, _N2, _2),
}
# functions that Python calls -> kinds of numbers that they are given before their table
CALLS = {
    "advance": ("i8", "i8", "f8", "i8", "b1", "b1"),
    "serve": (),
    "cast": ("f8", "f8"),
    "build_tree": (),
    "list_contacts": ("i8",),
}


def aligned_zeros(*shape: int) -> Array:
    """Zeros from a multiple of 64 bytes on, which a processor loads at once."""
    size = math.prod(shape)
    raw = np.zeros(size + 8)
    begin = -raw.ctypes.data // 8 % 8
    return raw[begin : begin + size].reshape(shape)


def make_blocks(joints: int, contacts: int, work: Array) -> Blocks:
    """Room for the blocks of a number of joints and contacts, between bodies with working values.

    Args:
        work: (n, W_SIZE); the last row is of no body.
    """
    # each row in a block of its own: a group of islands has room for as many as it has rows
    capacity = col.MAX_JOINT_ROWS * joints + col.MAX_CONTACT_ROWS * contacts
    size = col.WEIGHTS + col.MAX_JOINT_ROWS * joints * col.JB_SIZE
    size += col.MAX_CONTACT_ROWS * contacts * col.CB_SIZE
    numbers = aligned_zeros(size)
    numbers[: col.WEIGHTS] = (1.0 - col.SMOOTHING, 1.0) * 2 + (col.SMOOTHING, 0.0) * 2
    places, unsorted = np.zeros((2, capacity, col.BLOCK_SIZE), np.int64)
    levels, counts = (np.zeros(n, np.int64) for n in (len(work), capacity + len(work)))
    return Blocks(places, numbers, work.reshape(-1), unsorted, levels, counts)


def make_islands(bodies: int) -> Islands:
    """Room for the islands of a number of bodies."""
    starts, shared = np.zeros((bodies + 2, col.I_SIZE), np.int64), np.zeros(col.T_SIZE, np.int64)
    return Islands(starts, np.zeros(2, np.int64), np.zeros(1), shared)


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
    kinds = KINDS[type(arrays)]
    if len(kinds) != len(arrays):
        raise TypeError(f"{type(arrays).__name__} has {len(arrays)} arrays and {len(kinds)} kinds")
    for name, each, wanted in zip(arrays._fields, arrays, kinds):
        if isinstance(each, tuple):
            _append(numbers, each)
            continue
        found = f"{each.dtype.str[1:]}.{each.ndim}"
        if found != wanted or not each.flags.c_contiguous:
            order = "" if each.flags.c_contiguous else ", not in C's order"
            raise TypeError(f"{name} is {found}{order}, must be {wanted}")
        numbers += (each.ctypes.data, *each.shape)
