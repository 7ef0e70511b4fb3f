"""The arrays of the solver 'ode' (see quickstep/layout.py), built of an engine's bodies."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from operator import itemgetter
from typing import TYPE_CHECKING, Any, Callable, Tuple

import numpy as np

from bullet_sim.controllers.effort_row import MAX_NOTED_STEPS
from bullet_sim.description.lump import LumpedModel
from bullet_sim.description.model import Gears, Joint, Link
from bullet_sim.description.world import MAX_CONTACTS, OdeSettings
from bullet_sim.engine import tables
from bullet_sim.engine.ode_scene import (
    BodyLink,
    DynamicShapes,
    Solids,
    StaticShapes,
    capacity,
    may_collide,
    pack_scene,
)
from bullet_sim.engine.ode_shapes import ShapeCache
from bullet_sim.engine.passable import is_passable
from bullet_sim.engine.quickstep import layout as q
from bullet_sim.engine.quickstep.state import (
    Constraints,
    Contacts,
    Scene,
    State,
    System,
    aligned_zeros,
    make_blocks,
    make_islands,
    make_table,
)
from bullet_sim.pose import Array, Pose, Vec3

if TYPE_CHECKING:
    from bullet_sim.engine.engine import Engine

_ALL_BITS = 0xFFFF  # collide_bitmask of what has none

Measured = Callable[[Any], Tuple[float, ...]]


@dataclass
class DynamicModel:
    """A model that moves.

    Attributes:
        names: of its links that move, in the order in which Gazebo creates them.
        joints: of these links, in the same order.
        links: name -> PyBullet's index.
        may_sleep: it may sleep while it rests, as what has no joints does in Gazebo.
        touching: pairs of its links that collide with each other.
        first, first_joint: its first rows of bodies and of joints.
        order: row of each of the engine's joints.
        measured: gives their positions, velocities and motors' efforts of the flat table of joints.
        frame: of the root link where the rows were put last.
        gears: of its links that move; they have rows after those of the joints.
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
    frame: Pose = Pose()
    gears: list[Gears] = field(init=False)

    def __post_init__(self) -> None:
        moving = set(self.names)
        self.gears = [each for each in self.shapes.gears if {each.first, each.second} <= moving]

    @property
    def rows(self) -> int:
        """How many rows of joints it has."""
        return len(self.joints) + len(self.gears)

    def link(self, row: int) -> Link:
        """The link of a row of bodies."""
        return self.shapes.links[self.names[row - self.first]]

    def joint(self, number: int) -> Joint:
        """The joint of a number of the engine's."""
        return self.joints[self.order[number] - self.first_joint]


@dataclass
class StaticModel:
    """A model that never moves: PyBullet's number, its link."""

    body: int
    link: Link


WORLD: BodyLink = (-1, -1)


@dataclass(frozen=True)
class Attachment:
    """A link that is held where it was relative to another one, or by a joint.

    Attributes:
        parent, child: (body, link); the parent may be WORLD where there is a joint.
        frame: pose of the child's frame in the parent's.
        is_on: it is held now.
        joint: of the two, at whose position 0 they are so; None: they are held as they are.
    """

    parent: BodyLink
    child: BodyLink
    frame: Pose
    is_on: bool = True
    joint: Joint | None = None


@dataclass
class Models:
    """What the arrays are built of.

    Attributes:
        moving, static: models by PyBullet's number; one whose root link never moves is in both.
        filtered: collide_bitmask of links that have one.
        ghosts: bodies that touch only what never moves.
        friction: coefficients of links for which one was set.
        attached: by any key.
    """

    moving: dict[int, DynamicModel] = field(default_factory=dict)
    static: dict[int, StaticModel] = field(default_factory=dict)
    filtered: dict[BodyLink, int] = field(default_factory=dict)
    ghosts: set[int] = field(default_factory=set)
    friction: dict[BodyLink, float] = field(default_factory=dict)
    attached: dict[Any, Attachment] = field(default_factory=dict)

    def bits_of(self, key: BodyLink) -> int:
        """collide_bitmask of a (body, link), which touches only what shares a bit."""
        return self.filtered.get(key, _ALL_BITS)


