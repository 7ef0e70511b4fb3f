"""Bodies in PyBullet: loaded, placed, driven and stepped by Bullet; their contacts."""

from __future__ import annotations

import functools
import zlib
from collections.abc import Iterable, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import pybullet as p

from bullet_sim.controllers.effort_row import EffortRow
from bullet_sim.description.lump import LumpedModel, lump, without_chains
from bullet_sim.description.model import Joint, ModelDescription
from bullet_sim.description.world import OdeSettings
from bullet_sim.engine.ode_shapes import mesh_triangles
from bullet_sim.engine.passable import Passable
from bullet_sim.errors import ModelError
from bullet_sim.files import silenced
from bullet_sim.pose import (
    Array,
    Motion,
    Pose,
    Quat,
    Vec3,
    Vector,
    compose,
    matrix_from_quaternion,
    velocity_at,
)

if TYPE_CHECKING:
    from bullet_sim.controllers.handle import JointHandle

FRICTION = 1.0  # coefficient where a file gives none, as in Gazebo
# PyBullet has one maximum for all joints of a body and cuts their speeds there, 100 by default:
# the limits of single joints are applied to their commands.
MAX_COORDINATE_SPEED = 1e4  # [rad/s, m/s]
_MOVABLE = (p.JOINT_REVOLUTE, p.JOINT_PRISMATIC)
_FLAGS = (
    p.URDF_USE_IMPLICIT_CYLINDER
    | p.URDF_USE_INERTIA_FROM_FILE
    | p.URDF_USE_MATERIAL_COLORS_FROM_MTL
)
# Bits that a link with a collide_bitmask of its own shares with all that have none, and where its
# own bits begin.
_COMMON, _SHIFT = 3, 8
_STATIC, _GHOST = 2, 64  # Bullet's group of what never moves, our own of ghosts
SLEEP = (
    p.ACTIVATION_STATE_SLEEP | p.ACTIVATION_STATE_ENABLE_SLEEPING | p.ACTIVATION_STATE_ENABLE_WAKEUP
)


@dataclass(frozen=True)
class Contact:
    """One contact point, seen from body A.

    Attributes:
        body, link: the engine's numbers of the other body and its link.
        position: (3,) [m] on A, in the world.
        normal: (3,) unit vector from the other body towards A, in the world.
        depth: penetration [m]; negative: a gap within the margin.
        force: (3,) [N] on A, world axes.
        is_first: A is the first of both in Gazebo.
    """

    body: int
    link: int
    position: Array
    normal: Array
    depth: float
    force: Array
    is_first: bool = True


