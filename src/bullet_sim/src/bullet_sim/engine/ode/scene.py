"""Shapes for the solver 'ode': what moves, what never moves, and the Scene that both are packed in.

Rows of a Scene's arrays are those of quickstep/layout.py.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from bullet_sim.description.collisions import is_passable
from bullet_sim.description.model import Link, Shape, Surface
from bullet_sim.engine.api import BodyLink
from bullet_sim.engine.ode import tables
from bullet_sim.engine.ode.shapes import ShapeCache
from bullet_sim.engine.quickstep import layout as q
from bullet_sim.engine.quickstep.state import Fields, Scene, Trees
from bullet_sim.pose import Array, Pose

MAX_POINTS = 10  # of a pair of shapes
_SOLIDS = (q.BOX, q.SPHERE, q.CYLINDER, q.MESH)
_MAX_ROOM = 64  # of a pair for which there is room in any case
_MAX_CLOSE = 32  # bodies to one


class Solid(NamedTuple):
    """A shape that quickstep finds the contacts of, but no plane.

    Attributes:
        row, face: of Scene.solids and of its surface.
        kind: of shape.
        tree: of a mesh.
        field: of a heightmap.
        item: of Scene.
        owner: number of what never moves; -1: it moves.
    """

    row: Array
    face: Array
    kind: int
    tree: tables.Tree | None
    item: tuple[int, int]
    owner: int = -1
    field: tables.Field | None = None


def _pack_solids(solids: Sequence[Solid], reach: float) -> dict[str, Any]:
    """The arrays of a Scene of these; reach: of the largest shape that moves [m]."""
    roots, trees = _pack_trees([solid.tree for solid in solids])
    fields = _pack_fields([solid.field for solid in solids], roots, reach)
    return {
        "solids": tables.table([solid.row for solid in solids], q.B_COLUMNS),
        "faces": tables.table([solid.face for solid in solids], q.P_COLUMNS),
        "owners": np.array([solid.owner for solid in solids], np.int64),
        "solid_kinds": np.array([solid.kind for solid in solids], np.int64),
        "roots": roots,
        "trees": trees,
        "fields": fields,
    }


def _pack_fields(used: Sequence[tables.Field | None], roots: Array, reach: float) -> Fields:
    """The heightmaps of solids, whose rows `roots` gets, with room for a shape of that reach."""
    rows: list[Array] = []
    heights, points = [np.zeros(0)], 0
    for number, each in enumerate(used):
        if each is None:
            continue
        roots[number] = len(rows)
        row = tables.field_row(each, sum(map(len, heights)))
        rows.append(row)
        heights.append(each.heights.astype(float).ravel())
        counts = np.minimum(
            np.ceil(2.0 * reach / row[q.FD_STEP_X : q.FD_STEP_Z + 1]) + 3.0,
            row[q.FD_COUNT_X : q.FD_COUNT_Z + 1],
        )
        points = max(points, int(counts.prod()))
    return Fields(
        rows=tables.table(rows, q.FD_COLUMNS),
        heights=np.concatenate(heights),
        zone=np.zeros(4, np.int64),
        points=np.zeros((points, q.V_COLUMNS)),
        triangles=np.zeros((2 * points, q.T_COLUMNS)),
        order=np.zeros(2 * points, np.int64),
        plane=np.zeros((1, q.P_COLUMNS)),
    )


@dataclass
class StaticShapes:
    """Shapes of what never moves.

    Attributes:
        planes, bits: rows of Scene.planes, and their collide_bitmask.
        plane_links: of planes.
        known: links of others whose contacts quickstep finds.
        aabbs, solids, owners: rows of Scene.static_aabbs, static_solid and static_owner.
        spaces: rows of Scene.spaces.
        plane_items: rows of Scene.items.
    """

    planes: list[Array] = field(default_factory=list)
    bits: list[int] = field(default_factory=list)
    plane_links: list[BodyLink] = field(default_factory=list)
    known: list[BodyLink] = field(default_factory=list)
    aabbs: list[Array] = field(default_factory=list)
    solids: list[int] = field(default_factory=list)
    owners: list[tuple[int, int]] = field(default_factory=list)
    spaces: list[Array] = field(default_factory=list)
    plane_items: list[tuple[int, int]] = field(default_factory=list)

    def add(
        self,
        key: BodyLink,
        link: Link,
        frame: Pose,
        bits: int,
        cache: ShapeCache,
        solids: list[Solid],
    ) -> None:
        """Add the shapes of a link.

        Args:
            frame: where it is in the world.
            bits: its collide_bitmask.
            solids: gets what quickstep finds the contacts of: all of the link, or nothing.
        """
        touched = [shape for shape in link.collisions if not is_passable(shape, link)]
        others = [shape for shape in touched if shape.geometry.kind != "plane"]
        fields = [cache.field(shape) for shape in others]
        trees = [None if terrain else cache.tree(shape) for shape, terrain in zip(others, fields)]
        is_known = all(
            terrain or tree or tables.KINDS.get(shape.geometry.kind, q.MESH) != q.MESH
            for shape, tree, terrain in zip(others, trees, fields)
        )
        items = {id(shape): (len(self.spaces), -i) for i, shape in enumerate(link.collisions)}
        boxes = []
        for shape, tree, terrain in zip(others, trees, fields):
            self.owners.append((key[0], bits))
            boxes.append(cache.box_around(shape, frame, key[0], tree if is_known else None))
            if not is_known:
                self.solids.append(-1)
                continue
            pose, kind = frame * shape.pose, tables.KINDS[shape.geometry.kind]
            kind = q.FIELD if terrain else kind
            half = tables.solid_size(kind, shape.geometry.size)
            row = np.concatenate([half, pose.position, pose.matrix.ravel()])
            face = tables.plane_row(np.zeros(3), 0.0, shape.surface or link.surface)
            self.solids.append(len(solids))
            item = items[id(shape)]
            solids.append(Solid(row, face, kind, tree, item, len(self.known), terrain))
        self.aabbs += boxes
        if is_known:
            self.known.append(key)
        for shape in touched:
            if shape.geometry.kind == "plane":
                self._add_plane(frame * shape.pose, shape.surface or link.surface)
                self.bits.append(bits)
                self.plane_links.append(key)
                self.plane_items.append(items[id(shape)])
        self.spaces.append(_static_space(len(self.spaces), boxes, link))

    def _add_plane(self, pose: Pose, surface: Surface) -> None:
        normal = pose.matrix[:, 2]
        self.planes.append(tables.plane_row(normal, float(normal @ pose.position), surface))

    def pack(self) -> dict[str, Any]:
        """The arrays of a Scene of these."""
        boxes = tables.table(self.aabbs, 6)
        groups = [boxes[i : i + q.AABB_GROUP] for i in range(0, len(boxes), q.AABB_GROUP)]
        return {
            "planes": tables.table(self.planes, q.P_COLUMNS),
            "plane_bits": np.array(self.bits, np.int64),
            "static_aabbs": boxes,
            "static_solid": np.array(self.solids, np.int64),
            "static_owner": tables.table(self.owners, 2, np.int64),
            "aabb_groups": tables.table([tables.around(group) for group in groups], 6),
        }


@dataclass
class DynamicShapes:
    """Shapes of bodies that move; those of a body follow each other.

    Attributes:
        bodies: row of each shape's body.
        kinds: of shapes.
        rows, extents: of Scene.shapes and Scene.extents.
        vertices, chunks: of a mesh: (v, 3) and (c, 6), else none.
        trees: of meshes.
    """

    bodies: list[int] = field(default_factory=list)
    kinds: list[int] = field(default_factory=list)
    rows: list[Array] = field(default_factory=list)
    extents: list[Array] = field(default_factory=list)
    vertices: list[Array] = field(default_factory=list)
    chunks: list[Array] = field(default_factory=list)
    trees: list[tables.Tree | None] = field(default_factory=list)

    def add(
        self, body: int, link: Link, shape: Shape, cache: ShapeCache, friction: float | None
    ) -> float:
        """Add a shape of a link.

        Args:
            body: row of the link.
            friction: coefficient that was set for the link; None: that of its description.

        Returns:
            Radius [m] around the center of mass that a mesh needs, or what is not known; else 0.
        """
        kind, corners, reach = tables.KINDS.get(shape.geometry.kind, q.OTHER), np.zeros((0, 3)), 0.0
        tree = cache.tree(shape)
        if kind == q.MESH:
            corners = cache.vertices(shape, link)
            kind = kind if len(corners) and tree else q.OTHER
            reach = float(np.linalg.norm(corners, axis=1).max(initial=0.0))
        if kind == q.OTHER:
            reach = max(reach, tables.UNKNOWN)
        self.bodies.append(body)
        self.kinds.append(kind)
        row = tables.shape_row(shape, link)
        if friction is not None:
            row[q.G_MU : q.G_MU + 2] = friction
        self.rows.append(row)
        self.extents.append(tables.extent(shape, link, corners))
        self.vertices.append(corners)
        self.chunks.append(tables.chunks(corners))
        self.trees.append(tree)
        return reach

    def pack(self, solids: list[Solid], space_of: Array) -> dict[str, Any]:
        """The arrays of a Scene of these.

        Args:
            solids: get those that quickstep finds the contacts of.
            space_of: of Scene.
        """
        solid_of = np.full(len(self.rows), -1, np.int64)
        for s, (row, kind, tree) in enumerate(zip(self.rows, self.kinds, self.trees)):
            if kind in _SOLIDS:
                solid, face = np.zeros(q.B_COLUMNS), np.zeros(q.P_COLUMNS)
                solid[: q.B_CENTER] = tables.solid_size(kind, row[q.G_SIZE : q.G_SIZE + 3])
                face[q.P_MU :] = row[q.G_MU :]
                item = int(space_of[self.bodies[s]]), s
                solid_of[s] = len(solids)
                solids.append(Solid(solid, face, kind, tree, item))
        ends, chunks = (
            np.cumsum([0, *map(len, each)], dtype=np.int64) for each in (self.vertices, self.chunks)
        )
        kinds = [self.bodies, self.kinds, ends[:-1], ends[1:], chunks[:-1]]
        return {
            "shapes": tables.table(self.rows, q.G_COLUMNS),
            "kinds": np.ascontiguousarray(np.array(kinds, np.int64).T),
            "points": np.concatenate([np.zeros((0, 3)), *self.vertices]),
            "chunks": np.concatenate([np.zeros((0, 6)), *self.chunks]),
            "extents": tables.table(self.extents, 6),
            "aabbs": np.zeros((len(self.rows), 6)),
            "solid_of": solid_of,
        }

    @property
    def reach(self) -> float:
        """Half the longest diagonal of a box around one of them [m]."""
        return max((float(np.linalg.norm(each[3:])) for each in self.extents), default=0.0)

    def has_unknown(self) -> bool:
        """Whether there are some that the caller has to find the contacts of."""
        return q.OTHER in self.kinds


def pack_scene(
    moving: DynamicShapes,
    static: StaticShapes,
    solids: list[Solid],
    models: Sequence[int],
    spaces: Sequence[int],
    counts: Sequence[int],
    bits: Array,
    may_collide: Array,
) -> Scene:
    """The Scene of all shapes.

    Args:
        solids: of what never moves; gets those of what moves.
        models, spaces: of each body.
        counts: number of shapes of each of these spaces.
        bits: (n,) collide_bitmask of each body.
        may_collide: of Scene.
    """
    immobile = len(static.spaces)
    space_of = np.array(spaces, np.int64) + immobile
    arrays = {
        **moving.pack(solids, space_of),
        **static.pack(),
    }
    arrays.update(_pack_solids(solids, moving.reach))
    bodies = arrays["kinds"][:, 0]
    space_rows = np.zeros((immobile + len(counts), q.K_COLUMNS))
    space_rows[:immobile] = tables.table(static.spaces, q.K_COLUMNS)
    space_rows[immobile:, q.K_COUNT] = counts
    return Scene(
        **arrays,
        firsts=np.searchsorted(bodies, np.arange(len(models) + 1)),
        models=np.array(models, np.int64),
        bits=bits[bodies],
        may_collide=may_collide,
        close_pairs=np.zeros((_MAX_CLOSE * len(models), 2), np.int64),
        pairs=np.zeros((4 * capacity(moving, static), 3), np.int64),
        counts=np.array([0, static.solids.count(-1), immobile], np.int64),
        spaces=space_rows,
        space_of=space_of,
        items=tables.table([*(s.item for s in solids), *static.plane_items], 2, np.int64),
    )


def _static_space(rank: int, boxes: Sequence[Array], link: Link) -> Array:
    """Row of Scene.spaces of a body that never moves; boxes: (6,) around its shapes but planes."""
    row = np.zeros(q.K_COLUMNS)
    row[q.K_RANK], row[q.K_COUNT] = rank, len(link.collisions)
    row[q.K_LEVEL] = q.MAX_LEVEL + 1
    if boxes and not any(shape.geometry.kind == "plane" for shape in link.collisions):
        row[q.K_LOW : q.K_LOW + 6] = box = tables.around(np.array(boxes))
        row[q.K_LEVEL] = space_level(box[3:] - box[:3])
    return row


def space_level(sides: Array) -> int:
    """Level of a space of shapes with a box (3,) [m] around them: see quickstep.order."""
    level = math.frexp(float(sides.max()))[1]
    return min(max(level, q.MIN_LEVEL), q.MAX_LEVEL + 1)


def capacity(moving: DynamicShapes, static: StaticShapes, most: int = MAX_POINTS) -> int:
    """Number of contacts that there is room for; most: of a pair of shapes in this world."""
    wanted = max((int(row[q.G_MOST]) for row in moving.rows), default=0)
    points = max(MAX_POINTS, min(wanted, most, _MAX_ROOM))
    return points * (max(1, len(moving.rows)) * (len(static.planes) + 2) + 128)


def may_collide(
    models: Sequence[int],
    moving: DynamicShapes,
    bits: Array,
    touching: Iterable[tuple[int, int]],
    attached: Iterable[tuple[int, int]] = (),
) -> Array:
    """Scene.may_collide (n, n) of bodies.

    Args:
        models: number of each body's model.
        bits: (n,) collide_bitmask of each body.
        touching: pairs of bodies of one model that collide with each other.
        attached: pairs of bodies that do not, as a joint connects them.
    """
    body, rows = np.array(models, np.int64), np.arange(len(models))
    collide = body[:, None] != body
    for one, two in touching:
        collide[one, two] = collide[two, one] = True
    for one, two in attached:
        collide[one, two] = collide[two, one] = False
    shaped = np.isin(rows, moving.bodies)
    collide &= ((bits[:, None] & bits) != 0) & shaped[:, None] & shaped
    unknown = [body for body, kind in zip(moving.bodies, moving.kinds) if kind not in _SOLIDS]
    plain = ~np.isin(rows, unknown)
    kinds = np.where(plain[:, None] & plain, q.PAIR_NATIVE, q.PAIR_EXTERNAL)
    return np.asarray(np.where(collide, kinds, q.PAIR_FILTERED))


def _pack_trees(used: Sequence[tables.Tree | None]) -> tuple[Array, Trees]:
    """Roots of trees, -1 where there is none, and the trees, each once."""
    firsts: dict[int, tuple[int, int]] = {}  # number of the first node and triangle
    distinct: list[tables.Tree] = []
    nodes = triangles = 0
    for tree in used:
        if tree is not None and id(tree) not in firsts:
            firsts[id(tree)] = nodes, triangles
            distinct.append(tree)
            nodes, triangles = nodes + len(tree.nodes), triangles + len(tree.corners)
    children = [np.zeros((0, 2), np.int64)]
    for tree in distinct:
        node, triangle = firsts[id(tree)]
        moved = np.where(tree.children >= 0, tree.children + node, tree.children - triangle)
        children.append(np.where(tree.children == q.NO_CHILD, q.NO_CHILD, moved))
    roots = np.array([-1 if tree is None else firsts[id(tree)][0] for tree in used], np.int64)
    depth = max((tree.depth for tree in distinct), default=1)
    all_children = np.concatenate(children)
    parents = np.full(triangles + nodes, -1, np.int64)
    for column in all_children.T:
        is_there = column != q.NO_CHILD
        parents[triangles + column[is_there]] = triangles + np.flatnonzero(is_there)
    return roots, Trees(
        corners=np.concatenate([np.zeros((0, 9)), *(tree.corners for tree in distinct)]),
        nodes=np.concatenate([np.zeros((0, 6)), *(tree.nodes for tree in distinct)]),
        children=all_children,
        depth=np.array([depth], np.int64),
        todo=np.zeros((4 * depth + 8, 3), np.int64),
        found=np.zeros((q.MAX_COLLIDE_RETURNS, q.F_COLUMNS)),
        parents=parents,
        marks=np.zeros((triangles + nodes, 2), np.int64),
        calls=np.zeros(1, np.int64),
        near=np.zeros(q.MAX_NEAR_BOXES, np.int64),
    )