@dataclass
class Arrays:
    """What steps work with.

    Attributes:
        models: PyBullet's numbers of the bodies that move and have rows here.
        owner: (body, link) of each row of bodies.
        rows: the other way round.
        inward: from the centers of mass to the links' frames [m].
        state, table: all numbers, as Python and as the compiled functions take them.
        attached: row of the joint of what is attached, by its key.
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
    attached: dict[Any, int]
    planes: list[BodyLink]
    known: list[BodyLink]
    watch: bool
    always: bool
    sleepy: bool


@dataclass
class SystemRows:
    """Rows of bodies and joints.

    Attributes:
        owner: (body, link) of each row of bodies.
        bodies, joints, types: rows of System.
        touching: pairs of bodies that collide in their model.
        attached: pairs of bodies that are attached to each other, and so do not collide.
        spaces: number of each body's space, and how many shapes each space has.
    """

    owner: list[BodyLink] = field(default_factory=list)
    spaces: list[int] = field(default_factory=list)
    counts: list[int] = field(default_factory=list)
    bodies: list[Array] = field(default_factory=list)
    joints: list[Array] = field(default_factory=list)
    types: list[tuple[int, int, int]] = field(default_factory=list)
    touching: list[tuple[int, int]] = field(default_factory=list)
    attached: list[tuple[int, int]] = field(default_factory=list)

    def _beyond(self, joint: int, lists: Sequence[Sequence[int]]) -> list[int]:
        """Bodies that a joint moves when it is put to a position; none if it is part of a loop.

        Those that joints connect with its first body, without passing its second one, as in
        Gazebo's Joint::FindAllConnectedLinks.

        Args:
            lists: joints of each body.
        """
        _, one, two = self.types[joint]
        found, pending = {one}, [one]
        while pending:
            body = pending.pop()
            for other in lists[body]:
                kind, *ends = self.types[other]
                if other == joint or kind == q.GEARS:
                    continue
                reached = ends[0] if ends[1] == body else ends[1]
                if reached == two:
                    return []
                if reached >= 0 and reached not in found:
                    found.add(reached)
                    pending.append(reached)
        return sorted(found)

    def pack(self) -> System:
        """The arrays of these; joints of what is attached are the last ones."""
        count = len(self.bodies)
        types = tables.table(self.types, 3, np.int64)
        lists: list[list[int]] = [[] for _ in range(count)]
        for j, (_, one, two) in enumerate(self.types):
            lists[one].insert(0, j)
            if two >= 0:
                lists[two].insert(0, j)
        below = np.zeros((len(types), count), np.bool_)
        for j in range(len(types)):
            below[j, self._beyond(j, lists)] = True
        return System(
            bodies=tables.table(self.bodies, q.B_SIZE),
            work=aligned_zeros(count + 1, q.W_SIZE),
            joints=tables.table(self.joints, q.J_SIZE),
            types=types,
            starts=np.cumsum([0, *map(len, lists)]).astype(np.int64),
            lists=np.array([j for each in lists for j in each], np.int64),
            below=below,
        )


class ArrayBuilder:
    """Builds the arrays of what is there now, once.

    Args:
        settings: of the world.
    """

    def __init__(
        self, engine: Engine, shapes: ShapeCache, settings: OdeSettings, models: Models
    ) -> None:
        self._engine, self._cache = engine, shapes
        self._settings, self._models = settings, models
        self._system, self._shapes = SystemRows(), DynamicShapes()
        self._placed: list[tuple[DynamicModel, int, int, list[int], Measured]] = []  # and its rows
        self._attached: dict[Any, int] = {}

    def build(self, numbers: Array, gravity: Array) -> Arrays:
        """Build them; rows of the models that move are where these say from then on.

        Args:
            numbers, gravity: settings of the solver, shared with the arrays.
        """
        models, system = self._models, self._system
        moving, static, solids = models.moving.values(), StaticShapes(), Solids()
        for model in moving:
            self._add(model)
        for key, attachment in models.attached.items():
            if attachment.is_on:
                self._attach(key, attachment)
        for body, immobile in models.static.items():
            frame, mask = Pose(*self._engine.base_pose(body)), models.bits_of((body, -1))
            static.add(body, immobile.link, frame, mask, self._cache, solids)
        bodies = [body for body, _ in system.owner]
        bits = np.array([models.bits_of(key) for key in system.owner], np.int64)
        collide = may_collide(
            bodies, self._shapes, bits, models.ghosts, system.touching, system.attached
        )
        spaces = system.spaces, system.counts
        scene = pack_scene(self._shapes, static, solids, bodies, *spaces, bits, collide)
        most = min(self._settings.max_contacts, MAX_CONTACTS)
        for table, column in (
            (scene.shapes, q.G_MOST), (scene.faces, q.P_MOST), (scene.planes, q.P_MOST),
        ):  # fmt: skip
            np.minimum(table[:, column], most, out=table[:, column])
        room = capacity(self._shapes, static, most)
        state = _state(numbers, gravity, system.pack(), scene, room)
        for model, first, first_joint, order, measured in self._placed:  # nothing can fail now
            model.first, model.first_joint = first, first_joint
            model.order, model.measured = order, measured
        return Arrays(
            models=set(models.moving),
            owner=system.owner,
            rows={key: row for row, key in enumerate(system.owner)},
            inward=[
                tuple((-model.shapes.links[name].center).tolist())
                for model in moving
                for name in model.names
            ],
            state=state,
            table=make_table(state),
            attached=self._attached,
            planes=static.plane_links,
            known=static.known,
            watch=bool(static.aabbs or collide.any()),
            always=bool(self._shapes.has_unknown() and static.planes),
            sleepy=any(model.may_sleep for model in moving),
        )

    def _add(self, model: DynamicModel) -> None:
        """Rows of a model that moves."""
        system = self._system
        first, first_joint = len(system.bodies), len(system.joints)
        rows = {name: first + i for i, name in enumerate(model.names)}
        colliding = {name for name, link in model.shapes.links.items() if link.self_collide}
        if model.touching and not colliding:  # the model says so, for all of them
            colliding = set(model.names)
        shared = len(system.counts)
        system.counts.append(0)
        for name in model.names:
            link = model.shapes.links[name]
            space = len(system.counts) if name in colliding else shared
            system.counts += [0] * (space == len(system.counts))
            system.counts[space] += len(link.collisions)
            system.spaces.append(space)
        for name in model.names:
            link, key = model.shapes.links[name], (model.body, model.links[name])
            friction = self._models.friction.get(key)
            row = tables.body_row(link, self._settings.max_speed)
            row[q.MAY_SLEEP] = float(model.may_sleep)
            for shape in link.collisions:
                if not is_passable(shape, link):
                    reach = self._shapes.add(rows[name], link, shape, self._cache, friction)
                    row[q.RADIUS] = max(row[q.RADIUS], reach)
            system.owner.append(key)
            system.bodies.append(row)
        system.touching += [
            (rows[one], rows[two]) for one, two in model.touching if one in rows and two in rows
        ]
        for joint in model.joints:
            system.joints.append(self._joint_row(model, joint))
            kind = q.FIXED if joint in model.shapes.welds else _kind(joint)
            one, two = rows.get(joint.child, -1), rows.get(joint.parent, -1)
            system.types.append((kind, one, two) if one >= 0 else (kind, two, one))
        for gears in model.gears:
            system.joints.append(self._gear_row(model, gears, rows))
            system.types.append((q.GEARS, rows[gears.first], rows[gears.second]))
        place = {joint.name: first_joint + i for i, joint in enumerate(model.joints)}
        order = [place[name] for name in self._engine.joint_names(model.body)]
        measured: Measured = tuple
        if order:
            columns = np.array((q.ANGLE, q.RATE, q.MOTOR))[:, None]
            places = columns + q.J_SIZE * np.array(order)
            measured = itemgetter(*places.ravel().tolist())
        self._placed.append((model, first, first_joint, order, measured))

    def _attach(self, key: Any, attachment: Attachment) -> None:
        """A joint of two links, of which one may never move."""
        system, joint = self._system, attachment.joint
        rows = {owner: row for row, owner in enumerate(system.owner)}
        (parent, child), frame = (attachment.parent, attachment.child), attachment.frame
        if child not in rows and joint is None:
            parent, child, frame = child, parent, frame.inverse()
        if child not in rows:
            return  # neither moves
        one, other = rows[child], rows.get(parent, -1)
        center = np.zeros(3)
        if other < 0 and parent != WORLD:
            frame = Pose(*self._engine.link_motion(*parent)[:2]) * frame
        elif other >= 0:
            center = self._link(parent).center
            system.attached.append((one, other))
        for number in (one, other):
            if number >= 0:
                system.bodies[number][q.MAY_SLEEP] = 0.0
        self._attached[key] = len(system.joints)
        if joint is not None and joint.kind != "fixed":
            row = self._moving_row(joint, self._link(child), frame, center, at=joint.anchor)
            system.joints.append(row)
            system.types.append((_kind(joint), one, other))
            return
        anchor = np.array(frame.position) - center + frame.matrix @ self._link(child).center
        row = _placed_row(frame, np.array((0.0, 0.0, 1.0)), anchor)
        row[q.LOWER], row[q.UPPER] = 1.0, -1.0
        row[q.STOP_ERP], row[q.STOP_CFM] = self._settings.erp, self._settings.cfm
        row[q.STOP_PUSH] = 1.0
        system.joints.append(row)
        system.types.append((q.FIXED, one, other))

    def _link(self, key: BodyLink) -> Link:
        """The link of a (body, link) that moves."""
        model = self._models.moving[key[0]]
        return next(model.shapes.links[name] for name in model.names if model.links[name] == key[1])

    def _joint_row(self, model: DynamicModel, joint: Joint) -> Array:
        (child, inside), (parent, frame) = (joint.child, joint.anchor), (joint.parent, joint.origin)
        welded, still = joint in model.shapes.welds, model.shapes.root if model.is_fixed else ""
        if joint.closes:
            if child == still:  # the other one moves, the other way
                (child, inside), (parent, frame) = (parent, frame), (child, inside)
                x, y, z = joint.axis
                joint = replace(joint, axis=(-x, -y, -z))
            frame = frame * inside.inverse()
        link, center = model.shapes.links[child], model.shapes.links[parent].center
        if parent == still:
            frame, center = Pose(*self._engine.base_pose(model.body)) * frame, np.zeros(3)
        at = inside if joint.closes else None
        return self._moving_row(joint, link, frame, center, welded, at)

    def _moving_row(
        self,
        joint: Joint,
        child: Link,
        frame: Pose,
        center: Array,
        welded: bool = False,
        at: Pose | None = None,
    ) -> Array:
        """Row of a joint.

        Args:
            frame: of the child, in that of the second body, at position 0.
            center: of mass of the second body, in its frame (3,) [m].
            welded: it is a fixed one.
            at: joint's frame in the child's; None: they are one.
        """
        axis, place = np.array(joint.axis) / np.linalg.norm(joint.axis), np.zeros(3)
        if at is not None:
            axis, place = at.matrix @ axis, np.array(at.position)
        anchor = np.array(frame.position) - center
        if joint.kind == "prismatic" or welded:  # where the child's center is
            row = _placed_row(frame, axis, anchor + frame.matrix @ child.center)
        else:
            row = _placed_row(frame, axis, anchor + frame.matrix @ place)
            row[q.ANCHOR1 : q.ANCHOR1 + 3] = place - child.center
        lower, upper = joint.lower, joint.upper
        row[q.LOWER], row[q.UPPER] = (1.0, -1.0) if lower is None else (lower, upper)
        row[q.DAMPING], row[q.FMAX] = joint.damping, joint.friction
        row[q.IMPLICIT] = float(joint.implicit_damping)
        row[q.STIFFNESS], row[q.AT_REST] = joint.stiffness, joint.rest
        erp, cfm = joint.stop_erp, joint.stop_cfm
        row[q.STOP_ERP] = self._settings.erp if erp is None else erp
        row[q.STOP_CFM] = self._settings.cfm if cfm is None else cfm
        row[q.STOP_PUSH] = joint.stop_push
        row[q.ERP], row[q.CFM] = _or_worlds(joint.erp), _or_worlds(joint.cfm)
        row[q.BOUNCE], row[q.PITCH] = joint.bounce, joint.thread
        if joint.motor is not None:
            row[q.FMAX], row[q.SPEED] = joint.motor
        return row

    @staticmethod
    def _gear_row(model: DynamicModel, gears: Gears, rows: Mapping[str, int]) -> Array:
        frames = {model.shapes.root: Pose()}
        for joint in (*model.joints, *model.shapes.loose):
            frames[joint.child] = frames[joint.parent] * joint.origin
        base = frames[gears.base].inverse()
        row = np.zeros(q.J_SIZE)
        row[q.AXIS1 : q.AXIS1 + 3], row[q.AXIS2 : q.AXIS2 + 3] = gears.axis, gears.second_axis
        row[q.QREL : q.QREL + 4] = (base * frames[gears.first]).orientation
        second = (base * frames[gears.second]).orientation
        row[q.GEAR_BASE] = rows.get(gears.base, -1)
        row[q.GEAR_QREL : q.GEAR_QREL + 4] = second
        row[q.TARGET] = row[q.IMPOSED] = math.nan
        row[q.LOWER], row[q.UPPER] = 1.0, -1.0
        row[q.ERP], row[q.CFM] = _or_worlds(gears.erp), _or_worlds(gears.cfm)
        row[q.PITCH] = gears.ratio
        return row


def _kind(joint: Joint) -> int:
    """Kind of a joint's rows."""
    return {"prismatic": q.SLIDER, "screw": q.SCREW}.get(joint.kind, q.HINGE)


