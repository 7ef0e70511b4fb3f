"""The arrays of the solver 'ode' (see quickstep/layout.py), built of an engine's bodies."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from bullet_sim.description.collisions import is_passable
from bullet_sim.description.model import Gears, Joint, Link
from bullet_sim.description.world import MAX_CONTACTS, OdeSettings
from bullet_sim.engine.api import WORLD, BodyLink
from bullet_sim.engine.efforts import MAX_RECORDED
from bullet_sim.engine.ode import tables
from bullet_sim.engine.ode.kinds import KINDS
from bullet_sim.engine.ode.owner import Owner
from bullet_sim.engine.ode.scene import (
    DynamicShapes,
    Solid,
    StaticShapes,
    capacity,
    may_collide,
    pack_scene,
)
from bullet_sim.engine.ode.shapes import ShapeCache
from bullet_sim.engine.quickstep import layout as q
from bullet_sim.engine.quickstep.state import (
    Constraints,
    ContactRecords,
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
    from bullet_sim.engine.ode.body import OdeBody

_ALL_BITS = 0xFFFF  # collide_bitmask of what has none
_MAX_NUMBERS = 1 << 20  # of records of states
_MOST_CONTACTS = 1 << 16  # contacts that are recorded, where one step has no more


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
class Contents:
    """What the arrays are built of.

    Attributes:
        moving, immobile: bodies by their numbers; one whose root link never moves is in both.
        filtered: collide_bitmask of links that have one.
        friction: coefficients of links for which one was set.
        attached: by any key.
        recorded: links whose contacts are recorded.
    """

    moving: dict[int, OdeBody] = field(default_factory=dict)
    immobile: dict[int, OdeBody] = field(default_factory=dict)
    filtered: dict[BodyLink, int] = field(default_factory=dict)
    friction: dict[BodyLink, float] = field(default_factory=dict)
    attached: dict[Any, Attachment] = field(default_factory=dict)
    recorded: set[BodyLink] = field(default_factory=set)

    def bits_of(self, link: BodyLink) -> int:
        """collide_bitmask of a link, which touches only what shares a bit."""
        return self.filtered.get(link, _ALL_BITS)


@dataclass
class Arrays:
    """What steps work with.

    Attributes:
        models: numbers of the bodies that move and have rows here.
        owner: the link of each row of bodies.
        rows: the other way round.
        inward: from the centers of mass to the links' frames [m].
        state, table: all numbers, as Python and as the compiled functions take them.
        attached: row of the joint of what is attached, by its key.
        planes, known: links of planes, and of others whose contacts quickstep finds.
        watch: bodies may come close to each other or to what never moves, but for planes.
        always: the mirror finds contacts of each step.
        sleepy: there are bodies that may sleep.
        passable: there are shapes that push nothing.
        finds_all: the mirror finds no contacts.
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
    passable: bool
    finds_all: bool


