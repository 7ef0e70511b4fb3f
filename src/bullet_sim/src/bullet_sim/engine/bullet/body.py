"""A model in the engine 'bullet': a body of PyBullet's, and the motors of its joints."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
import pybullet as p

from bullet_sim.description.lump import LumpedModel
from bullet_sim.description.mirrors import mirrored_joints, mirrored_links
from bullet_sim.description.model import ModelDescription
from bullet_sim.engine.api import Contact, ContactRows, JointState, Touch, contact_rows
from bullet_sim.engine.bullet.client import Loaded
from bullet_sim.engine.bullet.owner import Owner
from bullet_sim.errors import ModelError
from bullet_sim.pose import (
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

POSITION_GAIN = 0.1  # fraction of a position motor's error that is corrected in one step
TOLERANCE = 1e-6  # relative tolerance of principal axes that cannot change


class BulletMotor:
    """See api.Motor. PyBullet's motors keep their commands, so that they are written once.

    Attributes:
        uid, index: PyBullet's numbers of the body and of the joint.
        command: name of the method of the last command, and its arguments.
        applied: see api.Motor.
    """

    def __init__(self, engine: Owner, body: BulletBody, joint: str) -> None:
        self._api, self.uid = engine.client.api, body.loaded.uid
        self.index = body.loaded.joints[joint]
        self.applied: float | None = None
        self.command: tuple[str, tuple[float, ...]] = ("release", ())

    def _control(self, mode: int, **values: float) -> None:
        self._api.setJointMotorControl2(self.uid, self.index, mode, **values)

    def track_velocity(self, velocity: float, effort: float) -> None:
        """See api.Motor."""
        self.command, self.applied = ("track_velocity", (velocity, effort)), None
        self._control(p.VELOCITY_CONTROL, targetVelocity=velocity, force=effort)

    def track_position(self, position: float, effort: float, speed: float) -> None:
        """See api.Motor."""
        self.command, self.applied = ("track_position", (position, effort, speed)), None
        self._control(
            p.POSITION_CONTROL,
            targetPosition=position,
            force=effort,
            maxVelocity=speed,
            positionGain=POSITION_GAIN,
            velocityGain=1.0,
        )

    impose_velocity = track_velocity
    impose_position = track_position

    def release(self) -> None:
        """See api.Motor: a velocity motor to 0, with the friction as its effort."""
        self.command, self.applied = ("release", ()), None
        friction = self._api.getJointInfo(self.uid, self.index)[7]
        self._control(p.VELOCITY_CONTROL, targetVelocity=0.0, force=friction)

    def add_effort(self, effort: float) -> None:
        """See api.Motor."""
        self._control(p.TORQUE_CONTROL, force=effort)

    def set_position(self, position: float, speed: float = 0.0) -> None:
        """See api.Motor; speed: [rad/s, m/s] it has then."""
        self._api.resetJointState(self.uid, self.index, position, speed)

    def _change(self, **values: float) -> None:
        self._api.changeDynamics(self.uid, self.index, **values)

    def set_limits(self, lower: float, upper: float) -> None:
        """See api.Motor."""
        self._change(jointLowerLimit=lower, jointUpperLimit=upper)

    def set_damping(self, damping: float) -> None:
        """See api.Motor."""
        self._change(jointDamping=damping)

    def set_parameter(self, name: str, value: float) -> bool:
        """See api.Motor."""
        return False

    def measure_load(self) -> None:
        """See api.Motor."""
        self._api.enableJointForceTorqueSensor(self.uid, self.index, 1)

    def load(self) -> tuple[Array, Array, float]:
        """See api.Motor."""
        _, _, load, effort = self._api.getJointState(self.uid, self.index)
        force, torque = np.array(load[:3]), np.array(load[3:])
        center, axes = self._api.getDynamicsInfo(self.uid, self.index)[3:5]
        turn = matrix_from_quaternion(axes)
        force, torque = turn @ force, turn @ torque  # PyBullet: along the principal axes
        return force, torque + np.cross(center, force), effort


class BulletBody:
    """See api.Body.

    Attributes:
        motors: by the names of their joints.
    """

    def __init__(
        self,
        engine: Owner,
        loaded: Loaded,
        model: LumpedModel,
        description: ModelDescription,
    ) -> None:
        self._engine, self.loaded, self.number = engine, loaded, loaded.uid
        self._api = engine.client.api
        self.links = mirrored_links(model)
        self.joints = [joint.name for joint in (*model.joints, *model.welds)]
        above = {joint.child: joint.name for joint in mirrored_joints(model)}
        self._mirrored = [self.joints.index(above[name]) for name in self.links if name in above]
        self.is_fixed = description.static or model.fixed_base
        self.root = model.root
        self.motors = {name: BulletMotor(engine, self, name) for name in self.joints}
        self._indices = [loaded.joints[name] for name in self.joints]

    @property
    def moves(self) -> bool:
        """See api.Body."""
        return not self.is_fixed or bool(self.joints)

    def motor(self, joint: str) -> BulletMotor:
        """See api.Body."""
        return self.motors[joint]

    def pose(self) -> tuple[Vec3, Quat]:
        """See api.Body."""
        return self._engine.client.link_frame((self.number, self.root))

    def set_pose(self, position: Vector, orientation: Vector) -> None:
        """See api.Body."""
        self._engine.placements += 1
        pose = Pose(tuple(position), tuple(orientation))  # type: ignore[arg-type]
        self._engine.client.put(self.number, pose, self.moves)

    def set_velocity(self, linear: Vector, angular: Vector) -> None:
        """See api.Body."""
        arm = np.subtract(self.link_center(self.root), self.pose()[0])
        linear = np.asarray(linear, float) + np.cross(angular, arm)
        self._api.resetBaseVelocity(self.number, tuple(linear), tuple(angular))

    def hold_velocity(self, velocity: Vec3) -> None:
        """See api.Body."""

    is_held = False

    def place_link(self, link: str, pose: Pose, linear: Vector, angular: Vector) -> None:
        """See api.Body."""
        if link != self.root:
            raise ModelError(
                "the solver 'bullet' cannot put a link that hangs on a joint; "
                "set the pose of its model, or the position of the joint"
            )
        self.set_pose(pose.position, pose.orientation)
        if self.moves:
            self.set_velocity(linear, angular)

    def set_link_velocity(self, link: str, linear: Vector) -> None:
        """See api.Body."""
        if link == self.root and self.moves:
            self.set_velocity(linear, self.link_motion(link)[3])

    def gather(self) -> None:
        """See api.Body: none is loose."""

    def _motion(self, link: str) -> tuple[Vec3, Vec3, Vec3, tuple[Vec3, Quat]]:
        """Center of mass [m], linear and angular velocity, and pose of a link's frame."""
        client = self._engine.client
        uid, index = client.index((self.number, link))
        if index < 0:
            center = self._api.getBasePositionAndOrientation(uid)[0]
            velocities = self._api.getBaseVelocity(uid)
            return (center, *velocities, client.link_frame((self.number, link)))
        state = self._api.getLinkState(
            uid, index, computeLinkVelocity=1, computeForwardKinematics=1
        )
        return state[0], state[6], state[7], state[4:6]

    def link_motion(self, link: str, offset: tuple[Vec3, Quat] | None = None) -> Motion:
        """See api.Body."""
        center, linear, angular, (position, orientation) = self._motion(link)
        if offset is not None:
            position, orientation = compose(position, orientation, *offset)
        return position, orientation, velocity_at(position, center, linear, angular), angular

    def recorded_motion(self, link: str, offset: tuple[Vec3, Quat] | None = None) -> None:
        """See api.Body: there is none."""

    def link_center(self, link: str) -> Vec3:
        """See api.Body."""
        return self._motion(link)[0]

    def states(self) -> Sequence[tuple[Any, ...]]:
        """PyBullet's states of the joints."""
        indices = self._indices
        return self._api.getJointStates(self.number, indices) if indices else ()

    def joint_states(self) -> Sequence[tuple[float, float, float]]:
        """See api.Body."""
        return [
            (state[0], state[1], motor.applied or 0.0)
            for state, motor in zip(self.states(), self.motors.values())
        ]

    def read_joints(self, states: Iterable[JointState]) -> None:
        """See api.Body."""
        for joint, state in zip(states, self.states()):
            joint.position, joint.velocity = state[:2]

    def joint_positions(self) -> tuple[float, ...]:
        """See api.Body."""
        return tuple(state[0] for state in self.states())

    def set_joint_positions(self, positions: Vector) -> None:
        """See api.Body."""
        for motor, position in zip(self.motors.values(), positions):
            motor.set_position(position)

    def coordinates(self) -> tuple[float, ...]:
        """See api.Body."""
        positions = self.joint_positions()
        return tuple(positions[place] for place in self._mirrored)

    def apply_force(
        self, link: str, force: Vector, point: Vector, torque: Vector = (0.0, 0.0, 0.0)
    ) -> None:
        """See api.Body."""
        uid, index = self._engine.client.index((self.number, link))
        forces, torques = vector3(force), vector3(torque)
        self._api.applyExternalForce(uid, index, forces, vector3(point), p.WORLD_FRAME)
        if any(torques):
            self._api.applyExternalTorque(uid, index, torques, p.WORLD_FRAME)

    # Properties of links ------------------------------------------------------------------------
    def change(self, link: str, **values: Any) -> None:
        """Change what PyBullet's changeDynamics() takes of a link."""
        uid, index = self._engine.client.index((self.number, link))
        self._api.changeDynamics(uid, index, **values)

    def set_mass(self, link: str, mass: float, inertia: Array) -> None:
        """See api.Body."""
        uid, index = self._engine.client.index((self.number, link))
        axes = matrix_from_quaternion(self._api.getDynamicsInfo(uid, index)[4])
        rotated = axes.T @ inertia @ axes
        off = rotated - np.diag(np.diag(rotated))
        if np.abs(off).max() > TOLERANCE * np.abs(rotated).max():
            raise ModelError(
                f"inertia {np.asarray(inertia).tolist()} has other principal axes than the link, "
                "which the solver 'bullet' cannot change"
            )
        if index >= 0 or not self.is_fixed:  # PyBullet would release a fixed base
            self.change(link, mass=mass, localInertiaDiagonal=np.diag(rotated).tolist())

    def set_gravity(self, link: str, is_on: bool, mass: float, center: Vector) -> None:
        """See api.Body."""
        key = self.number, link
        self._engine.weightless = [part for part in self._engine.weightless if part[0] != key]
        if not is_on and not (self.is_fixed and link == self.root):
            self._engine.weightless.append((key, mass, vector3(center)))

    def set_friction(self, link: str, friction: float) -> None:
        """See api.Body; that of a pair is the product of both."""
        self.change(link, lateralFriction=friction)

    def set_slip(self, link: str, slip1: float, slip2: float) -> None:
        """See api.Body."""

    def set_bitmask(self, link: str, bits: int) -> None:
        """See api.Body. Rays hit it all the same, as in Gazebo, but for one that moves and has no
        bit at all."""
        self._engine.client.set_bitmask((self.number, link), bits)
        self._engine.note_layout("mask", self.number, link)

    # Contacts -----------------------------------------------------------------------------------
    def contacts(self, link: str) -> list[Contact]:
        """See api.Body; in Bullet's order, then those that push nothing."""
        client, own = self._engine.client, (self.number, link)
        uid, index = client.index(own)
        contacts = []
        for point in self._api.getContactPoints(bodyA=uid, linkIndexA=index):
            if point[8] > 0.0 and point[9] <= 0.0:  # near, but without contact
                continue
            normal = np.array(point[7])
            force = (
                point[9] * normal
                + point[10] * np.array(point[11])
                + point[12] * np.array(point[13])
            )
            other = client.link(point[2], point[4])
            contacts.append(Contact(*other, np.array(point[5]), normal, -point[8], force))
        return contacts + self._engine.passable.overlapping(own, self._engine.bodies)

    def records_contacts(self, link: str) -> bool:
        """See api.Body."""
        return False

    def contact_rows(self, link: str) -> ContactRows:
        """See api.Body."""
        return contact_rows(self.contacts(link))

    def touching(self) -> list[Touch]:
        """See api.Body."""
        client = self._engine.client
        return [
            Touch(client.link(point[1], point[3])[1], *client.link(point[2], point[4]), point[9])
            for point in self._api.getContactPoints(bodyA=self.number)
            if point[9] > 0.0
        ]
