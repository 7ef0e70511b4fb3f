"""The engine whose bodies move as in Gazebo: an OdeSolver moves them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
import pybullet as p

from bullet_sim.controllers.effort_row import EffortRow
from bullet_sim.description.lump import LumpedModel, as_printed, lump
from bullet_sim.description.model import Joint, ModelDescription
from bullet_sim.description.world import OdeSettings
from bullet_sim.engine.engine import SLEEP, Contact, Engine, stacked, vector3
from bullet_sim.engine.ode import OdeSolver
from bullet_sim.engine.ode_arrays import WORLD, Attachment
from bullet_sim.engine.ode_scene import BodyLink
from bullet_sim.engine.rays import MeshScene
from bullet_sim.engine.tables import Tree, make_tree
from bullet_sim.engine.told import Told, place, read_file
from bullet_sim.errors import ModelError
from bullet_sim.pose import Array, Motion, Pose, Quat, Vec3, Vector, compose, velocity_at

if TYPE_CHECKING:
    from bullet_sim.controllers.handle import JointHandle


class OdeEngine(Engine):
    """As Engine, with steps as Gazebo's ODE makes them.

    Arguments, attributes and methods are those of Engine. PyBullet has copies of the bodies once
    something asks for its client, such as contacts of shapes that the solver does not know: most
    worlds have none. A client alone takes some 30 MB.
    """

    computes_pids = True
    keeps_states = True
    adds_motor_effort = False
    casts_at_meshes = True

    def __init__(self, *arguments: Any, **options: Any) -> None:
        self._told: dict[int, Told] = {}
        super().__init__(*arguments, **options)
        self.ode = OdeSolver(self, self._told)
        self._trees: dict[int, tuple[Array, Tree]] = {}  # of triangles, by their id

    # PyBullet's copies

    def _open(self) -> None:
        """Nothing needs a client yet."""

    def _forget(self) -> None:
        super()._forget()
        self._told.clear()
        self._unused: list[int] = []  # numbers of bodies that were removed; the last is next
        # Group and mask of (body, link), whether (body, link, other, its link) collide.
        self._filters: dict[tuple[int, ...], tuple[int, ...]] = {}
        self._unplaced: set[int] = set()  # bodies that were put somewhere since the last _sync()

    @property
    def _client(self) -> int:
        if self._number < 0:
            self._connect()
        return self._number

    def _connect(self) -> None:
        """Have a client of PyBullet with copies of all bodies, which have the same numbers."""
        super()._open()
        self._unplaced.clear()
        self.ode.is_ahead = False
        for body in range(len(self._told) + len(self._unused)):
            if body in self._told:
                self._copy(body)
            else:
                p.createMultiBody(physicsClientId=self._number)  # has the number for now
        for body in self._unused:
            p.removeBody(body, physicsClientId=self._number)
        for key, values in self._filters.items():
            self._filter_copies(key, values)
        for body in self._told:
            self._place(body)

    def _disconnect(self) -> None:
        """Without a client, as before something has asked for one."""
        super().close()

    def _copy(self, body: int) -> None:
        """Have PyBullet load a body."""
        told = self._told[body]
        number = self._read_file(told.path, told.fixed_base, told.self_collide, told.static)
        names = super().link_indices(number)
        if number != body or not told.static and list(names) != told.links:
            raise ModelError(
                f"PyBullet reads {told.path} as body {number} with the links {', '.join(names)}; "
                f"must be {body} with {', '.join(told.links)}"
            )
        self._note_center(body, told.static)

    def _filter_copies(self, key: tuple[int, ...], values: tuple[int, ...]) -> None:
        if len(key) == 2:
            p.setCollisionFilterGroupMask(*key, *values, physicsClientId=self._number)
        else:
            body, link, other, other_link = key
            p.setCollisionFilterPair(
                body, other, link, other_link, *values, physicsClientId=self._number
            )

    def _place(self, body: int) -> None:
        """Put the copy of a body where that is."""
        told = self._told[body]
        self.ode.tell(body, told)
        chain = self.ode.chain_positions(body) if told.chain and told.is_finite() else ()
        place(self._number, body, told, Pose(*self._inertial[body]), chain)
        if not self.moves(body):
            p.changeDynamics(body, -1, activationState=SLEEP, physicsClientId=self._number)

    def _sync(self) -> None:
        if self._number < 0 or not self.ode.is_ahead:
            return
        self.ode.is_ahead = False
        for body in self._told:
            if body in self._unplaced or self.moves(body) and not self.ode.is_resting(body):
                self._place(body)
        self._unplaced.clear()

    def _tell(self, body: int) -> Told:
        """What was told of a body, where it is now: to be changed."""
        told = self._told[body]
        self.ode.tell(body, told)
        self.ode.read_later(body)
        self.ode.is_ahead = True
        self._unplaced.add(body)
        return told

    @property
    def settings(self) -> OdeSettings:
        return self.ode.settings

    def configure(self, settings: OdeSettings) -> None:
        self.ode.configure(settings)

    def is_compiled(self) -> bool:
        return self.ode.is_compiled()

    def compile(self) -> None:
        self.ode.compile()

    def lump(self, description: ModelDescription) -> LumpedModel:
        lumped = lump(description, as_in_gazebo=True)
        return as_printed(lumped) if description.is_urdf else lumped

    def controlled(self, pids: Sequence[EffortRow], notes: bool) -> AbstractContextManager[None]:
        return self.ode.controlled(pids, notes)

    def noted(self, body: int, joints: Iterable[int], count: int) -> list[list[float]]:
        return self.ode.noted(body, joints, count)

    def close(self) -> None:
        self.ode.end_threads()
        super().close()

    def save_solver(self) -> dict[str, Any]:
        self._disconnect()  # PyBullet's contacts start anew, as they do where this is restored
        return {"poses": {body: told.pose for body, told in self._told.items()}, **self.ode.save()}

    def restore_solver(self, state: dict[str, Any]) -> None:
        self._disconnect()
        for body, pose in state["poses"].items():
            if self._told[body].fixed_base and self._told[body].pose != pose:
                self._tell(body).pose = pose
                self.placements += 1
        self.ode.restore(state)

    def clear(self) -> None:
        self._disconnect()
        self._forget()
        self.ode.clear()

    def set_gravity(self, gravity: Vec3) -> None:
        self.gravity = vector3(gravity)
        self.ode.wake()

    def set_time_step(self, time_step: float) -> None:
        self.time_step = float(time_step)

    def set_solver_iterations(self, count: int) -> None:
        self.ode.configure(replace(self.ode.settings, iterations=int(count)))

    def step(self, count: int = 1) -> None:
        self.ode.step(count)

    # Bodies

    def load(
        self,
        path: str,
        position: Vector = (0, 0, 0),
        orientation: Vector = (0, 0, 0, 1),
        fixed_base: bool = False,
        self_collide: bool = False,
        static: bool = False,
    ) -> int:
        told = read_file(path, fixed_base, self_collide, static)
        self._sync()
        body = self._unused.pop() if self._unused else len(self._told)
        self._told[body] = told
        self._know(body, told.movable, told.chain, fixed_base, len(told.links) - 1)
        if self._number >= 0:
            self._copy(body)
        self.set_base_pose(body, position, orientation)
        return body

    def joint_names(self, body: int) -> list[str]:
        return self._told[body].joints

    def link_indices(self, body: int) -> dict[str, int]:
        return {name: index for index, name in enumerate(self._told[body].links, -1)}

    def take(
        self,
        body: int,
        model: LumpedModel,
        links: Mapping[str, int],
        description: ModelDescription,
        touching: Sequence[tuple[str, str]],
    ) -> None:
        self.passable.take(body, model, links)
        fixed = description.static or description.fixed_base
        may_sleep = (
            description.auto_disable
            and not description.has_sensors
            and not fixed
            and (description.is_urdf or not description.joints)  # a URDF's fixed ones are merged
        )
        self.ode.add(body, model, links, description.static, fixed, may_sleep, touching)

    def remove(self, body: int) -> None:
        self.ode.remove(body)
        if self._number >= 0:
            p.removeBody(body, physicsClientId=self._number)
        del self._told[body]
        self._unused.append(body)
        self._unplaced.discard(body)
        self._filters = {
            key: values for key, values in self._filters.items() if body not in key[::2]
        }
        self._drop(body)

    def set_mass(self, body: int, link: int, mass: float, inertia: Array) -> None:
        self.ode.set_mass(body, link, mass, inertia)

    def set_link_gravity(
        self, body: int, link: int, is_on: bool, mass: float, center: Vector
    ) -> None:
        self.ode.set_link_gravity(body, link, is_on)

    def set_joint_limits(self, body: int, joint: int, lower: float, upper: float) -> None:
        self.ode.set_limits(body, joint, lower, upper)

    def set_joint_damping(self, body: int, joint: int, damping: float) -> None:
        self.ode.set_damping(body, joint, damping)

    def set_joint_parameter(self, body: int, joint: int, name: str, value: float) -> bool:
        self.ode.set_parameter(body, joint, name, value)
        return True

    # Motion; the solver does not know what never moves

    def base_pose(self, body: int) -> tuple[Vec3, Quat]:
        motion = self.ode.link_motion(body, -1)
        return self._last_told(body).motion()[:2] if motion is None else motion[:2]

    def _last_told(self, body: int) -> Told:
        """What was told of a body, where it is now."""
        told = self._told[body]
        self.ode.tell(body, told)
        return told

    def set_base_pose(self, body: int, position: Vector, orientation: Vector) -> None:
        self.placements += 1
        told = self._tell(body)
        x, y, z, w = map(float, orientation)
        told.pose = Pose(vector3(position), (x, y, z, w))
        told.linear = told.angular = (0.0, 0.0, 0.0)

    def set_base_velocity(self, body: int, linear: Vector, angular: Vector) -> None:
        told = self._tell(body)
        if not told.fixed_base:
            arm = np.subtract(told.middle(), told.pose.position)
            told.linear = vector3(np.asarray(linear, float) + np.cross(angular, arm))
            told.angular = vector3(angular)

    def put(self, body: int, position: Vector, orientation: Vector) -> None:
        raise NotImplementedError  # of the principal axes, which PyBullet alone has

    def set_coordinates(self, body: int, positions: Vector) -> None:
        raise NotImplementedError  # mirrors of a world alone are set by them

    def set_joint_positions(self, body: int, positions: Vector) -> None:
        if self.movable[body]:
            self._tell(body).states = [(float(position), 0.0) for position in positions]

    def put_joint(self, body: int, joint: int, position: float) -> None:
        self._tell(body).states[joint] = float(position), 0.0

    def set_velocity(self, body: int, linear: Vector, angular: Vector) -> None:
        """Set the velocity of a model [m/s, rad/s], world axes: that of the centers of mass of all
        its links, as in Gazebo (Model::SetLinearVel)."""
        if not self.ode.set_velocities(body, linear, angular):
            self.set_base_velocity(body, linear, angular)

    def place_link(
        self, body: int, link: int, position: Vector, orientation: Vector, linear: Vector,
        angular: Vector,
    ) -> None:  # fmt: skip
        """Put one link's frame to a world pose, with a velocity of its center of mass [m/s, rad/s]
        along world axes; joints pull it, and what they connect with it, in the next steps."""
        x, y, z, w = map(float, orientation)
        pose = Pose(vector3(position), (x, y, z, w))
        if not self.ode.place_link(body, link, pose, linear, angular):
            super().place_link(body, link, position, orientation, linear, angular)

    def gather(self, body: int) -> None:
        self._tell(body)
        self.ode.gather(body)

    def _chain_positions(self, body: int) -> list[float]:
        return self.ode.chain_positions(body)

    def link_motion(
        self, body: int, link: int, offset: tuple[Vec3, Quat] | None = None
    ) -> tuple[Vec3, Quat, Vec3, Vec3]:
        motion = self._moving(body, link)
        if motion is None:
            if link >= 0:
                return super().link_motion(body, link, offset)
            told = self._last_told(body)
            motion = *told.motion()[:2], told.middle(), told.linear, told.angular
        position, orientation, center, linear, angular = motion
        if offset is not None:
            position, orientation = compose(position, orientation, *offset)
        return position, orientation, velocity_at(position, center, linear, angular), angular

    def _moving(self, body: int, link: int) -> tuple[Vec3, Quat, Vec3, Vec3, Vec3] | None:
        """As OdeSolver.link_motion, also of links below the root of what was just put somewhere."""
        motion = self.ode.link_motion(body, link)
        if motion is None and link >= 0:
            self.ode.refresh()
            motion = self.ode.link_motion(body, link)
        return motion

    def link_motions(self, body: int, links: Sequence[int]) -> list[Motion]:
        return [self.link_motion(body, link) for link in links]

    def link_center(self, body: int, link: int) -> Vec3:
        motion = self._moving(body, link)
        if motion is not None:
            return motion[2]
        return super().link_center(body, link) if link >= 0 else self._last_told(body).middle()

    def joint_states(self, body: int) -> Sequence[tuple[float, float, Sequence[float], float]]:
        return self.ode.joint_states(body)

    def read_joints(self, body: int, handles: Iterable[JointHandle]) -> None:
        self.ode.read_joints(body, handles)

    def joint_load(self, body: int, joint: int) -> tuple[Array, Array, float]:
        return self.ode.joint_load(body, joint)

    # Motors

    def drive_velocity(self, body: int, joint: int, velocity: float, effort: float) -> None:
        self.ode.set_velocity(body, joint, velocity, effort)

    def impose_velocity(self, body: int, joint: int, velocity: float, effort: float) -> None:
        """Give the link below a joint a velocity [rad/s, m/s] before each step, as Gazebo's
        Joint::SetVelocity."""
        self.ode.impose_velocity(body, joint, velocity)

    def impose_position(
        self, body: int, joint: int, position: float, effort: float, velocity: float
    ) -> None:
        """Put a joint to a position [rad, m] before each step, as Gazebo's Joint::SetPosition; it
        is held by its friction alone then."""
        self.ode.impose_position(body, joint, position)

    def drive_position(
        self, body: int, joint: int, position: float, effort: float, velocity: float
    ) -> None:
        self.ode.set_position(body, joint, position, effort, velocity)

    def release(self, body: int, joint: int) -> None:
        self.ode.release(body, joint)

    def measure_joint(self, body: int, joint: int) -> None:
        """The solver measures all joints."""

    def drive_efforts(self, body: int, joints: Sequence[int], efforts: Sequence[float]) -> None:
        for joint, effort in zip(joints, efforts):
            self.ode.add_effort(body, joint, effort)

    def apply_wrench(self, body: int, link: int, force: Vector, torque: Vector) -> None:
        center = self.link_center(body, link)
        self.ode.add_force(body, link, vector3(force), center, vector3(torque))

    def apply_force(self, body: int, link: int, force: Vector, point: Vector) -> None:
        self.ode.add_force(body, link, vector3(force), vector3(point), (0.0, 0.0, 0.0))

    def is_asleep(self, body: int) -> bool:
        """Whether a body sleeps, until something awake touches it, or a force acts on it."""
        return self.ode.is_asleep(body)

    # Attaching

    def attach(self, key: Any, one: BodyLink, other: BodyLink) -> None:
        self._attach(key, one, other)

    def attach_by_joint(
        self, key: Any, parent: BodyLink | None, child: BodyLink, joint: Joint
    ) -> bool:
        self._attach(key, WORLD if parent is None else parent, child, joint)
        return True

    def _attach(
        self, key: Any, parent: BodyLink, child: BodyLink, joint: Joint | None = None
    ) -> None:
        frame = Pose(*self.link_motion(*child)[:2])
        if parent != WORLD:
            frame = Pose(*self.link_motion(*parent)[:2]).inverse() * frame
        self.ode.attach(key, Attachment(parent, child, frame, joint=joint))

    def attached_state(self, key: Any) -> tuple[float, float]:
        return self.ode.attached_state(key)

    def add_attached_effort(self, key: Any, effort: float) -> None:
        self.ode.add_attached_effort(key, effort)

    def attach_again(self, key: Any) -> bool:
        return self._switch_attachment(key, True)

    def detach(self, key: Any) -> bool:
        return self._switch_attachment(key, False)

    def _switch_attachment(self, key: Any, is_on: bool) -> bool:
        """Hold or let go what was attached by a key; whether there is such."""
        found = self.ode.attachments().get(key)
        if found is not None:
            self.ode.attach(key, replace(found, is_on=is_on))
        return found is not None

    def attachments(self) -> dict[Any, tuple[BodyLink, BodyLink]]:
        held = self.ode.attachments().items()
        return {key: (it.parent, it.child) for key, it in held if it.is_on and it.joint is None}

    # Contacts

    def set_friction(self, body: int, link: int, friction: float) -> None:
        """Set mu and mu2 of a link; a pair has the smaller ones of both."""
        self.ode.set_friction(body, link, friction)

    def set_slip(self, body: int, link: int, slip1: float, slip2: float) -> None:
        self.ode.set_slip(body, link, slip1, slip2)

    def set_bitmask(self, body: int, link: int, bits: int) -> None:
        self.ode.set_bitmask(body, link, bits)
        super().set_bitmask(body, link, bits)

    def set_ghost(self, body: int, link: int) -> None:
        self.ode.set_ghost(body)
        super().set_ghost(body, link)

    def _set_filter(self, body: int, link: int, group: int, mask: int) -> None:
        self._filter((body, link), (group, mask))
        self.note_layout("mask", body, link)

    def set_pair_collision(
        self, body: int, link: int, other: int, other_link: int, collide: bool
    ) -> None:
        self._filter((body, link, other, other_link), (int(collide),))
        self.note_layout("pair", body, other)

    def _filter(self, key: tuple[int, ...], values: tuple[int, ...]) -> None:
        self._filters[key] = values
        if self._number >= 0:
            self._filter_copies(key, values)

    def touching(self, body: int) -> list[tuple[int, int, int, float]]:
        return [
            (link, contact.body, contact.link, float(contact.force @ contact.normal))
            for link, contact in self._contacts(body)
        ]

    def contacts(self, body: int, link: int) -> list[Contact]:
        """Contact points of one link as of the last step, in ODE's order."""
        told = self.ode.contacts_of((body, link))
        found = [contact for own, contact in _seen_by(body, told) if own == link]
        firsts = {
            other: self.ode.is_first((body, link), other)
            for other in {(contact.body, contact.link) for contact in found}
        }
        found = [replace(it, is_first=firsts[it.body, it.link]) for it in found]
        return found + self.overlaps(body, link)

    def _contacts(self, body: int) -> list[tuple[int, Contact]]:
        """(link, Contact) of a body as of the last step."""
        return _seen_by(body, self.ode.contacts())

    def all_contacts(self) -> tuple[Array, Array, Array]:
        return stacked(
            [
                (point, normal, float(np.dot(force, normal)))
                for _, _, _, _, point, normal, _, force in self.ode.contacts()
            ]
        )

    # Rays

    def cast_rays(
        self,
        center: Array,
        directions: Array,
        near: float,
        far: float,
        own: int | None = None,
        look_near: bool = True,
    ) -> Array:
        scene, is_whole = self.ode.ray_scene()
        ranges = scene.cast(center, directions, near, far, own, look_near)
        if not is_whole:
            others = super().cast_rays(center, directions, near, far, own, look_near)
            ranges = np.minimum(ranges, others)
        return ranges

    def mesh_scene(
        self, meshes: Sequence[tuple[int, Pose, Array]], positions: Array, orientations: Array
    ) -> MeshScene:
        """Triangles at which rays are cast, of links that are put anywhere, see MeshScene.

        Args:
            meshes: row of the link, pose in it and triangles (n, 3, 3) [m] of each.
            positions, orientations: of the links (n, 3) [m] and (n, 4).
        """
        for _, _, triangles in meshes:
            if id(triangles) not in self._trees:
                self._trees[id(triangles)] = triangles, make_tree(triangles, (1.0, 1.0, 1.0))
        trees = [(row, pose, self._trees[id(each)][1]) for row, pose, each in meshes]
        return MeshScene(trees, positions, orientations)


def _seen_by(body: int, told: Sequence[Any]) -> list[tuple[int, Contact]]:
    """(link, Contact) of a body, of contacts as quickstep tells them."""
    found = []
    for one, link, two, other, point, normal, depth, force in told:
        if one == body:
            at, across = np.array(point), np.array(normal)
            found.append((link, Contact(two, other, at, across, depth, force)))
        elif two == body:
            at, across = np.array(point), np.array(normal)
            found.append((other, Contact(one, link, at, -across, depth, -force)))
    return found
