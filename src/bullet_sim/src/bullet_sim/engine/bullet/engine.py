"""The engine 'bullet': bodies are placed, driven and stepped by PyBullet, as it is."""

from __future__ import annotations

import zlib
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
import pybullet as p

from bullet_sim.description.collisions import self_colliding, without_overlapping_hulls
from bullet_sim.description.lump import LumpedModel, lump
from bullet_sim.description.model import EVERYTHING, Joint, ModelDescription
from bullet_sim.description.world import OdeSettings
from bullet_sim.engine.api import Body, BodyLink, EngineState
from bullet_sim.engine.bullet import states
from bullet_sim.engine.bullet.body import BulletBody, BulletMotor
from bullet_sim.engine.bullet.client import Client
from bullet_sim.engine.bullet.passable import Passable
from bullet_sim.engine.efforts import EffortRow
from bullet_sim.engine.quickstep import law
from bullet_sim.pose import UNTURNED, Array, Pose, Vec3, vector3

FRICTION = 1.0  # coefficient where a file gives none, as in Gazebo
# PyBullet has one maximum for all joints of a body and cuts their speeds there, 100 by default:
# the limits of single joints are applied to their commands.
MAX_COORDINATE_SPEED = 1e4  # [rad/s, m/s]


class BulletEngine:
    """See api.Engine.

    Attributes:
        client: of PyBullet.
        bodies: by their numbers, which are PyBullet's.
        weightless: link, mass [kg], center [m] in its frame of what gravity does not act on.
    """

    settings: OdeSettings | None = None
    records = None
    unlocked = False  # PyBullet keeps Python's lock

    def __init__(self, time_step: float, gravity: Vec3) -> None:
        self.time_step, self.gravity = float(time_step), vector3(gravity)
        self._iterations, self.placements = OdeSettings().iterations, 0
        self.client = Client()
        self._api = self.client.api
        self.cast_rays = self.client.cast_rays  # see api.Engine
        self._start()

    def _start(self) -> None:
        """Know no body, and tell the client what it has to know."""
        self.bodies: dict[int, BulletBody] = {}
        self.passable = Passable(self.client)
        self.weightless: list[tuple[BodyLink, float, Vec3]] = []
        self._attached: dict[Any, tuple[int, BodyLink, BodyLink]] = {}
        self.layout = 0
        self.set_time_step(self.time_step)
        self.set_gravity(self.gravity)
        self.set_solver_iterations(self._iterations)

    # Settings -----------------------------------------------------------------------------------
    @property
    def solver_iterations(self) -> int:
        """See api.Engine."""
        return self._iterations

    def configure(self, settings: OdeSettings) -> None:
        """See api.Engine."""
        self.set_solver_iterations(settings.iterations)

    def set_gravity(self, gravity: Vec3) -> None:
        """See api.Engine."""
        self.gravity = vector3(gravity)
        self._api.setGravity(*self.gravity)

    def set_time_step(self, time_step: float) -> None:
        """See api.Engine."""
        self.time_step = float(time_step)
        self._api.setTimeStep(self.time_step)

    def set_solver_iterations(self, count: int) -> None:
        """See api.Engine."""
        self._iterations = int(count)
        self._api.setPhysicsEngineParameter(numSolverIterations=self._iterations)

    def is_compiled(self) -> bool:
        """See api.Engine."""
        return True

    def compile(self) -> None:
        """See api.Engine."""

    def close(self) -> None:
        """See api.Engine."""
        self.client.close()

    def clear(self) -> None:
        """See api.Engine."""
        self.client.clear()
        self._start()

    def note_layout(self, *event: object) -> None:
        """Note what gives bodies numbers in the broad phase."""
        self.layout = zlib.crc32(repr((self.layout, event)).encode())

    # Bodies -------------------------------------------------------------------------------------
    def lump(self, description: ModelDescription) -> LumpedModel:
        """See api.Engine."""
        return lump(description)

    def add(self, model: LumpedModel, description: ModelDescription, pose: Pose) -> BulletBody:
        """See api.Engine."""
        pairs, static = self_colliding(description, model), description.static
        fixed_base = static or model.fixed_base
        loaded = self.client.load(None, model, static, fixed_base, bool(pairs))
        body = self.bodies[loaded.uid] = BulletBody(self, loaded, model, description)
        self.note_layout("add", body.number, len(body.links))
        for link in body.links:
            body.change(
                link,
                linearDamping=0.0,
                angularDamping=0.0,
                restitution=0.0,
                maxJointVelocity=MAX_COORDINATE_SPEED,
            )
        body.set_pose(pose.position, pose.orientation)
        self._add_joints(body, model)
        self._add_surfaces(body, model, description)
        self._add_pairs(body, model, description, pairs)
        self.weightless += [
            ((body.number, part), link.mass, (frame * Pose(vector3(link.center))).position)
            for link in description.links.values()
            if not static and not link.gravity and link.mass > 0.0
            for part, frame in (model.frames[link.name],)
        ]
        return body

    @staticmethod
    def _add_joints(body: BulletBody, model: LumpedModel) -> None:
        """Give joints their damping, and release them."""
        for joint in (*model.joints, *model.welds):
            motor = body.motor(joint.name)
            motor.set_damping(joint.damping)
            motor.release()

    def _add_surfaces(
        self, body: BulletBody, model: LumpedModel, description: ModelDescription
    ) -> None:
        """Give links their surfaces and bitmasks."""
        for _, name in self.passable.add(body.number, model):
            body.set_bitmask(name, 0)
        for name, link in model.links.items():
            surface = link.surface
            friction = FRICTION if surface.friction is None else surface.friction
            if description.static:  # the product counts, and Gazebo's grounds have 100
                friction = min(friction, FRICTION)
            body.set_friction(name, friction)
            if surface.stiffness is not None and surface.damping is not None:
                body.change(
                    name, contactStiffness=surface.stiffness, contactDamping=surface.damping
                )
            if surface.bitmask != EVERYTHING:
                body.set_bitmask(name, surface.bitmask)

    def _add_pairs(
        self,
        body: BulletBody,
        model: LumpedModel,
        description: ModelDescription,
        pairs: list[tuple[str, str]],
    ) -> None:
        """Have those links collide with each other that do."""
        if not pairs:
            return

        def depth(one: str, other: str) -> float:
            return self.client.depth((body.number, one), (body.number, other))

        touching = set(without_overlapping_hulls(pairs, description, model, depth))
        names = list(model.links)
        for place, one in enumerate(names):
            for other in names[place + 1 :]:
                if (one, other) not in touching:
                    self.set_pair_collision((body.number, one), (body.number, other), False)

    def set_pair_collision(self, one: BodyLink, other: BodyLink, collide: bool) -> None:
        """Enable or disable collision between two links."""
        self.client.set_pair_collision(one, other, collide)
        self.note_layout("pair", one, other)

    def remove(self, body: Body) -> None:
        """See api.Engine."""
        number = body.number
        for key, (_, one, other) in list(self._attached.items()):
            if number in (one[0], other[0]):
                self.detach(key)
                del self._attached[key]
        self.client.remove(number)
        del self.bodies[number]
        self.passable.remove(number)
        self.weightless = [part for part in self.weightless if part[0][0] != number]
        self.note_layout("remove", number)

    # Steps --------------------------------------------------------------------------------------
    def step(
        self, count: int = 1, efforts: Sequence[EffortRow] = (), records: bool = False
    ) -> Array | None:
        """See api.Engine."""
        step, client = p.stepSimulation, self.client.number
        recorded = []
        by_body: dict[int, list[EffortRow]] = {}
        for row in efforts:
            assert isinstance(row.motor, BulletMotor)
            by_body.setdefault(row.motor.uid, []).append(row)
        for _ in range(count):
            read = self.bodies if records else by_body
            states = {uid: self.bodies[uid].states() for uid in read}
            recorded.append([state[:2] for of_body in states.values() for state in of_body])
            for uid, rows in by_body.items():
                self._apply(self.bodies[uid], rows, states[uid])
            self._lift()
            step(client)
        return np.array(recorded).reshape(count, -1, 2).transpose(0, 2, 1) if records else None

    def _apply(self, body: BulletBody, rows: Sequence[EffortRow], states: Sequence[Any]) -> None:
        """Apply efforts of one body's joints in the next step; states: of its joints."""
        of_motor = dict(zip(body.motors.values(), states))
        motors: list[Any] = [row.motor for row in rows]
        self._api.setJointMotorControlArray(
            body.number,
            [motor.index for motor in motors],
            p.TORQUE_CONTROL,
            forces=[
                law.effort_of(row.numbers, of_motor[motor][0], of_motor[motor][1], self.time_step)
                for row, motor in zip(rows, motors)
            ],
        )
        for row, motor in zip(rows, motors):
            motor.applied = row.applied

    def joint_columns(self, body: Body, joints: Iterable[str]) -> list[int]:
        """See api.Engine."""
        first = 0
        for other in self.bodies.values():
            if other is body:
                break
            first += len(other.joints)
        return [first + list(body.joints).index(name) for name in joints]

    def _lift(self) -> None:
        """Balance the weight of what has none, for the next step."""
        for (number, link), mass, center in self.weightless:
            body = self.bodies[number]
            point = body.link_motion(link, (center, UNTURNED))[0]
            body.apply_force(link, [-mass * g for g in self.gravity], point)

    def save_state(self) -> EngineState:
        """See api.Engine. Where links of several shapes touch something, this clears the contacts,
        also for the world that goes on."""
        return states.save_bodies(self)

    def restore_state(self, state: EngineState) -> bool:
        """See api.Engine."""
        return states.restore_bodies(self, state)

    # Attaching ----------------------------------------------------------------------------------
    def attach(self, key: Any, one: BodyLink, other: BodyLink) -> None:
        """See api.Engine."""
        self.detach(key)
        moving, still = (one, other) if self.bodies[one[0]].moves else (other, one)
        there, joint = Pose(*self.client.center_frame(moving)), -1
        second = (-1, -1)  # of what is static PyBullet has no body for it
        if self.bodies[still[0]].moves:
            there = Pose(*self.client.center_frame(still)).inverse() * there
            second = self.client.index(still)
        if self.bodies[moving[0]].moves:
            joint = self._api.createConstraint(
                *self.client.index(moving),
                *second,
                p.JOINT_FIXED,
                (0, 0, 0),
                (0.0, 0.0, 0.0),
                there.position,
                (0, 0, 0, 1),
                there.orientation,
            )
        self._attached[key] = joint, one, other
        self.set_pair_collision(one, other, False)

    def attach_again(self, key: Any) -> bool:
        """See api.Engine."""
        if key in self._attached:
            self.attach(key, *self._attached[key][1:])
        return key in self._attached

    def detach(self, key: Any) -> bool:
        """See api.Engine."""
        if key not in self._attached:
            return False
        joint, one, other = self._attached[key]
        if joint >= 0:
            self._api.removeConstraint(joint)
            self.set_pair_collision(one, other, True)
        self._attached[key] = -1, one, other
        return True

    def attach_by_joint(self, key: Any, parent: BodyLink, child: BodyLink, joint: Joint) -> bool:
        """See api.Engine."""
        return False

    def attached_state(self, key: Any) -> tuple[float, float]:
        """See api.Engine."""
        return 0.0, 0.0

    def add_attached_effort(self, key: Any, effort: float) -> None:
        """See api.Engine."""

    def attachments(self) -> dict[Any, tuple[BodyLink, BodyLink]]:
        """See api.Engine."""
        held = self._attached.items()
        return {key: (one, other) for key, (joint, one, other) in held if joint >= 0}

    # Contacts and rays --------------------------------------------------------------------------
    def all_contacts(self) -> tuple[Array, Array, Array]:
        """See api.Engine."""
        points = [
            (point[5], point[7], point[9])
            for point in self._api.getContactPoints()
            if point[9] > 0.0
        ]
        places, normals, forces = zip(*points) if points else ((), (), ())
        return np.reshape(places, (-1, 3)), np.reshape(normals, (-1, 3)), np.array(forces, float)

    def mesh_scene(
        self, meshes: Sequence[tuple[int, Pose, Array]], positions: Array, orientations: Array
    ) -> None:
        """See api.Engine."""
