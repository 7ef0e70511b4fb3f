"""The arrays of the solver 'ode' (see quickstep/layout.py), built of an engine's bodies."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from operator import itemgetter
from typing import TYPE_CHECKING, Any

import numpy as np

from bullet_sim.controllers.effort_row import MAX_NOTED_STEPS
from bullet_sim.description.lump import LumpedModel
from bullet_sim.description.model import Joint, Link, Shape
from bullet_sim.description.world import OdeSettings
from bullet_sim.engine import tables
from bullet_sim.engine.ode_shapes import ShapeCache
from bullet_sim.engine.passable import is_passable
from bullet_sim.engine.quickstep import layout as q
from bullet_sim.engine.quickstep.state import (
    Constraints,
    Contacts,
    Scene,
    State,
    System,
    Trees,
    make_blocks,
    make_table,
)
from bullet_sim.engine.rays import KINDS
from bullet_sim.pose import Array, Pose, Vec3

if TYPE_CHECKING:
    from bullet_sim.engine.engine import Engine

MAX_POINTS = 10  # of a pair of shapes
_SOLIDS = (q.BOX, q.SPHERE, q.CYLINDER, q.MESH)
_ALL_BITS = 0xFFFF  # collide_bitmask of what has none
_MAX_CLOSE = 32  # bodies to one

BodyLink = tuple[int, int]
Measured = Callable[[Any], tuple[float, ...]]


@dataclass
class Part:
    """A moving model.

    Attributes:
        names: of its links that move, in the order in which Gazebo creates them.
        joints: of these links, in the same order.
        links: name -> PyBullet's index.
        may_sleep: it may sleep while it rests, as what has no joints does in Gazebo.
        touching: pairs of its links that collide with each other.
        first, first_joint: its first rows of bodies and of joints.
        order: row of each of the engine's joints.
        measured: gives their positions, velocities and motors' efforts of the flat table of joints.
    """

    body: int
    names: list[str]
    joints: list[Joint]
    links: Mapping[str, int]
    shapes: LumpedModel
    is_fixed: bool
    may_sleep: bool
    touching: Sequence[tuple[str, str]]
    first: int = 0
    first_joint: int = 0
    order: list[int] = field(default_factory=list)
    measured: Measured = tuple

    def link(self, row: int) -> Link:
        """The link of a row of bodies."""
        return self.shapes.links[self.names[row - self.first]]

    def joint(self, number: int) -> Joint:
        """The joint of a number of the engine's."""
        return self.joints[self.order[number] - self.first_joint]


@dataclass
class Still:
    """A model that never moves: PyBullet's number, its link."""

    body: int
    link: Link


@dataclass
class Models:
    """What the arrays are built of.

    Attributes:
        moving, still: models by PyBullet's number; one whose root link never moves is in both.
        filtered: collide_bitmask of links that have one.
        ghosts: bodies that touch only what never moves.
        friction: coefficients of links for which one was set.
    """

    moving: dict[int, Part] = field(default_factory=dict)
    still: dict[int, Still] = field(default_factory=dict)
    filtered: dict[BodyLink, int] = field(default_factory=dict)
    ghosts: set[int] = field(default_factory=set)
    friction: dict[BodyLink, float] = field(default_factory=dict)


@dataclass
class Arrays:
    """What steps work with.

    Attributes:
        models: PyBullet's numbers of the bodies that move and have rows here.
        owner: (body, link) of each row of bodies.
        rows: the other way round.
        inward: from the centers of mass to the links' frames [m].
        state, table: all numbers, as Python and as the compiled functions take them.
        planes, known: (body, link) of planes, and of others whose contacts quickstep finds.
        watch: bodies may come close to each other or to what never moves, but for planes.
        always: PyBullet finds contacts of each step.
        sleepy: there are bodies that may sleep.
    """

    models: set[int]
    owner: list[BodyLink]
    rows: dict[BodyLink, int]
    inward: list[Vec3]
    state: State
    table: Array
    planes: list[BodyLink]
    known: list[BodyLink]
    watch: bool
    always: bool
    sleepy: bool