@dataclass
class SystemRows:
    """Rows of bodies and joints.

    Attributes:
        owner: the link of each row of bodies.
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
        self, engine: Owner, shapes: ShapeCache, settings: OdeSettings, contents: Contents
    ) -> None:
        self._engine, self._cache = engine, shapes
        self._settings, self._contents = settings, contents
        self._system, self._shapes = SystemRows(), DynamicShapes()
        self._placed: list[tuple[OdeBody, int, int]] = []  # and its first rows
        self._attached: dict[Any, int] = {}

    def build(self, numbers: Array, gravity: Array) -> Arrays:
        """Build them; rows of the models that move are where these say from then on.

        Args:
            numbers, gravity: settings of the solver, shared with the arrays.
        """
        contents, system = self._contents, self._system
        moving, static = contents.moving.values(), StaticShapes()
        for body in moving:
            self._add(body)
        for key, attachment in contents.attached.items():
            if attachment.is_on:
                self._attach(key, attachment)
        most = min(self._settings.max_contacts, MAX_CONTACTS)
        scene = self._scene(static, most)
        room = capacity(self._shapes, static, most)
        inward = [
            tuple((-body.model.links[name].center).tolist())
            for body in moving
            for name in body.names
        ]
        rows = np.array(inward, np.float64).reshape(-1, 3)
        contact_records = self._contact_records(static.known, room)
        state = _state(numbers, gravity, system.pack(), rows, scene, room, contact_records)
        for body, first, first_joint in self._placed:  # nothing can fail now
            body.use_rows(first, first_joint)
        return Arrays(
            models=set(contents.moving),
            owner=system.owner,
            rows={key: row for row, key in enumerate(system.owner)},
            inward=inward,
            state=state,
            table=make_table(state),
            attached=self._attached,
            planes=static.plane_links,
            known=static.known,
            watch=bool(static.aabbs or scene.may_collide.any()),
            always=bool(self._shapes.has_unknown() and static.planes),
            sleepy=any(body.may_sleep for body in moving),
            passable=any(body.has_passable for body in self._engine.bodies.values()),
            finds_all=not (
                self._shapes.has_unknown()
                or (scene.static_solid < 0).any()
                or (scene.may_collide == q.PAIR_EXTERNAL).any()
            ),
        )

    def _contact_records(self, known: Sequence[BodyLink], room: int) -> ContactRecords:
        """Room for contacts of recorded steps, of which each may have `room`."""
        places = {number: place for place, number in enumerate(self._contents.immobile)}
        rows = [row for row, key in enumerate(self._system.owner) if key in self._contents.recorded]
        count = max(room * len(rows), min(MAX_RECORDED * room * len(rows), _MOST_CONTACTS))
        return ContactRecords(
            bodies=np.array(rows, np.int64),
            chosen=np.zeros((count, q.CR_SIZE), np.int64),
            numbers=np.zeros((count, 16)),
            ends=np.zeros(MAX_RECORDED, np.int64),
            spaces=np.array([places.get(link[0], -1) for link in known], np.int64),
        )

    def _scene(self, static: StaticShapes, most: int) -> Scene:
        """The shapes; `static` gets those of what never moves.

        Args:
            most: contacts of a pair of shapes.
        """
        contents, system = self._contents, self._system
        solids: list[Solid] = []
        for body in contents.immobile.values():
            link = body.number, body.model.root
            static.add(link, body.root, body.base, contents.bits_of(link), self._cache, solids)
        bodies = [number for number, _ in system.owner]
        bits = np.array([contents.bits_of(link) for link in system.owner], np.int64)
        collide = may_collide(bodies, self._shapes, bits, system.touching, system.attached)
        spaces = system.spaces, system.counts
        scene = pack_scene(self._shapes, static, solids, bodies, *spaces, bits, collide)
        for table, column in (
            (scene.shapes, q.G_MOST), (scene.faces, q.P_MOST), (scene.planes, q.P_MOST),
        ):  # fmt: skip
            np.minimum(table[:, column], most, out=table[:, column])
        return scene

    def _add(self, body: OdeBody) -> None:
        """Rows of a body that moves."""
        system, links = self._system, body.model.links
        first, first_joint = len(system.bodies), len(system.joints)
        rows = {name: first + i for i, name in enumerate(body.names)}
        colliding = {name for name, link in links.items() if link.self_collide}
        if body.collisions and not colliding:  # the model says so, for all of them
            colliding = set(body.names)
        shared = len(system.counts)
        system.counts.append(0)
        for name in body.names:
            space = len(system.counts) if name in colliding else shared
            system.counts += [0] * (space == len(system.counts))
            system.counts[space] += len(links[name].collisions)
            system.spaces.append(space)
        for name in body.names:
            link, key = links[name], (body.number, name)
            friction = self._contents.friction.get(key)
            row = tables.body_row(link, self._settings.max_speed)
            row[q.MAY_SLEEP] = float(body.may_sleep)
            for shape in link.collisions:
                if not is_passable(shape, link):
                    reach = self._shapes.add(rows[name], link, shape, self._cache, friction)
                    row[q.RADIUS] = max(row[q.RADIUS], reach)
            system.owner.append(key)
            system.bodies.append(row)
        system.touching += [
            (rows[one], rows[two]) for one, two in body.collisions if one in rows and two in rows
        ]
        for joint in body.tree:
            system.joints.append(self._joint_row(body, joint))
            kind = q.FIXED if joint.name in body.welded else KINDS[joint.kind].code
            one, two = rows.get(joint.child, -1), rows.get(joint.parent, -1)
            system.types.append((kind, one, two) if one >= 0 else (kind, two, one))
        for gears in body.gears:
            system.joints.append(self._gear_row(body, gears, rows))
            system.types.append((q.GEARS, rows[gears.first], rows[gears.second]))
        self._placed.append((body, first, first_joint))

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
        center: Array | None = None
        if other < 0 and parent != WORLD:
            frame = self._engine.frame_of(parent) * frame
        elif other >= 0:
            center = self._link(parent).center
            system.attached.append((one, other))
        for number in (one, other):
            if number >= 0:
                system.bodies[number][q.MAY_SLEEP] = 0.0
        self._attached[key] = len(system.joints)
        joint = joint or Joint("", "fixed", "", "")
        row = self._moving_row(joint, self._link(child), frame, center, at=joint.anchor)
        system.joints.append(row)
        system.types.append((KINDS[joint.kind].code, one, other))

    def _link(self, link: BodyLink) -> Link:
        """The description of a link that moves."""
        return self._contents.moving[link[0]].model.links[link[1]]

    def _joint_row(self, body: OdeBody, joint: Joint) -> Array:
        if joint.holds:
            frame = body.start * body.at_rest[joint.child]
            return self._moving_row(joint, body.model.links[joint.child], frame, None)
        (child, inside), (parent, frame) = (joint.child, joint.anchor), (joint.parent, joint.origin)
        links, still = body.model.links, body.model.root if body.is_fixed else ""
        if joint.closes:
            if child == still:  # the other one moves, the other way
                (child, inside), (parent, frame) = (parent, frame), (child, inside)
                x, y, z = joint.axis
                joint = replace(joint, axis=(-x, -y, -z))
            frame = frame * inside.inverse()
        center: Array | None = links[parent].center
        if parent == still:
            frame, center = body.base * frame, None
        at, welded = inside if joint.closes else None, joint.name in body.welded
        return self._moving_row(joint, links[child], frame, center, welded, at)

    def _moving_row(
        self,
        joint: Joint,
        child: Link,
        frame: Pose,
        center: Array | None,
        welded: bool = False,
        at: Pose | None = None,
    ) -> Array:
        """Row of a joint.

        Args:
            frame: of the child, in that of the second body, at position 0.
            center: of mass of the second body, in its frame (3,) [m]; None: that is the world.
            welded: it is a fixed one.
            at: joint's frame in the child's; None: they are one.
        """
        axis, place = np.array(joint.axis) / np.linalg.norm(joint.axis), np.zeros(3)
        if at is not None:
            axis, place = at.matrix @ axis, np.array(at.position)
        anchor = np.array(frame.position)
        if center is not None:
            anchor = anchor - center
        if center is not None and (welded or joint.kind == "fixed"):
            # ODE's fixed joint (fixed.cpp) holds the center of the second body by the first one.
            row = _placed_row(frame, axis, np.zeros(3))
            row[q.ANCHOR1 : q.ANCHOR1 + 3] = frame.matrix.T @ -anchor - child.center
        elif welded or KINDS[joint.kind].at_center:
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
    def _gear_row(body: OdeBody, gears: Gears, rows: Mapping[str, int]) -> Array:
        frames = body.at_rest
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


def _state(
    numbers: Array,
    gravity: Array,
    system: System,
    inward: Array,
    scene: Scene,
    room: int,
    contact_records: ContactRecords,
) -> State:
    """What steps work with, with room for a number of contacts."""
    count, movable = len(system.bodies), len(system.joints)
    rows = q.MAX_CONTACT_ROWS * room + q.MAX_JOINT_ROWS * movable
    width = count * q.SR_BODY + movable * (q.SR_JOINT + q.SR_EFFORT)
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
        efforts=np.zeros((movable, q.PID_SIZE)),
        active=np.zeros(3, np.int64),
        recorded=np.zeros((2 * MAX_RECORDED, movable)),
        states=np.zeros((max(1, min(MAX_RECORDED, _MAX_NUMBERS // max(width, 1))), width)),
        taken=np.zeros(2, np.int64),
        inward=inward,
        held=np.zeros((count, q.HELD_SIZE)),
        holding=np.zeros(2, np.int64),
        contact_records=contact_records,
    )