def _or_worlds(value: float | None) -> float:
    """A joint's ERP or CFM in its row."""
    return -1.0 if value is None else value


def _placed_row(frame: Pose, axis: Array, anchor: Array) -> Array:
    """Row of a joint without a command.

    Args:
        frame: of the joint, in that of the second body.
        axis: (3,) in the joint's frame.
        anchor: (3,) [m] relative to the second body's center of mass, along its axes.
    """
    row = np.zeros(q.J_SIZE)
    row[q.ANCHOR2 : q.ANCHOR2 + 3] = anchor
    row[q.AXIS1 : q.AXIS1 + 3], row[q.AXIS2 : q.AXIS2 + 3] = axis, frame.matrix @ axis
    row[q.QREL : q.QREL + 4] = frame.orientation
    row[q.TARGET] = row[q.IMPOSED] = math.nan
    row[q.ERP] = row[q.CFM] = -1.0
    return row


def _state(numbers: Array, gravity: Array, system: System, scene: Scene, room: int) -> State:
    """What steps work with, with room for a number of contacts."""
    count, movable = len(system.bodies), len(system.joints)
    rows = q.MAX_CONTACT_ROWS * room + q.MAX_JOINT_ROWS * movable
    return State(
        settings=numbers,
        gravity=gravity,
        sequence=np.zeros(count, np.int64),
        system=system,
        scene=scene,
        contacts=Contacts(
            rows=np.zeros((room, q.C_SIZE)),
            owners=np.full((room, 4), -1, np.int64),
            first_row=np.zeros(room, np.int64),
        ),
        constraints=Constraints(np.zeros((rows, q.R_SIZE)), np.zeros((rows, 6), np.int64)),
        blocks=make_blocks(movable, room, system.work),
        islands=make_islands(count),
        marks=np.zeros((4, max(room, count + 1, movable)), np.int64),
        result=np.zeros(1, np.int64),
        pids=np.zeros((movable, q.PID_SIZE)),
        active=np.zeros(3, np.int64),
        noted=np.zeros((MAX_NOTED_STEPS, movable)),
    )