class ArrayBuilder:
    """Builds the arrays of what is there now, once.

    Args:
        settings: of the world.
    """

    def __init__(
        self, engine: "Engine", shapes: ShapeCache, settings: OdeSettings, models: Models
    ) -> None:
        self._engine, self._shapes = engine, shapes
        self._settings, self._models = settings, models
        self._placed: list[tuple[Part, int, int, list[int], Measured]] = []  # and its rows
        self._touching: list[tuple[int, int]] = []  # rows of links that collide in their model
        self._owner: list[BodyLink] = []
        self._bodies: list[Array] = []
        self._joints: list[Array] = []
        self._types: list[tuple[int, int, int]] = []
        # Of each shape of what moves, kinds as in Scene:
        self._kinds: list[tuple[int, ...]] = []
        self._shape_rows: list[Array] = []
        self._extents: list[Array] = []
        self._vertices: list[Array] = [np.zeros((0, 3))]
        self._chunks: list[Array] = [np.zeros((0, 6))]
        self._still_trees: list[tables.Tree | None] = []  # of the solids
        self._moving_trees: list[tables.Tree | None] = []
        self._planes: list[BodyLink] = []
        self._known: list[BodyLink] = []

    def build(self, numbers: Array, gravity: Array) -> Arrays:
        """Build them; rows of the models that move are where these say from then on.

        Args:
            numbers, gravity: settings of the solver, shared with the arrays.
        """
        moving = self._models.moving.values()
        for part in moving:
            self._add(part)
        bodies = tables.table(self._bodies, q.B_SIZE)
        joints = tables.table(self._joints, q.J_SIZE)
        types = tables.table(self._types, 3, np.int64)
        kinds = tables.table(self._kinds, 5, np.int64)
        bits = np.array([self._bits_of(key) for key in self._owner], np.int64)
        meet = self._meet(kinds, bits)
        ground = self._surroundings()
        ground["bits"] = bits[kinds[:, 0]]
        self._add_moving_solids(ground, kinds)
        self._add_trees(ground)
        shapes, others = len(kinds), kinds[:, 1] == q.OTHER
        most = MAX_POINTS * (max(1, shapes) * (len(ground["planes"]) + 2) + 128)
        scene = Scene(
            shapes=tables.table(self._shape_rows, q.G_COLUMNS),
            kinds=kinds,
            firsts=np.searchsorted(kinds[:, 0], np.arange(len(bodies) + 1)),
            points=np.concatenate(self._vertices),
            chunks=np.concatenate(self._chunks),
            extents=tables.table(self._extents, 6),
            models=np.array([body for body, _ in self._owner], np.int64),
            aabbs=np.zeros((shapes, 6)),
            may_collide=meet,
            close_pairs=np.zeros((_MAX_CLOSE * len(bodies), 2), np.int64),
            pairs=np.zeros((4 * most, 3), np.int64),
            counts=np.array([0, (ground["static_solid"] < 0).sum()], np.int64),
            **ground,
        )
        state = _state(numbers, gravity, bodies, joints, types, scene, most)
        for part, first, first_joint, order, measured in self._placed:  # now that nothing can fail
            part.first, part.first_joint = first, first_joint
            part.order, part.measured = order, measured
        return Arrays(
            models=set(self._models.moving),
            owner=self._owner,
            rows={key: row for row, key in enumerate(self._owner)},
            inward=[
                tuple((-part.shapes.links[name].center).tolist())
                for part in moving
                for name in part.names
            ],
            state=state,
            table=make_table(state),
            planes=self._planes,
            known=self._known,
            watch=bool(len(scene.static_aabbs) or meet.any()),
            always=bool(others.any() and self._planes),
            sleepy=any(part.may_sleep for part in moving),
        )

    def _add(self, part: Part) -> None:
        """Rows of a model that moves."""
        first, first_joint = len(self._bodies), len(self._joints)
        rows = {name: first + i for i, name in enumerate(part.names)}
        for name in part.names:
            link = part.shapes.links[name]
            self._owner.append((part.body, part.links[name]))
            row = tables.body_row(link, self._settings.max_speed)
            row[q.MAY_SLEEP] = float(part.may_sleep)
            self._bodies.append(row)
            for shape in link.collisions:
                if not is_passable(shape, link):
                    self._add_shape(rows[name], row, link, shape)
        self._touching += [
            (rows[one], rows[two]) for one, two in part.touching if one in rows and two in rows
        ]
        for joint in part.joints:
            self._joints.append(self._joint_row(part, joint))
            kind = {"prismatic": q.SLIDER}.get(joint.kind, q.HINGE)
            if joint in part.shapes.welds:
                kind = q.FIXED
            self._types.append((kind, rows[joint.child], rows.get(joint.parent, -1)))
        place = {joint.name: first_joint + i for i, joint in enumerate(part.joints)}
        order = [place[name] for name in self._engine.joint_names(part.body)]
        measured: Measured = tuple
        if order:
            columns = np.array((q.ANGLE, q.RATE, q.MOTOR))[:, None]
            places = columns + q.J_SIZE * np.array(order)
            measured = itemgetter(*places.ravel().tolist())
        self._placed.append((part, first, first_joint, order, measured))

    def _add_shape(self, number: int, row: Array, link: Link, shape: Shape) -> None:
        """A shape of a link that moves.

        Args:
            number, row: of the link.
        """
        kind, start = KINDS.get(shape.geometry.kind, q.OTHER), sum(map(len, self._vertices))
        corners, tree = np.zeros((0, 3)), self._shapes.tree(shape)
        if kind == q.MESH:
            corners = self._shapes.vertices(shape, link)
            self._vertices.append(corners)
            kind = kind if len(corners) and tree else q.OTHER
            reach = np.linalg.norm(corners, axis=1).max(initial=0.0)
            row[q.RADIUS] = max(row[q.RADIUS], reach)
        if kind == q.OTHER:
            row[q.RADIUS] = max(row[q.RADIUS], tables.UNKNOWN)
        else:
            self._moving_trees.append(tree)
        span = start, sum(map(len, self._vertices)), sum(map(len, self._chunks))
        self._kinds.append((number, kind, *span))
        self._chunks.append(tables.chunks(corners))
        shape_row = tables.shape_row(shape, link)
        if self._owner[number] in self._models.friction:
            shape_row[q.G_MU : q.G_MU + 2] = self._models.friction[self._owner[number]]
        self._shape_rows.append(shape_row)
        self._extents.append(tables.extent(shape, link, corners))

    def _joint_row(self, part: Part, joint: Joint) -> Array:
        row = np.zeros(q.J_SIZE)
        child = part.shapes.links[joint.child]
        axis = np.array(joint.axis) / np.linalg.norm(joint.axis)
        frame = joint.origin
        center = part.shapes.links[joint.parent].center
        if part.is_fixed and joint.parent == part.shapes.root:
            frame, center = Pose(*self._engine.base_pose(part.body)) * joint.origin, np.zeros(3)
        anchor = np.array(frame.position) - center
        if joint.kind == "prismatic" or joint in part.shapes.welds:  # where the child's center is
            anchor += frame.matrix @ child.center
        else:
            row[q.ANCHOR1 : q.ANCHOR1 + 3] = -child.center
        row[q.ANCHOR2 : q.ANCHOR2 + 3] = anchor
        row[q.AXIS1 : q.AXIS1 + 3] = axis
        row[q.AXIS2 : q.AXIS2 + 3] = frame.matrix @ axis
        row[q.QREL : q.QREL + 4] = frame.orientation
        lower, upper = joint.lower, joint.upper
        row[q.LOWER], row[q.UPPER] = (1.0, -1.0) if lower is None else (lower, upper)
        row[q.DAMPING], row[q.FMAX], row[q.TARGET] = joint.damping, joint.friction, math.nan
        row[q.IMPOSED] = math.nan
        row[q.IMPLICIT] = float(joint.implicit_damping)
        row[q.STIFFNESS], row[q.AT_REST] = joint.stiffness, joint.rest
        erp, cfm = joint.stop_erp, joint.stop_cfm
        row[q.STOP_ERP] = self._settings.erp if erp is None else erp
        row[q.STOP_CFM] = self._settings.cfm if cfm is None else cfm
        row[q.STOP_PUSH] = joint.stop_push
        return row

    def _bits_of(self, key: BodyLink) -> int:
        """Of a body and link, which touches only what shares one."""
        return self._models.filtered.get(key, _ALL_BITS)

    def _meet(self, kinds: Array, bits: Array) -> Array:
        """Whether bodies (n, n) may touch each other, and who finds it."""
        body = np.array([body for body, _ in self._owner], np.int64)
        ghost = np.isin(body, list(self._models.ghosts))
        shaped = np.isin(np.arange(len(body)), kinds[:, 0])
        meet = (body[:, None] != body) & ~(ghost[:, None] | ghost)
        for one, two in self._touching:
            meet[one, two] = meet[two, one] = True
        shared: Array = (bits[:, None] & bits) != 0
        others = kinds[~np.isin(kinds[:, 1], _SOLIDS), 0]
        plain = ~np.isin(np.arange(len(body)), others)
        known = plain[:, None] & plain
        meet &= shared & shaped[:, None] & shaped
        found: Array = np.where(
            meet, np.where(known, q.PAIR_NATIVE, q.PAIR_EXTERNAL), q.PAIR_FILTERED
        )
        return found

    def _add_moving_solids(self, ground: dict[str, Any], kinds: Array) -> None:
        """Rows of solids for the shapes of bodies, after those that never move."""
        found = np.flatnonzero(np.isin(kinds[:, 1], _SOLIDS))
        shapes, first, count = self._shape_rows, len(ground["solids"]), len(found)
        solids, faces = np.zeros((count, q.B_COLUMNS)), np.zeros((count, q.P_COLUMNS))
        for i, s in enumerate(found):
            size = shapes[s][q.G_SIZE : q.G_SIZE + 3]
            solids[i, : q.B_CENTER] = tables.solid_size(int(kinds[s, 1]), size)
            faces[i, q.P_MU :] = shapes[s][q.G_MU :]
        solid_of = np.full(len(shapes), -1, np.int64)
        solid_of[found] = first + np.arange(count)
        ground["solids"] = np.concatenate([ground["solids"], solids])
        ground["faces"] = np.concatenate([ground["faces"], faces])
        ground["owners"] = np.concatenate([ground["owners"], np.full(count, -1)])
        ground["solid_kinds"] = np.concatenate([ground["solid_kinds"], kinds[found, 1]])
        ground["solid_of"] = solid_of

    def _surroundings(self) -> dict[str, Any]:
        """What never moves: planes, solids, and boxes around all but planes."""
        planes, plane_bits, faces, owners = [], [], [], []
        solids: list[list[float]] = []
        kinds: list[int] = []
        boxes: list[Array] = []
        contents: list[int] = []
        hosts: list[BodyLink] = []
        for still in self._models.still.values():
            body, link = still.body, still.link
            solid = [shape for shape in link.collisions if not is_passable(shape, link)]
            others = [shape for shape in solid if shape.geometry.kind != "plane"]
            frame, bits = Pose(*self._engine.base_pose(body)), self._bits_of((body, -1))
            trees = [self._shapes.tree(shape) for shape in others]
            is_known = all(
                tree is not None or KINDS.get(shape.geometry.kind, q.MESH) != q.MESH
                for shape, tree in zip(others, trees)
            )
            for shape, tree in zip(others, trees):
                hosts.append((body, bits))
                boxes.append(
                    self._shapes.box_around(shape, frame, body, tree if is_known else None)
                )
                contents.append(len(solids) if is_known else -1)
                if not is_known:
                    continue
                pose, code = frame * shape.pose, KINDS[shape.geometry.kind]
                half = tables.solid_size(code, shape.geometry.size)
                solids.append([*half, *pose.position, *pose.matrix.ravel()])
                kinds.append(code)
                faces.append(tables.plane_row(np.zeros(3), 0.0, shape.surface or link.surface))
                owners.append(len(self._known))
                self._still_trees.append(tree)
            if is_known:
                self._known.append((body, -1))
            for shape in solid:
                if shape.geometry.kind == "plane":
                    pose = frame * shape.pose
                    normal = pose.matrix[:, 2]
                    surface = shape.surface or link.surface
                    planes.append(tables.plane_row(normal, float(normal @ pose.position), surface))
                    plane_bits.append(bits)
                    self._planes.append((body, -1))
        around = tables.table(boxes, 6)
        return {
            "planes": tables.table(planes, q.P_COLUMNS),
            "plane_bits": np.array(plane_bits, np.int64),
            "solids": tables.table(solids, q.B_COLUMNS),
            "faces": tables.table(faces, q.P_COLUMNS),
            "owners": np.array(owners, np.int64),
            "solid_kinds": np.array(kinds, np.int64),
            "static_aabbs": around,
            "static_solid": np.array(contents, np.int64),
            "static_owner": tables.table(hosts, 2, np.int64),
            "aabb_groups": tables.table(
                [
                    tables.around(around[i : i + q.AABB_GROUP])
                    for i in range(0, len(around), q.AABB_GROUP)
                ],
                6,
            ),
        }

    def _add_trees(self, ground: dict[str, Any]) -> None:
        """The meshes of all solids, each once, and the roots of the solids' trees."""
        used = [*self._still_trees, *self._moving_trees]
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
        ground["roots"] = np.array(
            [-1 if tree is None else firsts[id(tree)][0] for tree in used], np.int64
        )
        depth = max((tree.depth for tree in distinct), default=1)
        all_children = np.concatenate(children)
        parents = np.full(triangles + nodes, -1, np.int64)
        for column in all_children.T:
            is_there = column != q.NO_CHILD
            parents[triangles + column[is_there]] = triangles + np.flatnonzero(is_there)
        ground["trees"] = Trees(
            np.concatenate([np.zeros((0, 9)), *(tree.corners for tree in distinct)]),
            np.concatenate([np.zeros((0, 6)), *(tree.nodes for tree in distinct)]),
            all_children,
            np.array([depth], np.int64),
            np.zeros((4 * depth + 8, 3), np.int64),
            np.zeros((q.MAX_COLLIDE_RETURNS, q.F_COLUMNS)),
            parents,
            np.zeros((triangles + nodes, 2), np.int64),
            np.zeros(1, np.int64),
            np.zeros(q.MAX_NEAR_BOXES, np.int64),
        )