class Engine:
    """One headless PyBullet client, whose bodies Bullet moves; OdeEngine is the other kind.

    A `body` is the number that load() returns, a `link` an index of link_indices() (-1: the root
    link), a `joint` the number of a movable joint in joint_names().

    Args:
        time_step: physics step [s].
        gravity: acceleration in the world frame [m/s^2].
        solver_iterations: of the constraint solver per step.
        draw: load what bodies look like, for a PyBulletCamera. An engine that draws nothing would
            decode the textures of all meshes for nothing.

    Attributes:
        client: PyBullet's number of the client.
        movable: body -> PyBullet's indices of its movable joints.
        chains: body -> name -> PyBullet's index of those by which loose links and screws move
            besides (see chain_of), of bodies with such.
        free: bodies whose root link is not fixed to the world.
        position_gain: fraction of a position motor's error that is corrected in one step.
        layout: number of what was loaded, removed or filtered since clear(): it gives bodies their
            numbers in the broad phase.
        passable: links that push nothing.
        placements: how often bodies were put somewhere; what is static stays in between.
        computes_pids: whether controlled() can be used.
        keeps_states: whether save_solver() has the state of all bodies.
        adds_motor_effort: whether the effort of a joint is what is applied and its motor's, or the
            former alone, as Gazebo's Joint::GetForce.
        casts_at_meshes: whether mesh_scene() can be used.
    """

    position_gain = 0.1
    keeps_states = False
    placements = 0
    computes_pids = False
    adds_motor_effort = True
    casts_at_meshes = False

    def __init__(
        self,
        time_step: float = 0.001,
        gravity: Vec3 = (0.0, 0.0, -9.81),
        solver_iterations: int = 50,
        draw: bool = False,
    ) -> None:
        self.time_step, self.gravity = float(time_step), vector3(gravity)
        self.solver_iterations = int(solver_iterations)
        self._flags = _FLAGS if draw else _FLAGS | p.URDF_IGNORE_VISUAL_SHAPES
        self._number = -1  # of the client, once it is connected
        self._forget()
        self._open()

    @property
    def client(self) -> int:
        """PyBullet's number of this engine; its bodies are put where the solver has them first."""
        self._sync()
        return self._client

    @property
    def _client(self) -> int:
        return self._number

    # What an engine that moves the bodies by itself has to add.

    def _sync(self) -> None:
        """Put PyBullet's bodies where they are."""

    @property
    def settings(self) -> OdeSettings | None:
        """What was configured, where all of it has an effect; None with Bullet."""
        return None

    def configure(self, settings: OdeSettings) -> None:
        """Set what a world file says of the solver, of which Bullet knows the iterations."""
        self.set_solver_iterations(settings.iterations)

    def is_compiled(self) -> bool:
        """Whether compile() has nothing to do."""
        return True

    def compile(self) -> None:
        """Compile what the first step would else have to compile."""

    def lump(self, description: ModelDescription) -> LumpedModel:
        """The bodies and joints that are made of a description."""
        return lump(description)

    def controlled(self, pids: Sequence[EffortRow], notes: bool) -> AbstractContextManager[None]:
        """Compute PIDs before each of the steps that are made meanwhile, see OdeSolver."""
        raise NotImplementedError

    def noted(self, body: int, joints: Iterable[int], count: int) -> list[list[float]]:
        """Positions of joints before each of the steps of controlled(), see OdeSolver."""
        raise NotImplementedError

    def save_solver(self) -> Any:
        """What the solver has beyond PyBullet's state."""

    def restore_solver(self, state: Any) -> None:
        """Restore what save_solver() gave."""

    def _open(self) -> None:
        """Connect a client of PyBullet."""
        with silenced():
            self._number = p.connect(p.DIRECT)
        self._set_up()

    def _forget(self) -> None:
        """Know no body any more."""
        self.movable: dict[int, list[int]] = {}
        self.chains: dict[int, dict[str, int]] = {}
        self.passable = Passable(lambda: self._client)
        self.free: set[int] = set()
        self._inertial: dict[int, tuple[Vec3, Quat]] = {}  # the root's center in its frame
        self._outward: dict[int, tuple[Vec3, Quat]] = {}  # ... and back
        # (body, link, mass [kg], center [m] in the link's frame) of what gravity does not act on
        self._weightless: list[tuple[int, int, float, Vec3]] = []
        self._motors: dict[tuple[int, int], tuple[str, tuple[Any, ...]]] = {}  # see motors()
        self._attached: dict[Any, tuple[int, tuple[int, int], tuple[int, int]]] = {}
        self.layout = 0

    def _set_up(self) -> None:
        """Tell the client all but bodies."""
        client = self._number
        p.setTimeStep(self.time_step, physicsClientId=client)
        p.setGravity(*self.gravity, physicsClientId=client)
        p.setPhysicsEngineParameter(
            numSolverIterations=self.solver_iterations,
            deterministicOverlappingPairs=1,
            enableFileCaching=0,
            physicsClientId=client,
        )

    def close(self) -> None:
        """Disconnect; the engine is not usable afterwards."""
        if self._number >= 0:
            p.disconnect(physicsClientId=self._number)
            self._number = -1

    def clear(self) -> None:
        """Remove every body and return to the state of a new engine."""
        p.resetSimulation(physicsClientId=self._number)
        self._forget()
        self._set_up()

    def set_gravity(self, gravity: Vec3) -> None:
        """Set gravity [m/s^2] in the world frame."""
        self.gravity = vector3(gravity)
        p.setGravity(*self.gravity, physicsClientId=self.client)

    def set_time_step(self, time_step: float) -> None:
        """Set the physics step [s]."""
        self.time_step = float(time_step)
        p.setTimeStep(self.time_step, physicsClientId=self.client)

    def set_solver_iterations(self, count: int) -> None:
        """Change the iterations of the constraint solver per step."""
        self.solver_iterations = int(count)
        p.setPhysicsEngineParameter(
            numSolverIterations=self.solver_iterations, physicsClientId=self.client
        )

    def note_layout(self, *event: object) -> None:
        """Note what gives bodies numbers in the broad phase."""
        self.layout = zlib.crc32(repr((self.layout, event)).encode())

    def step(self, count: int = 1) -> None:
        """Advance by `count` time steps."""
        step, client = p.stepSimulation, self.client
        for _ in range(count):
            self._lift()
            step(client)

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
        """Load a prepared URDF file; its root link's frame lands at the given world pose.

        Args:
            fixed_base: the root link never moves.
            self_collide: links collide with each other, those of one joint excepted.
            static: prepared as static: one link, of which meshes collide as they are. Such a body
                is none of PyBullet's multibodies, which cost time in every step; link_indices()
                does not know its link, -1.

        Raises:
            ModelError: PyBullet refuses the file.
        """
        client = self.client
        body = self._read_file(path, fixed_base, self_collide, static)
        self._note_center(body, static)
        count = p.getNumJoints(body, physicsClientId=client)
        joints = [p.getJointInfo(body, i, physicsClientId=client) for i in range(count)]
        moving = [j for j in joints if j[2] in _MOVABLE]
        movable, chain = without_chains({j[0]: j[1].decode() for j in moving})
        self._know(body, movable, chain, fixed_base, count)
        for link, damping in ((-1, -1.0), *((j[0], j[6]) for j in joints)):
            p.changeDynamics(
                body,
                link,
                linearDamping=0.0,
                angularDamping=0.0,
                jointDamping=damping,
                restitution=0.0,
                maxJointVelocity=MAX_COORDINATE_SPEED,
                physicsClientId=client,
            )
        for joint in range(len(self.movable[body])):
            self.release(body, joint)
        for joint in chain.values():
            p.setJointMotorControl2(
                body, joint, p.VELOCITY_CONTROL, force=0.0, physicsClientId=client
            )
        self.set_base_pose(body, position, orientation)
        return body

    def _read_file(self, path: str, fixed_base: bool, self_collide: bool, static: bool) -> int:
        """Have PyBullet load a file, see load()."""
        try:
            with silenced():
                body: int = p.loadURDF(
                    path,
                    (0, 0, 0),
                    (0, 0, 0, 1),
                    useFixedBase=fixed_base,
                    useMaximalCoordinates=static,
                    flags=self._flags | (p.URDF_USE_SELF_COLLISION if self_collide else 0),
                    physicsClientId=self._number,
                )
        except p.error as error:
            raise ModelError(f"PyBullet cannot load {path}: {error}") from error
        return body

    def _note_center(self, body: int, static: bool) -> None:
        """Note where PyBullet has the root link's center of mass and principal axes."""
        center = Pose()  # of what is static; PyBullet has a quaternion of zeros for it
        if not static:
            info = p.getDynamicsInfo(body, -1, physicsClientId=self._number)
            center = Pose(info[3], info[4])
        self._inertial[body] = (center.position, center.orientation)
        outward = center.inverse()
        self._outward[body] = (outward.position, outward.orientation)

    def remove(self, body: int) -> None:
        """Remove a body."""
        for key, (_, one, other) in list(self._attached.items()):
            if body in (one[0], other[0]):
                self.detach(key)
                del self._attached[key]
        p.removeBody(body, physicsClientId=self.client)
        del self._inertial[body], self._outward[body]
        self._drop(body)

    def _know(
        self,
        body: int,
        movable: list[int],
        chain: dict[str, int],
        fixed_base: bool,
        count: int,
    ) -> None:
        """Note what was loaded; count: of its joints."""
        self.movable[body] = movable
        if chain:
            self.chains[body] = chain
        if not fixed_base:
            self.free.add(body)
        self.note_layout("load", body, count)

    def _drop(self, body: int) -> None:
        """Know a body no more."""
        del self.movable[body]
        self.chains.pop(body, None)
        self.free.discard(body)
        self.passable.remove(body)
        self._weightless = [part for part in self._weightless if part[0] != body]
        self._motors = {key: call for key, call in self._motors.items() if key[0] != body}
        self.note_layout("remove", body)

    def joint_names(self, body: int) -> list[str]:
        """Names of the movable joints, in joint order."""
        return [
            p.getJointInfo(body, i, physicsClientId=self.client)[1].decode()
            for i in self.movable[body]
        ]

    def link_indices(self, body: int) -> dict[str, int]:
        """Map of link name -> link index; the root link has -1."""
        names = {p.getBodyInfo(body, physicsClientId=self.client)[0].decode(): -1}
        for i in range(p.getNumJoints(body, physicsClientId=self.client)):
            names[p.getJointInfo(body, i, physicsClientId=self.client)[12].decode()] = i
        return names

    def take(
        self,
        body: int,
        model: LumpedModel,
        links: Mapping[str, int],
        description: ModelDescription,
        touching: Sequence[tuple[str, str]],
    ) -> None:
        """Take what PyBullet does not read from the file of a body that was loaded.

        Args:
            model: of which the file was made.
            links: name -> link index, of the model.
            description: with the links that fixed joints have merged.
            touching: pairs of links that collide with each other.
        """
        for number in self.passable.take(body, model, links):
            self.set_bitmask(body, number, 0)
        for name, link in model.links.items():
            surface = link.surface
            friction = FRICTION if surface.friction is None else surface.friction
            if description.static:  # the product counts, and Gazebo's grounds have 100
                friction = min(friction, FRICTION)
            self.set_friction(body, links[name], friction)
            if surface.stiffness is not None and surface.damping is not None:
                p.changeDynamics(
                    body,
                    links[name],
                    contactStiffness=surface.stiffness,
                    contactDamping=surface.damping,
                    physicsClientId=self._client,
                )
        if not description.static:
            self._weightless += [
                (body, links[part], link.mass, (frame * Pose(tuple(link.center))).position)
                for link in description.links.values()
                if not link.gravity and link.mass > 0.0
                for part, frame in (model.frames[link.name],)
            ]

    def _lift(self) -> None:
        """Balance the weight of what has none, for the next step."""
        for body, link, mass, center in self._weightless:
            point = self.link_motion(body, link, (center, (0.0, 0.0, 0.0, 1.0)))[0]
            self.apply_force(body, link, [-mass * g for g in self.gravity], point)

    def set_link_gravity(
        self, body: int, link: int, is_on: bool, mass: float, center: Vector
    ) -> None:
        """Have gravity act on a link, or not; mass [kg] and center [m] in its frame are its own."""
        self._weightless = [each for each in self._weightless if each[:2] != (body, link)]
        if not is_on:
            self._weightless.append((body, link, mass, vector3(center)))

    def set_mass(self, body: int, link: int, mass: float, inertia: Array) -> None:
        """Change a link's mass [kg] and its inertia (3, 3) [kg m^2]; PyBullet's principal axes
        stay."""
        axes = matrix_from_quaternion(self.principal_axes(body, link))
        moments = np.diag(axes.T @ inertia @ axes).tolist()
        p.changeDynamics(
            body, link, mass=mass, localInertiaDiagonal=moments, physicsClientId=self.client
        )

    def principal_axes(self, body: int, link: int) -> Quat:
        """Quaternion of the axes of a link's moments of inertia, in the link frame."""
        return p.getDynamicsInfo(body, link, physicsClientId=self.client)[4]

    def set_joint_limits(self, body: int, joint: int, lower: float, upper: float) -> None:
        """Change the limits [rad, m] of a movable joint that has limits."""
        p.changeDynamics(
            body,
            self.movable[body][joint],
            jointLowerLimit=lower,
            jointUpperLimit=upper,
            physicsClientId=self.client,
        )

    def set_joint_damping(self, body: int, joint: int, damping: float) -> None:
        """Change the viscous damping [N m s/rad, N s/m] of a movable joint."""
        p.changeDynamics(
            body, self.movable[body][joint], jointDamping=damping, physicsClientId=self.client
        )

    def set_joint_parameter(self, body: int, joint: int, name: str, value: float) -> bool:
        """Change a parameter of a joint that ODE alone has: see OdeSolver.set_parameter.

        Returns:
            Whether this solver has it.
        """
        return False

    # Motion

    def base_pose(self, body: int) -> tuple[Vec3, Quat]:
        """World pose of the root link's frame."""
        position, orientation = p.getBasePositionAndOrientation(body, physicsClientId=self.client)
        return compose(position, orientation, *self._outward[body])

    def set_base_pose(self, body: int, position: Vector, orientation: Vector) -> None:
        """Move the root link's frame to a world pose; joints and velocities stay."""
        self.put(body, *compose(position, orientation, *self._inertial[body]))

    def put(self, body: int, position: Vector, orientation: Vector) -> None:
        """Move the root link's principal axes to a world pose."""
        self.placements += 1
        client = self.client
        p.resetBasePositionAndOrientation(body, position, orientation, physicsClientId=client)
        if not self.moves(body):  # Bullet need not look at its bounds in each step
            p.changeDynamics(body, -1, activationState=SLEEP, physicsClientId=client)

    def set_base_velocity(self, body: int, linear: Vector, angular: Vector) -> None:
        """Set the velocity of the root link's frame origin [m/s, rad/s], world axes."""
        arm = np.subtract(self.link_center(body, -1), self.base_pose(body)[0])
        linear = np.asarray(linear, float) + np.cross(angular, arm)
        p.resetBaseVelocity(body, tuple(linear), tuple(angular), physicsClientId=self.client)

    def set_velocity(self, body: int, linear: Vector, angular: Vector) -> None:
        """Set the velocity of a model [m/s, rad/s], world axes: that of its root link's frame;
        joints keep theirs."""
        self.set_base_velocity(body, linear, angular)

    def link_motion(
        self, body: int, link: int, offset: tuple[Vec3, Quat] | None = None
    ) -> tuple[Vec3, Quat, Vec3, Vec3]:
        """Pose and velocity of a link frame in the world.

        Args:
            offset: pose of another frame of the link, in the link frame, that is meant instead.

        Returns:
            position [m], quaternion, linear [m/s] of the frame's origin, angular [rad/s];
            velocities along world axes.
        """
        center, linear, angular, (position, orientation) = self.link_velocity(body, link)
        if link < 0:
            position, orientation = compose(position, orientation, *self._outward[body])
        if offset is not None:
            position, orientation = compose(position, orientation, *offset)
        return position, orientation, velocity_at(position, center, linear, angular), angular

    def link_velocity(self, body: int, link: int) -> tuple[Vec3, Vec3, Vec3, tuple[Vec3, Quat]]:
        """Center of mass [m] of a link, its linear [m/s] and angular velocity [rad/s], world axes,
        and the pose of the frame that PyBullet keeps: of the root link that of its inertia, else
        the link's own."""
        if link < 0:
            pose = p.getBasePositionAndOrientation(body, physicsClientId=self.client)
            linear, angular = p.getBaseVelocity(body, physicsClientId=self.client)
            return pose[0], linear, angular, pose
        state = p.getLinkState(
            body,
            link,
            computeLinkVelocity=1,
            computeForwardKinematics=1,
            physicsClientId=self.client,
        )
        return state[0], state[6], state[7], state[4:6]

    def link_motions(self, body: int, links: Sequence[int]) -> list[Motion]:
        """As link_motion, of several links of a body in one call."""
        below = [link for link in links if link >= 0]
        states = (
            p.getLinkStates(
                body,
                below,
                computeLinkVelocity=1,
                computeForwardKinematics=1,
                physicsClientId=self.client,
            )
            if below
            else ()
        )
        motions = {
            link: (state[4], state[5], velocity_at(state[4], state[0], *state[6:8]), state[7])
            for link, state in zip(below, states)
        }
        if len(below) < len(links):
            motions[-1] = self.link_motion(body, -1)
        return [motions[link] for link in links]

    def link_poses(self, body: int) -> tuple[Array, Array]:
        """World poses of all link frames: (n + 1, 3) and (n + 1, 4); row 0 is the root link."""
        position, orientation = self.base_pose(body)
        positions, orientations = [position], [orientation]
        count = p.getNumJoints(body, physicsClientId=self.client)
        if count:
            for state in p.getLinkStates(
                body, range(count), computeForwardKinematics=1, physicsClientId=self.client
            ):
                positions.append(state[4])
                orientations.append(state[5])
        return np.array(positions), np.array(orientations)

    def link_center(self, body: int, link: int) -> Vec3:
        """Center of mass [m] of a link in the world."""
        if link < 0:
            return p.getBasePositionAndOrientation(body, physicsClientId=self.client)[0]
        return p.getLinkState(body, link, computeForwardKinematics=1, physicsClientId=self.client)[
            0
        ]

    def link_centre(self, body: int, link: int) -> Vec3:
        """Former name of link_center()."""
        return self.link_center(body, link)

    def joint_states(self, body: int) -> Sequence[tuple[float, float, Sequence[float], float]]:
        """(position, velocity, reaction forces, motor effort) of each movable joint."""
        joints = self.movable[body]
        return p.getJointStates(body, joints, physicsClientId=self.client) if joints else ()

    def read_joints(self, body: int, handles: Iterable[JointHandle]) -> None:
        """Read positions and velocities of the movable joints into handles, in their order."""
        for handle, state in zip(handles, self.joint_states(body)):
            handle.position, handle.velocity = state[:2]

    def joint_positions(self, body: int) -> tuple[float, ...]:
        """Positions [rad, m] of the movable joints."""
        return tuple(state[0] for state in self.joint_states(body))

    def coordinates(self, body: int) -> tuple[float, ...]:
        """Positions [rad, m] of all joints of a body, in PyBullet's order: also of its chains."""
        positions = self.joint_positions(body)
        if body not in self.chains:
            return positions
        found = dict(zip(self.movable[body], positions))
        found.update(zip(self.chains[body].values(), self._chain_positions(body)))
        return tuple(found[joint] for joint in sorted(found))

    def _chain_positions(self, body: int) -> Sequence[float]:
        joints = list(self.chains[body].values())
        states = p.getJointStates(body, joints, physicsClientId=self.client)
        return [state[0] for state in states]

    def set_coordinates(self, body: int, positions: Vector) -> None:
        """Set all joints to positions [rad, m] in the order of coordinates(), at rest."""
        joints = sorted([*self.movable[body], *self.chains.get(body, {}).values()])
        for joint, position in zip(joints, positions):
            p.resetJointState(body, joint, position, 0.0, physicsClientId=self.client)

    def place_link(
        self, body: int, link: int, position: Vector, orientation: Vector, linear: Vector,
        angular: Vector,
    ) -> None:  # fmt: skip
        """Put one link's frame to a world pose, with a velocity of its center of mass [m/s, rad/s]
        along world axes. With Bullet it is a root link, and takes the others along.

        Raises:
            ModelError: it is below a joint, with Bullet.
        """
        if link >= 0:
            raise ModelError(
                "the solver 'bullet' cannot put a link that hangs on a joint; "
                "set the pose of its model, or the position of the joint"
            )
        self.set_base_pose(body, position, orientation)
        if self.moves(body):
            self.set_velocity(body, linear, angular)

    def gather(self, body: int) -> None:
        """Put the loose links of a body where they started, relative to its root link; none is
        loose with Bullet."""

    def set_joint_positions(self, body: int, positions: Vector) -> None:
        """Set the movable joints to positions (n,) [rad, m], at rest."""
        for joint, position in zip(self.movable[body], positions):
            p.resetJointState(body, joint, position, 0.0, physicsClientId=self.client)

    def put_joint(self, body: int, joint: int, position: float) -> None:
        """Set a movable joint to a position [rad, m], at rest."""
        p.resetJointState(
            body, self.movable[body][joint], position, 0.0, physicsClientId=self.client
        )

    def measure_joint(self, body: int, joint: int) -> None:
        """Have the forces of a joint measured from the next step on."""
        link = self.movable[body][joint]
        p.enableJointForceTorqueSensor(body, link, 1, physicsClientId=self.client)

    def joint_load(self, body: int, joint: int) -> tuple[Array, Array, float]:
        """What a measured joint exerts on its child link.

        Returns:
            force (3,) [N] and torque (3,) [N m] about the joint in the link's axes, without what
            its motor does; the motor's effort [N m, N].
        """
        link = self.movable[body][joint]
        _, _, load, effort = p.getJointState(body, link, physicsClientId=self.client)
        force, torque = np.array(load[:3]), np.array(load[3:])
        center, axes = p.getDynamicsInfo(body, link, physicsClientId=self.client)[3:5]
        turn = np.array(p.getMatrixFromQuaternion(axes)).reshape(3, 3)
        force, torque = turn @ force, turn @ torque  # PyBullet: along the principal axes
        return force, torque + np.cross(center, force), effort

    # Motors keep their command from step to step, forces and efforts last one step.

    def drive_velocity(self, body: int, joint: int, velocity: float, effort: float) -> None:
        """Set a joint's motor to a velocity [rad/s, m/s], with at most `effort` [N m, N]."""
        self._motors[body, joint] = "drive_velocity", (joint, velocity, effort)
        p.setJointMotorControl2(
            body,
            self.movable[body][joint],
            p.VELOCITY_CONTROL,
            targetVelocity=velocity,
            force=effort,
            physicsClientId=self.client,
        )

    def impose_velocity(self, body: int, joint: int, velocity: float, effort: float) -> None:
        """Move a joint as Gazebo's Joint::SetVelocity does [rad/s, m/s]: by a motor here, with at
        most `effort` [N m, N]."""
        self.drive_velocity(body, joint, velocity, effort)

    def impose_position(
        self, body: int, joint: int, position: float, effort: float, velocity: float
    ) -> None:
        """Move a joint as Gazebo's Joint::SetPosition does [rad, m]: by a motor here, see
        drive_position()."""
        self.drive_position(body, joint, position, effort, velocity)

    def drive_position(
        self, body: int, joint: int, position: float, effort: float, velocity: float
    ) -> None:
        """Set a joint's motor to a position, with at most `effort` and `velocity`."""
        self._motors[body, joint] = "drive_position", (joint, position, effort, velocity)
        p.setJointMotorControl2(
            body,
            self.movable[body][joint],
            p.POSITION_CONTROL,
            targetPosition=position,
            force=effort,
            maxVelocity=velocity,
            positionGain=self.position_gain,
            velocityGain=1.0,
            physicsClientId=self.client,
        )

    def release(self, body: int, joint: int) -> None:
        """Release a joint to its friction: a velocity motor to 0 with the friction as its effort.

        The motor stays on under drive_efforts: an effort has to overcome it, as in a real joint.
        """
        self._motors[body, joint] = "release", (joint,)
        index = self.movable[body][joint]
        friction = p.getJointInfo(body, index, physicsClientId=self.client)[7]
        p.setJointMotorControl2(
            body,
            index,
            p.VELOCITY_CONTROL,
            targetVelocity=0.0,
            force=friction,
            physicsClientId=self.client,
        )

    def motors(self) -> dict[tuple[int, int], tuple[str, tuple[Any, ...]]]:
        """(body, joint) -> last command of its motor: method, its arguments after the body."""
        return self._motors

    def drive_efforts(self, body: int, joints: Sequence[int], efforts: Sequence[float]) -> None:
        """Apply efforts [N m, N] to joints for the next step only."""
        movable = self.movable[body]
        p.setJointMotorControlArray(
            body,
            [movable[joint] for joint in joints],
            p.TORQUE_CONTROL,
            forces=efforts,
            physicsClientId=self.client,
        )

    def apply_wrench(self, body: int, link: int, force: Vector, torque: Vector) -> None:
        """Apply a force (3,) [N] at a link's center of mass and a torque (3,) [N m], along world
        axes, for the next step only; several add up."""
        self.apply_force(body, link, tuple(force), self.link_center(body, link))
        p.applyExternalTorque(body, link, tuple(torque), p.WORLD_FRAME, physicsClientId=self.client)

    def apply_force(self, body: int, link: int, force: Vector, point: Vector) -> None:
        """Apply a force (3,) [N] to a link at a world point for the next step only."""
        p.applyExternalForce(body, link, force, point, p.WORLD_FRAME, physicsClientId=self.client)

    def body_pose(self, body: int) -> tuple[Vec3, Quat]:
        """World pose of the root link's principal axes, the cheapest pose to ask for."""
        return p.getBasePositionAndOrientation(body, physicsClientId=self.client)

    # Attaching

    def attach(self, key: Any, one: tuple[int, int], other: tuple[int, int]) -> None:
        """Hold a link where it is now relative to another one, by a fixed joint; meanwhile they do
        not collide.

        Args:
            key: hashable, for the methods that follow; what it had attached is let go.
            one, other: (body, link).
        """
        self.detach(key)
        moving, still = (one, other) if self.moves(one[0]) else (other, one)
        there, joint = Pose(*self._center_frame(*moving)), -1
        pivot, second = (0.0, 0.0, 0.0), (-1, -1)  # of what is static PyBullet has no body for it
        if self.moves(still[0]):
            there = Pose(*self._center_frame(*still)).inverse() * there
            second = still
        if self.moves(moving[0]):
            joint = p.createConstraint(
                *moving,
                *second,
                p.JOINT_FIXED,
                (0, 0, 0),
                pivot,
                there.position,
                (0, 0, 0, 1),
                there.orientation,
                physicsClientId=self.client,
            )
        self._attached[key] = joint, one, other
        self.set_pair_collision(*one, *other, False)

    def attach_again(self, key: Any) -> bool:
        """Attach what was let go, as it was attached first; with Bullet where it is now.

        Returns:
            Whether the key is known.
        """
        if key not in self._attached:
            return False
        _, one, other = self._attached[key]
        self.attach(key, one, other)
        return True

    def detach(self, key: Any) -> bool:
        """Let go what attach() holds; whether the key is known, also of what is let go by now."""
        if key not in self._attached:
            return False
        joint, one, other = self._attached[key]
        if joint >= 0:
            p.removeConstraint(joint, physicsClientId=self.client)
            self.set_pair_collision(*one, *other, True)
        self._attached[key] = -1, one, other
        return True

    def attach_by_joint(
        self, key: Any, parent: tuple[int, int] | None, child: tuple[int, int], joint: Joint
    ) -> bool:
        """Connect a link with another one, or with the world, by a joint that is at 0 now;
        detach() lets it go.

        Args:
            key: as of attach().
            parent, child: (body, link); None: the world.
            joint: its anchor counts, not its names and origin.

        Returns:
            Whether it does: Bullet knows no such joints.
        """
        return False

    def attached_state(self, key: Any) -> tuple[float, float]:
        """Position [rad, m] and velocity [rad/s, m/s] of a joint of attach_by_joint()."""
        return 0.0, 0.0

    def add_attached_effort(self, key: Any, effort: float) -> None:
        """Have an effort [N m, N] act on such a joint in the next step."""

    def attachments(self) -> dict[Any, tuple[tuple[int, int], tuple[int, int]]]:
        """What attach() holds now: key -> both (body, link)."""
        held = self._attached.items()
        return {key: (one, other) for key, (joint, one, other) in held if joint >= 0}

    def _center_frame(self, body: int, link: int) -> tuple[Vec3, Quat]:
        """World pose of the principal axes of a link at its center of mass."""
        if link < 0:
            return p.getBasePositionAndOrientation(body, physicsClientId=self.client)
        state = p.getLinkState(body, link, computeForwardKinematics=1, physicsClientId=self.client)
        return state[0], state[1]

    # Contacts

    def set_slip(self, body: int, link: int, slip1: float, slip2: float) -> None:
        """Set how fast a link slips for a force along both directions of friction [m/(N s)]; with
        Bullet it has no effect."""

    def set_friction(self, body: int, link: int, friction: float) -> None:
        """Set the Coulomb coefficient of a link; that of a pair is the product of both."""
        p.changeDynamics(body, link, lateralFriction=friction, physicsClientId=self.client)

    def set_bitmask(self, body: int, link: int, bits: int) -> None:
        """Let a link touch only what shares a bit (of 16) with it; the others have all bits.

        Rays hit it all the same, as in Gazebo, but for one that moves by Bullet's steps and has no
        bit at all.
        """
        own = bits << _SHIFT
        self._set_filter(body, link, own, own | (_COMMON if bits else 0))

    def set_ghost(self, body: int, link: int) -> None:
        """Let a link touch only what never moves; rays go through it."""
        self._set_filter(body, link, _GHOST, _STATIC)

    def _set_filter(self, body: int, link: int, group: int, mask: int) -> None:
        p.setCollisionFilterGroupMask(body, link, group, mask, physicsClientId=self.client)
        self.note_layout("mask", body, link)

    def set_pair_collision(
        self, body: int, link: int, other: int, other_link: int, collide: bool
    ) -> None:
        """Enable or disable collision between two links, `other_link` of the body `other`."""
        p.setCollisionFilterPair(
            body, other, link, other_link, int(collide), physicsClientId=self.client
        )
        self.note_layout("pair", body, other)

    def touching(self, body: int) -> list[tuple[int, int, int, float]]:
        """Pairs in contact as of the last step: (link, other body, other link, force [N])."""
        return [
            (point[3], point[2], point[4], point[9])
            for point in p.getContactPoints(bodyA=body, physicsClientId=self.client)
            if point[9] > 0.0
        ]

    def pair_depth(self, body: int, link: int, other: int, other_link: int) -> float:
        """How deep [m] two links overlap, also where they pass through each other; 0: not."""
        points = p.getClosestPoints(body, other, 0.0, link, other_link, physicsClientId=self.client)
        return max((-point[8] for point in points), default=0.0)

    def moves(self, body: int) -> bool:
        """Whether a body can move, as a whole or in its joints."""
        return bool(self.movable.get(body)) or body in self.free or body in self.chains

    def contacts(self, body: int, link: int) -> list[Contact]:
        """Contact points of one link that press or touch as of the last step, in Bullet's order."""
        found = []
        for point in p.getContactPoints(bodyA=body, linkIndexA=link, physicsClientId=self.client):
            if point[8] > 0.0 and point[9] <= 0.0:  # near, but without contact
                continue
            normal = np.array(point[7])
            force = (
                point[9] * normal
                + point[10] * np.array(point[11])
                + point[12] * np.array(point[13])
            )
            found.append(Contact(point[2], point[4], np.array(point[5]), normal, -point[8], force))
        return found + self.overlaps(body, link)

    def overlaps(self, body: int, link: int) -> list[Contact]:
        """Contacts of one link that push nothing, where the bodies are now."""
        if not self.passable:
            return []
        self._sync()
        return [
            Contact(other, its, np.array(point), np.array(normal), depth, np.zeros(3))
            for other, its, point, normal, depth in self.passable.overlaps(body, link, self.moves)
        ]

    def mesh_box(self, path: str) -> Array:
        """Two corners (2, 3) of the box around a mesh file; NaN: it cannot be read."""
        return _mesh_box(path)

    def all_contacts(self) -> tuple[Array, Array, Array]:
        """Contact points of all bodies that press, as of the last step.

        Returns:
            (n, 3) places [m], (n, 3) unit normals, (n,) normal forces [N], in the world frame.
        """
        return stacked(
            [
                (point[5], point[7], point[9])
                for point in p.getContactPoints(physicsClientId=self.client)
                if point[9] > 0.0
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
        """Distances to what the rays of a lidar hit first; a ray that begins inside a solid shape
        does not hit that.

        Args:
            center: (3,) [m] in the world, from which all come.
            directions: (n, 3) unit vectors, world axes.
            near, far: distances between which a hit is measured [m].
            own: body that does not count where it is nearer than `near`.
            look_near: whether to look for what is nearer than `near`.

        Returns:
            (n,) float64 [m]; inf: nothing up to `far`; -inf: something nearer than `near`.
        """
        ends = center + near * directions
        parts, _ = self._first_hits(ends, center + far * directions)
        ranges: Array = near + parts * (far - near)
        if look_near and near > 0.0:
            parts, bodies = self._first_hits(np.broadcast_to(center, ends.shape), ends)
            ranges[np.isfinite(parts) & (bodies != own)] = -np.inf
        return ranges

    def mesh_scene(
        self, meshes: Sequence[tuple[int, Pose, Array]], positions: Array, orientations: Array
    ) -> Any:
        """Triangles at which rays are cast, see OdeEngine."""
        raise NotImplementedError

    def _first_hits(self, starts: Array, ends: Array) -> tuple[Array, Array]:
        """Of rays between points (n, 3) the part (n,) of the way to the first hit, inf: none, and
        the bodies (n,) that PyBullet finds there."""
        hits: list[tuple[Any, ...]] = []
        limit, client = p.MAX_RAY_INTERSECTION_BATCH_SIZE, self.client
        for first in range(0, len(starts), limit):
            rays = starts[first : first + limit], ends[first : first + limit]
            hits += p.rayTestBatch(*rays, physicsClientId=client)
        bodies = np.array([hit[0] for hit in hits], int)
        return np.where(bodies >= 0, np.array([hit[2] for hit in hits], float), np.inf), bodies


@functools.lru_cache(maxsize=256)
def _mesh_box(path: str) -> Array:
    triangles = mesh_triangles(path)
    if triangles is None:
        return np.full((2, 3), np.nan)
    return np.stack([triangles.min(axis=(0, 1)), triangles.max(axis=(0, 1))])


def stacked(points: list[tuple[Vec3, Vec3, float]]) -> tuple[Array, Array, Array]:
    """Places, normals and forces of contact points, as all_contacts() returns them."""
    places, normals, forces = zip(*points) if points else ((), (), ())
    return np.reshape(places, (-1, 3)), np.reshape(normals, (-1, 3)), np.array(forces, float)


def vector3(values: Vector) -> Vec3:
    """Three floats."""
    x, y, z = values
    return float(x), float(y), float(z)
