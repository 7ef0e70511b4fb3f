"""A model in the engine 'ode': its rows of the solver's arrays."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from operator import itemgetter
from typing import Any, Callable, Tuple

import numpy as np

from bullet_sim.description.collisions import is_passable
from bullet_sim.description.lump import LumpedModel
from bullet_sim.description.mirrors import (
    chain_of,
    free_coordinates,
    mirrored_joints,
    mirrored_links,
)
from bullet_sim.description.model import Gears, Joint, Link, ModelDescription
from bullet_sim.engine.api import Contact, ContactRows, JointState, Touch, contact_rows
from bullet_sim.engine.ode import tables
from bullet_sim.engine.ode.kinds import KINDS
from bullet_sim.engine.ode.motor import OdeMotor
from bullet_sim.engine.ode.owner import Owner
from bullet_sim.engine.quickstep import layout as q
from bullet_sim.pose import (
    UNTURNED,
    Array,
    Motion,
    Pose,
    Quat,
    Vec3,
    Vector,
    compose,
    matrix_from_quaternion,
    vector3,
    velocity_at,
)

_ROUNDING = 1e-15  # [m] and of a quaternion: what is left of 0 between two frames
_STILL = (0.0, 0.0, 0.0)
_NOWHERE = (math.nan, math.nan, math.nan)

Measured = Callable[[Any], Tuple[float, ...]]
State = Tuple[Vec3, Quat, Vec3, Vec3, Vec3]  # pose of a frame; its center of mass, both velocities


def _without_rounding(values: Vector) -> Any:
    """Values with exact zeros: in Gazebo a robot that is balanced on two wheels stands by them."""
    return tuple(0.0 if abs(value) < _ROUNDING else value for value in values)


@dataclass
class Placement:
    """Where a body is put in the next step: pose of its root link's frame, velocity of the center
    of mass of this link [m/s, rad/s], (position, velocity) of each joint."""

    pose: Pose
    linear: Vec3
    angular: Vec3
    joints: list[tuple[float, float]]


class OdeBody:
    """See api.Body. What never moves has no rows, only a pose.

    Attributes:
        number, links, joints: of api.Body.
        model: of which it was made.
        is_static: it never moves.
        is_fixed: its root link never moves.
        may_sleep: it may sleep while it rests, as what has no joints does in Gazebo.
        collisions: pairs of its links that collide with each other.
        welded: names of joints that do not move.
        has_passable: it has shapes that push nothing.
        motors: those of `joints`.
        names: of its links that move, in the order in which Gazebo creates them.
        tree: joints of these links, in the order in which Gazebo creates them.
        gears: of its links that move; they have rows after those of the joints.
        first, first_joint: its first rows of bodies and of joints.
        order: row of each of `joints`.
        start: where it was added, and where what holds its links in the world has them.
        measured: gives their positions, velocities and motors' efforts of the flat table of joints.
        frame: of the root link where the rows were put last.
        placement: where it is to be put; None: where its rows are.
        has_started: its rows have been where something is.
    """

    def __init__(
        self,
        engine: Owner,
        number: int,
        model: LumpedModel,
        description: ModelDescription,
        pose: Pose,
    ) -> None:
        self._engine, self.number, self.model = engine, number, model
        self.is_static = description.static
        self.is_fixed = description.static or model.fixed_base
        self.collisions: Sequence[tuple[str, str]] = ()
        self.links = mirrored_links(model)
        listed = (*model.joints, *model.welds)
        self.joints = [joint.name for joint in listed]
        self.welded = {joint.name for joint in model.welds}
        self.has_passable = any(
            is_passable(shape, link) for link in model.links.values() for shape in link.collisions
        )
        still = model.root if self.is_fixed else ""
        self.names = [name for name in model.links if name != still]
        self._root_place = 0 if self.is_fixed else self.names.index(model.root)
        self.tree = self._in_order(listed, description)
        moving = set(self.names)
        self.gears: list[Gears] = [g for g in model.gears if {g.first, g.second} <= moving]
        self.may_sleep = (
            description.auto_disable
            and not description.has_sensors
            and not self.is_fixed
            and not self.tree
            and (description.is_urdf or not description.joints)  # a URDF's fixed ones are merged
        )
        self.motors = [OdeMotor(engine, self, number) for number in range(len(self.joints))]
        self.first = self.first_joint = 0
        self.order: list[int] = []
        self.measured: Measured = tuple
        self.frame, self.has_started = Pose(), False
        self.placement: Placement | None = Placement(
            pose, _STILL, _STILL, [(0.0, 0.0)] * len(self.joints)
        )
        self.base = self.start = pose  # where it was put last, or stays; where it was added

    def _in_order(self, listed: Sequence[Joint], description: ModelDescription) -> list[Joint]:
        """Joints in the order in which Gazebo creates them: of an SDF as they are in the file, of a
        URDF those of the links, what closes a loop behind those that come before it in the file."""
        order = {name: number for number, name in enumerate(description.joints)}
        given = sorted(listed, key=lambda joint: order.get(joint.name, len(order)))
        if not description.is_urdf:
            return given
        below = {joint.child: joint for joint in self.model.tree()}
        tree = [below[name] for name in self.model.links if name in below]
        for number, joint in enumerate(given):
            if not joint.closes:
                continue
            before = {each.name for each in given[:number]}
            if not description.joints[joint.name].closes:  # below a root `world`
                links = list(self.model.links)
                above = set(links[: links.index(joint.child)])
                before = {each.name for each in tree if each.child in above}
            places = [place for place, each in enumerate(tree, 1) if each.name in before]
            tree.insert(max(places, default=0), joint)
        return tree

    @cached_property
    def _outward(self) -> list[tuple[int, Joint]]:
        """The joints but those that close loops, parents first, each with its place in `tree`."""
        below: dict[str, list[tuple[int, Joint]]] = {}
        for place, joint in enumerate(self.tree):
            if not joint.closes:
                below.setdefault(joint.parent, []).append((place, joint))
        found: list[tuple[int, Joint]] = []
        for name in (pending := [self.model.root, *(each.child for each in self.model.loose)]):
            found += below.get(name, ())
            pending += [joint.child for _, joint in below.get(name, ())]
        return found

    # What it is made of -------------------------------------------------------------------------
    @property
    def moves(self) -> bool:
        """See api.Body."""
        return not self.is_fixed or bool(self.joints) or bool(self.model.loose)

    @property
    def root(self) -> Link:
        """The root link, which is all of a static body."""
        return self.model.links[self.model.root]

    @property
    def row_count(self) -> int:
        """How many rows of joints it has."""
        return len(self.tree) + len(self.gears)

    @property
    def rows(self) -> Array:
        """Its rows of bodies."""
        return self._engine.rows[self.first : self.first + len(self.names)]

    @property
    def joint_rows(self) -> Array:
        """Its rows of joints."""
        return self._engine.joint_rows[self.first_joint : self.first_joint + self.row_count]

    def link(self, row: int) -> Link:
        """The link of a row of bodies."""
        return self.model.links[self.names[row - self.first]]

    def use_rows(self, first: int, first_joint: int) -> None:
        """Have its rows begin here."""
        self.first, self.first_joint = first, first_joint
        rows = {joint.name: row for row, joint in enumerate(self.tree, first_joint)}
        self.order = [rows[name] for name in self.joints]
        for motor, row in zip(self.motors, self.order):
            motor.row, motor.joint = row, self.tree[row - first_joint]
        if self.order:
            columns = np.array((q.ANGLE, q.RATE, q.MOTOR))[:, None]
            places = columns + q.J_SIZE * np.array(self.order)
            self.measured = itemgetter(*places.ravel().tolist())

    def motor(self, joint: str) -> OdeMotor:
        """See api.Body."""
        return self.motors[self.joints.index(joint)]

    # Where it is put ----------------------------------------------------------------------------
    def place(self) -> Placement:
        """Where it is now, which is taken over before the next step: to be changed."""
        self.placement = placement = self.present()
        self._engine.note_placed(self)
        return placement

    def present(self) -> Placement:
        """A Placement of where it is now."""
        if self.placement is not None:
            return self.placement
        if self.is_static or not np.isfinite(self.rows[:, : q.PLACE]).all():
            return Placement(self.base, _STILL, _STILL, []) if self.is_static else self._lost()
        rows = self._engine.joint_rows[self.order][:, [q.ANGLE, q.RATE]] if self.order else None
        joints = [] if rows is None else [(angle, rate) for angle, rate in rows.tolist()]
        if self.is_fixed:
            return Placement(self.base, _STILL, _STILL, joints)
        position, orientation, _, linear, angular = self._link_state(self.model.root)
        return Placement(Pose(position, orientation), linear, angular, joints)

    def has_rows(self) -> bool:
        """Whether the arrays have its rows; they are built before the next step."""
        return self.number in self._engine.arrays.models

    def set_pose(self, position: Vector, orientation: Vector) -> None:
        """See api.Body."""
        self._engine.placements += 1
        placement = self.place()
        x, y, z, w = map(float, orientation)
        self.base = placement.pose = Pose(vector3(position), (x, y, z, w))
        placement.linear = placement.angular = _STILL

    def set_joint_positions(self, positions: Vector) -> None:
        """See api.Body."""
        if self.joints:
            self.place().joints = [(float(position), 0.0) for position in positions]

    def gather(self) -> None:
        """See api.Body."""
        self.place()
        self.has_started = False

    def settle(self) -> None:
        """Put the rows where the placement says."""
        placement = self.placement
        assert placement is not None
        self.placement = None
        if self.is_static:
            return
        joints = self._engine.joint_rows
        for row, (position, velocity) in zip(self.order, placement.joints):
            joints[row, q.ANGLE] = joints[row, q.REACHED] = position
            joints[row, q.RATE] = velocity
        self._place_links(placement)
        self.wake()

    def _place_links(self, placement: Placement) -> None:
        """Put links where the base and the joints' positions have them."""
        model, orientation = self.model, placement.pose.orientation
        center, _ = compose(placement.pose.position, orientation, self._center, UNTURNED)
        linear = velocity_at(placement.pose.position, center, placement.linear, placement.angular)
        pose = Pose(_without_rounding(placement.pose.position), _without_rounding(orientation))
        root: tuple[Pose, Any, Any] = (pose, linear, placement.angular)
        motions = {model.root: root}
        before, self.frame = self._root_frame(), pose
        for joint in model.loose:
            motions[joint.child] = pose * joint.origin, linear, placement.angular
            if before is not None:  # it stays where it is relative to the root link
                there = before.inverse() * self._frame(joint.child)
                velocity, spin = self._velocity(joint.child)
                motions[joint.child] = pose * there, velocity, spin
        self.has_started = True
        rows = self.joint_rows
        for place, joint in self._outward:
            row = rows[place]
            pose, velocity, spin = motions[joint.parent]
            axis = np.array(joint.axis) / np.linalg.norm(joint.axis)
            frame = pose * joint.origin
            frame, moved, turned = KINDS[joint.kind].place(frame, frame.matrix @ axis, axis, row)
            arm = np.subtract(frame.position, pose.position)
            velocity = np.add(velocity, np.cross(spin, arm)) + moved
            motions[joint.child] = frame, velocity, np.add(spin, turned)
        for name, row in zip(self.names, self.rows):
            pose, velocity, spin = motions[name]
            arm = pose.matrix @ model.links[name].center
            row[q.POS : q.POS + 3] = np.add(pose.position, arm)
            row[q.QUAT : q.QUAT + 4] = pose.orientation
            row[q.VEL : q.VEL + 3] = np.add(velocity, np.cross(spin, arm))
            row[q.VEL + 3 : q.VEL + 6] = spin

    @cached_property
    def _center(self) -> Vec3:
        """The root link's center of mass in its frame [m]."""
        return _STILL if self.is_static else vector3(self.root.center)

    def place_link(self, link: str, pose: Pose, linear: Vector, angular: Vector) -> None:
        """See api.Body; one that is fixed to the world takes the others along."""
        row = self._row(link)
        if row is None:
            self.set_pose(pose.position, pose.orientation)
            return
        self.wake()
        x, y, z = self._engine.arrays.inward[row]
        center = pose * Pose((-x, -y, -z))
        numbers = self._engine.rows[row]
        numbers[q.POS : q.POS + 3], numbers[q.QUAT : q.QUAT + 4] = center.position, pose.orientation
        numbers[q.VEL : q.VEL + 6] = (*linear, *angular)
        self._engine.measure_joints()

    def set_velocity(self, linear: Vector, angular: Vector) -> None:
        """See api.Body."""
        if self.is_static or self.is_fixed and not self.model.loose:
            return
        self._engine.refresh()
        self.wake()
        self.rows[:, q.VEL : q.VEL + 6] = (*linear, *angular)
        self.joint_rows[:, q.RATE] = 0.0
        self._engine.is_ahead = True

    def hold_velocity(self, velocity: Vec3) -> None:
        """See api.Body."""
        if not self.is_fixed:
            self._engine.held[self] = velocity

    @property
    def is_held(self) -> bool:
        """See api.Body."""
        return self in self._engine.held

    def row_numbers(self) -> tuple[int, ...]:
        """Row of the root link; first row and that after the last, of bodies and of joints."""
        first, joint = self.first, self.first_joint
        ends = first, first + len(self.names), joint, joint + self.row_count
        return first + self._root_place, *ends

    def set_link_velocity(self, link: str, linear: Vector) -> None:
        """See api.Body."""
        row = self._row(link)
        if row is None:
            return
        self._engine.refresh()
        self.wake()
        self._engine.rows[row, q.VEL : q.VEL + 3] = linear
        self._engine.is_ahead = True

    # Where it is --------------------------------------------------------------------------------
    def _state(self, row: int) -> State | None:
        """Of the link of a row; None: it is not finite any more."""
        numbers = self._engine.rows[row, : q.PLACE].tolist()
        if not math.isfinite(sum(numbers)):
            return None
        x, y, z, *orientation = numbers[: q.VEL]
        inward = self._engine.arrays.inward[row]
        position, turned = compose((x, y, z), orientation, inward, UNTURNED)
        a, b, c, d, e, f = numbers[q.VEL :]
        return position, turned, (x, y, z), (a, b, c), (d, e, f)

    def _link_state(self, link: str) -> State:
        """Of a link; one that is not finite any more stays where the body was put last."""
        if link == self.model.root:
            if self.placement is None and not self.is_fixed:
                row = self.first + self._root_place
                return self._state(row) or self._placed_state(self._lost())
            return self._placed_state(self.present())
        self._engine.refresh()
        state = self._state(self._engine.arrays.rows[self.number, link])
        if state is None:
            frame, center = self.base * self.at_rest[link], vector3(self.model.links[link].center)
            place = frame.position, frame.orientation
            return (*place, compose(*place, center, UNTURNED)[0], _NOWHERE, _NOWHERE)
        return state

    @cached_property
    def at_rest(self) -> dict[str, Pose]:
        """Poses of links in the frame of the root, with all joints at 0."""
        frames = {self.model.root: Pose()}
        for joint in (*self.model.loose, *(each for _, each in self._outward)):
            frames[joint.child] = frames[joint.parent] * joint.origin
        return frames

    def _placed_state(self, placement: Placement) -> State:
        """Of the root link."""
        position, orientation = placement.pose.position, placement.pose.orientation
        center, _ = compose(position, orientation, self._center, UNTURNED)
        return position, orientation, center, placement.linear, placement.angular

    def _lost(self) -> Placement:
        """Where it was put last, without a velocity that is a number."""
        return Placement(self.base, _NOWHERE, _NOWHERE, [(0.0, 0.0)] * len(self.joints))

    def pose(self) -> tuple[Vec3, Quat]:
        """See api.Body."""
        return self._link_state(self.model.root)[:2]

    def link_motion(self, link: str, offset: tuple[Vec3, Quat] | None = None) -> Motion:
        """See api.Body."""
        position, orientation, center, linear, angular = self._link_state(link)
        if offset is not None:
            position, orientation = compose(position, orientation, *offset)
        return position, orientation, velocity_at(position, center, linear, angular), angular

    def recorded_motion(self, link: str, offset: tuple[Vec3, Quat] | None = None) -> Any:
        """See api.Body."""
        records = self._engine.records
        row = self._engine.arrays.rows.get((self.number, link))
        if row is None:  # it never moves
            values = np.concatenate(self.link_motion(link, offset))
            values = np.repeat(values[:, None], records.count, axis=1)
            return values[:3], values[3:7], values[7:10], values[10:]
        values = records.motions(row)
        if values is None:
            return None
        position, orientation = values[q.SR_POS : q.SR_QUAT], values[q.SR_QUAT : q.SR_VEL]
        angular = values[q.VEL + 3 : q.PLACE]
        if offset is None:
            return position, orientation, values[q.SR_VEL :], angular
        position, orientation = map(np.array, compose(position, orientation, *offset))
        center, linear = values[: q.QUAT], values[q.VEL : q.VEL + 3]
        return position, orientation, velocity_at(position, center, linear, angular), angular

    def link_center(self, link: str) -> Vec3:
        """See api.Body."""
        return self._link_state(link)[2]

    def _frame(self, link: str) -> Pose:
        """Pose of the frame of a link that has a row."""
        row = self.first + self.names.index(link)
        numbers, inward = self._engine.rows[row].tolist(), self._engine.arrays.inward[row]
        x, y, z = numbers[: q.QUAT]
        return Pose(*compose((x, y, z), numbers[q.QUAT : q.VEL], inward, UNTURNED))

    def _velocity(self, link: str) -> tuple[Array, Array]:
        """Velocities of the origin of a link's frame [m/s, rad/s]."""
        row = self.rows[self.names.index(link)]
        spin = row[q.VEL + 3 : q.VEL + 6].copy()
        center: Any = self.model.links[link].center
        arm = matrix_from_quaternion(row[q.QUAT : q.VEL]) @ center
        return row[q.VEL : q.VEL + 3] - np.cross(spin, arm), spin

    def _root_frame(self) -> Pose | None:
        """Pose of the root link's frame; None: nothing has put it anywhere yet."""
        if not self.model.loose or not self.has_started:
            return None
        return self.frame if self.is_fixed else self._frame(self.model.root)

    # Joints -------------------------------------------------------------------------------------
    def joint_states(self) -> Sequence[tuple[float, float, float]]:
        """See api.Body."""
        if not self.joints:
            return []
        if not self.has_rows():  # it is where it was put
            assert self.placement is not None
            return [(position, velocity, 0.0) for position, velocity in self.placement.joints]
        self._engine.refresh()
        numbers, count = self.measured(self._engine.joint_numbers), len(self.order)
        return [
            (angle, rate, 0.0 if motor.applied is None else motor.applied)
            for angle, rate, motor in zip(numbers, numbers[count:], self.motors)
        ]

    def read_joints(self, states: Iterable[JointState]) -> None:
        """See api.Body."""
        self._engine.refresh()
        if not self.order:
            return
        numbers = self.measured(self._engine.joint_numbers)
        for state, angle, rate in zip(states, numbers, numbers[len(self.order) :]):
            state.position, state.velocity = angle, rate

    def joint_positions(self) -> tuple[float, ...]:
        """See api.Body."""
        return tuple(state[0] for state in self.joint_states())

    @cached_property
    def _mirrored(self) -> list[str]:
        """Names of the joints above `links`, but the root."""
        above = {joint.child: joint.name for joint in mirrored_joints(self.model)}
        return [above[name] for name in self.links if name in above]

    def coordinates(self) -> tuple[float, ...]:
        """See api.Body."""
        if self.is_static:
            return ()
        positions = dict(zip(self.joints, self.joint_positions()))
        if self.has_chains:
            positions.update(self.chains())
        return tuple(positions[name] for name in self._mirrored)

    @property
    def has_chains(self) -> bool:
        """Whether mirrors have more joints for it: those of chains()."""
        return bool(self.model.loose) or any(joint.kind == "screw" for joint in self.tree)

    def chains(self) -> dict[str, float]:
        """Positions [m, rad] of joints by which mirrors move loose links and screws besides."""
        self._engine.refresh()
        positions: dict[str, float] = {}
        for joint in self.model.loose:
            root, pose = self._root_frame(), self._frame(joint.child)
            assert root is not None
            names = [link.name for link in chain_of(joint)]
            positions.update(zip(names, free_coordinates(joint, root, pose)))
        for joint, row in zip(self.tree, self.joint_rows):
            if joint.kind == "screw":
                positions[chain_of(joint)[0].name] = row[q.ANGLE] / row[q.PITCH]
        return positions

    # What acts on it ----------------------------------------------------------------------------
    def apply_force(self, link: str, force: Vector, point: Vector, torque: Vector = _STILL) -> None:
        """See api.Body."""
        row = self._row(link)
        if row is not None:
            self.wake()
            numbers = self._engine.rows[row]
            arm = np.subtract(point, numbers[q.POS : q.POS + 3])
            numbers[q.FORCE : q.FORCE + 3] += force
            numbers[q.FORCE + 3 : q.FORCE + 6] += np.add(torque, np.cross(arm, force))

    def _row(self, link: str) -> int | None:
        """The row of a link; None: it is fixed to the world."""
        self._engine.refresh()
        row: int | None = self._engine.arrays.rows.get((self.number, link))
        return row

    def wake(self) -> None:
        """Let it be awake."""
        if self.may_sleep and self.has_rows():
            self.rows[:, q.REST : q.ASLEEP + 1] = q.REST_TIME, q.REST_COUNT, 0.0

    def is_resting(self) -> bool:
        """Whether it sleeps where its rows are."""
        is_placed = self.placement is not None or not self.has_rows()
        return self.may_sleep and not is_placed and bool(self.rows[:, q.ASLEEP].all())

    # Properties of links ------------------------------------------------------------------------
    def set_mass(self, link: str, mass: float, inertia: Array) -> None:
        """See api.Body."""
        row = self._row(link)
        if row is not None:
            self.wake()
            described = self.model.links[link]
            described.mass, described.inertia = mass, inertia
            tables.set_inertia(self._engine.rows[row], mass, inertia)

    def set_gravity(self, link: str, is_on: bool, mass: float, center: Vector) -> None:
        """See api.Body."""
        row = self._row(link)
        if row is not None:
            self.wake()
            self.model.links[link].gravity = is_on
            self._engine.rows[row, q.GRAVITY] = float(is_on)

    def set_friction(self, link: str, friction: float) -> None:
        """See api.Body; a pair of links has the smaller ones of both."""
        engine = self._engine
        engine.contents.friction[self.number, link], engine.is_built = friction, False

    def set_slip(self, link: str, slip1: float, slip2: float) -> None:
        """See api.Body; until the arrays are built again."""
        row = self._row(link)
        if row is None:
            return
        scene = self._engine.arrays.state.scene
        for shape in np.flatnonzero(scene.kinds[:, 0] == row):
            scene.shapes[shape, q.G_SLIP : q.G_SLIP + 2] = slip1, slip2
            solid = scene.solid_of[shape]
            if solid >= 0:
                scene.faces[solid, q.P_SLIP : q.P_SLIP + 2] = slip1, slip2

    def set_bitmask(self, link: str, bits: int) -> None:
        """See api.Body."""
        engine, key = self._engine, (self.number, link)
        engine.contents.filtered[key], engine.is_built = bits, False
        engine.note_layout("mask", *key)
        if engine.has_mirror:
            engine.mirror.set_bitmask(key, bits)

    # Contacts -----------------------------------------------------------------------------------
    def contacts(self, link: str) -> list[Contact]:
        """See api.Body; in ODE's order, then what it overlaps that pushes nothing."""
        own, last = (self.number, link), self._engine.last_contacts
        contacts = last.of_link(own)
        firsts = {
            other: last.is_first(own, other)
            for other in {(contact.body, contact.link) for contact in contacts}
        }
        contacts = [c._replace(is_first=firsts[c.body, c.link]) for c in contacts]
        if self._engine.arrays.passable:
            contacts += self._engine.mirror.overlaps(own)
        return contacts

    def records_contacts(self, link: str) -> bool:
        """See api.Body."""
        engine, key = self._engine, (self.number, link)
        if self.is_static or self.collisions or self.may_sleep:
            return False
        if key not in engine.contents.recorded:
            engine.contents.recorded.add(key)
            engine.is_built = False
        engine.build()
        return key in engine.arrays.rows and engine.arrays.finds_all and not engine.arrays.passable

    def contact_rows(self, link: str) -> ContactRows:
        """See api.Body."""
        engine, own = self._engine, (self.number, link)
        rows = None if engine.arrays.passable else engine.last_contacts.rows_of_link(own)
        return contact_rows(self.contacts(link)) if rows is None else rows

    def touching(self) -> list[Touch]:
        """See api.Body."""
        return [
            Touch(link, contact.body, contact.link, float(contact.force @ contact.normal))
            for link, contact in self._engine.last_contacts.of_body(self.number)
        ]