def _topology(types: Array, count: int) -> dict[str, Array]:
    """Which joints each of some bodies has, and which bodies are below each joint."""
    lists: list[list[int]] = [[] for _ in range(count)]
    below = np.zeros((len(types), count), np.bool_)
    for j, (_, one, two) in enumerate(types.tolist()):
        lists[one].insert(0, j)
        if two >= 0:
            lists[two].insert(0, j)
    for j in range(len(types) - 1, -1, -1):  # children come after their parents
        one = types[j, 1]
        below[j, one] = True
        for k in np.flatnonzero(types[:, 2] == one):
            below[j] |= below[k]
    return {
        "starts": np.cumsum([0, *map(len, lists)]).astype(np.int64),
        "lists": np.array([j for each in lists for j in each], np.int64),
        "below": below,
    }


def _state(
    numbers: Array,
    gravity: Array,
    bodies: Array,
    joints: Array,
    types: Array,
    scene: Scene,
    most: int,
) -> State:
    """What steps work with, with room for a number of contacts."""
    count, movable = len(bodies), len(joints)
    rows = 3 * most + q.MAX_JOINT_ROWS * movable
    work = np.zeros((count + 1, q.W_SIZE))  # the last is nobody's
    return State(
        settings=numbers,
        gravity=gravity,
        sequence=np.zeros(count, np.int64),
        system=System(bodies, work, joints, types, **_topology(types, count)),
        scene=scene,
        contacts=Contacts(
            rows=np.zeros((most, q.C_SIZE)),
            owners=np.full((most, 4), -1, np.int64),
            first_row=np.zeros(most, np.int64),
        ),
        constraints=Constraints(np.zeros((rows, q.R_SIZE)), np.zeros((rows, 6), np.int64)),
        blocks=make_blocks(movable, most, work),
        marks=np.zeros((4, max(most, count + 1, movable)), np.int64),
        result=np.zeros(1, np.int64),
        pids=np.zeros((movable, q.PID_SIZE)),
        active=np.zeros(3, np.int64),
        noted=np.zeros((MAX_NOTED_STEPS, movable)),
    )
