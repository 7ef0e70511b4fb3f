"""Bodies in PyBullet: loaded, placed, driven; their contacts and what sensors read of them."""

import math
import operator

import numpy as np

from bullet_sim.engine.client import Client
from bullet_sim.engine.library import p
from bullet_sim.engine.states import Saving
from bullet_sim.engine.sweep import Sweep
from bullet_sim.errors import ModelError
from bullet_sim.files import silenced
from bullet_sim.pose import Pose, compose, velocity_at
from bullet_sim.sensors.contact import Contact


class Motion(Client):
    """How the bodies are placed and how they move."""

    def base_pose(self, body):
        """World pose of the root link's frame: position (3,), quaternion (4,) as tuples."""
        position, orientation = p.getBasePositionAndOrientation(body, physicsClientId=self._client)
        return compose(position, orientation, *self._outward[body])

    def set_base_pose(self, body, position, orientation):
        """Move the root link's frame to a world pose; joints and velocities stay."""
        pose = compose(position, orientation, *self._inertial[body])
        p.resetBasePositionAndOrientation(body, *pose, physicsClientId=self._client)
        if body in self._scenery:
            self._scenery.check_poses()

    def set_base_velocity(self, body, linear, angular):
        """Set the velocity of the root link's frame origin [m/s, rad/s], world axes."""
        centre = p.getBasePositionAndOrientation(body, physicsClientId=self._client)[0]
        arm = np.subtract(centre, self.base_pose(body)[0])
        linear = np.asarray(linear, float) + np.cross(angular, arm)
        p.resetBaseVelocity(body, tuple(linear), tuple(angular), physicsClientId=self._client)

    def link_state(self, body, link):
        """Pose and velocity of a link frame in the world.

        Args:
            link: index as link_indices gives it.

        Returns:
            position (3,) [m], quaternion (4,), linear (3,) [m/s] of the frame's origin, angular
            (3,) [rad/s]; velocities along world axes.
        """
        return tuple(map(np.array, self.link_motion(body, link)))

    def link_motion(self, body, link, offset=None):
        """As link_state, four tuples: several times as fast.

        Args:
            body, link: as link_indices gives it.
            offset: pose (position, quaternion) of another frame of the link in the link frame.
        """
        centre, linear, angular, (position, orientation) = self.link_velocity(body, link)
        if link < 0:
            position, orientation = compose(position, orientation, *self._outward[body])
        if offset is not None:
            position, orientation = compose(position, orientation, *offset)
        return position, orientation, velocity_at(position, centre, linear, angular), angular

    def link_poses(self, body):
        """World poses of all link frames: (n + 1, 3) and (n + 1, 4); row 0 is the root link."""
        position, orientation = self.base_pose(body)
        positions, orientations = [position], [orientation]
        count = p.getNumJoints(body, physicsClientId=self._client)
        if count:
            for state in p.getLinkStates(
                body, range(count), computeForwardKinematics=1, physicsClientId=self._client
            ):
                positions.append(state[4])
                orientations.append(state[5])
        return np.array(positions), np.array(orientations)

    def link_centre(self, body, link):
        """Centre of mass (3,) [m] of a link in the world."""
        if link < 0:
            return np.array(p.getBasePositionAndOrientation(body, physicsClientId=self._client)[0])
        return np.array(
            p.getLinkState(body, link, computeForwardKinematics=1, physicsClientId=self._client)[0]
        )

    def measure_joint(self, body, link):
        """Have the forces of the joint above a link measured from the next step on."""
        p.enableJointForceTorqueSensor(body, link, 1, physicsClientId=self._client)

    def joint_load(self, body, link):
        """What a measured joint exerts on its child link.

        Returns:
            force (3,) [N] and torque (3,) [N m] about the joint in the child link's axes, without
            what its motor does; the motor's effort [N m, N].
        """
        _, _, load, effort = p.getJointState(body, link, physicsClientId=self._client)
        force, torque = np.array(load[:3]), np.array(load[3:])
        centre, axes = p.getDynamicsInfo(body, link, physicsClientId=self._client)[3:5]
        turn = np.array(p.getMatrixFromQuaternion(axes)).reshape(3, 3)
        force, torque = turn @ force, turn @ torque  # PyBullet: along the principal axes
        return force, torque + np.cross(centre, force), effort

    def joint_states(self, body):
        """(position, velocity, reaction forces, motor effort) of each movable joint."""
        joints = self._movable[body]
        return p.getJointStates(body, joints, physicsClientId=self._client) if joints else ()

    def read_joints(self, body):
        """Positions, velocities and motor efforts of the movable joints, three (n,) arrays."""
        states = self.joint_states(body)
        return (
            np.array([s[0] for s in states]),
            np.array([s[1] for s in states]),
            np.array([s[3] for s in states]),
        )

    def set_joint_positions(self, body, positions):
        """Set the movable joints to positions (n,) [rad, m], at rest."""
        for joint, position in zip(self._movable[body], positions):
            p.resetJointState(body, joint, position, 0.0, physicsClientId=self._client)

    def put_joint(self, body, joint, position):
        """Set the movable joint number `joint` to a position [rad, m], at rest."""
        p.resetJointState(
            body, self._movable[body][joint], position, 0.0, physicsClientId=self._client
        )


class Motors(Client):
    """Motors keep their command from step to step, forces and efforts last one step.

    Attributes:
        position_gain: share of a position motor's error that is corrected in one step.
    """

    position_gain = 0.1

    def drive_velocity(self, body, joint, velocity, effort):
        """Set the motor of movable joint number `joint` to a velocity, with at most `effort`."""
        self._note_batch(body)
        self._motors[body, joint] = "drive_velocity", (joint, velocity, effort)
        p.setJointMotorControl2(
            body,
            self._movable[body][joint],
            p.VELOCITY_CONTROL,
            targetVelocity=velocity,
            force=effort,
            physicsClientId=self._client,
        )

    def drive_velocities(self, body, joints, velocities, efforts):
        """As drive_velocity, of several joints in one call.

        The lists must not change later. The same list of joints again is faster than an equal one.
        """
        before = self._batches.get(body)
        if before is not None and before[0] is joints:
            indices = before[3]
        else:
            self._note_batch(body)
            indices = [self._movable[body][joint] for joint in joints]
        self._batches[body] = joints, velocities, efforts, indices
        p.setJointMotorControlArray(
            body,
            indices,
            p.VELOCITY_CONTROL,
            targetVelocities=velocities,
            forces=efforts,
            physicsClientId=self._client,
        )

    def drive_position(self, body, joint, position, effort, velocity):
        """Set the motor of a joint to a position, with at most `effort` and `velocity`."""
        self._note_batch(body)
        self._motors[body, joint] = "drive_position", (joint, position, effort, velocity)
        p.setJointMotorControl2(
            body,
            self._movable[body][joint],
            p.POSITION_CONTROL,
            targetPosition=position,
            force=effort,
            maxVelocity=velocity,
            positionGain=self.position_gain,
            velocityGain=1.0,
            physicsClientId=self._client,
        )

    def release(self, body, joint):
        """Release a joint to its friction: a velocity motor to 0 with the friction as its effort.

        The motor stays on under drive_effort: an effort has to overcome it, as in a real joint.
        """
        self._note_batch(body)
        self._motors[body, joint] = "release", (joint,)
        index = self._movable[body][joint]
        friction = p.getJointInfo(body, index, physicsClientId=self._client)[7]
        p.setJointMotorControl2(
            body,
            index,
            p.VELOCITY_CONTROL,
            targetVelocity=0.0,
            force=friction,
            physicsClientId=self._client,
        )

    def drive_effort(self, body, joint, effort):
        """Apply an effort [N m, N] to a joint for the next step only."""
        p.setJointMotorControl2(
            body,
            self._movable[body][joint],
            p.TORQUE_CONTROL,
            force=effort,
            physicsClientId=self._client,
        )

    def drive_efforts(self, body, joints, efforts):
        """As drive_effort, of several joints in one call."""
        movable = self._movable[body]
        p.setJointMotorControlArray(
            body,
            [movable[joint] for joint in joints],
            p.TORQUE_CONTROL,
            forces=efforts,
            physicsClientId=self._client,
        )

    def apply_wrench(self, body, link, force, torque):
        """Apply a force (3,) [N] at a link's centre of mass and a torque (3,) [N m], along world
        axes, for the next step only; several add up."""
        if link < 0:
            centre = p.getBasePositionAndOrientation(body, physicsClientId=self._client)[0]
        else:
            centre = p.getLinkState(
                body, link, computeForwardKinematics=1, physicsClientId=self._client
            )[0]
        p.applyExternalForce(
            body, link, tuple(force), centre, p.WORLD_FRAME, physicsClientId=self._client
        )
        p.applyExternalTorque(
            body, link, tuple(torque), p.WORLD_FRAME, physicsClientId=self._client
        )


# PyBullet has one maximum for all joints of a body and cuts their speeds there, 100 by default:
# the limits of single joints are applied to their commands.
MAX_COORDINATE_SPEED = 1e4  # [rad/s, m/s]
_MOVABLE = (p.JOINT_REVOLUTE, p.JOINT_PRISMATIC)
_FLAGS = (
    p.URDF_USE_IMPLICIT_CYLINDER
    | p.URDF_USE_INERTIA_FROM_FILE
    | p.URDF_USE_MATERIAL_COLORS_FROM_MTL
)


class Bodies(Motion, Motors, Saving):
    """The bodies of a world, from URDF files.

    What they look like is loaded only where PyBullet draws them: an engine without a renderer would
    decode the pictures of all meshes for nothing.
    """

    def load(
        self,
        path,
        position=(0, 0, 0),
        orientation=(0, 0, 0, 1),
        fixed_base=False,
        self_collide=False,
        static=False,
    ):
        """Load a prepared URDF file; its root link's frame lands at the given world pose.

        Args:
            path: the file.
            position, orientation: the pose.
            fixed_base: the root link never moves.
            self_collide: links collide with each other, those of one joint excepted.
            static: prepared as static: one link, of which meshes collide as they are.

        Returns:
            The body's number.

        Raises:
            ModelError: PyBullet refuses the file.
        """
        flags = _FLAGS | (p.URDF_USE_SELF_COLLISION if self_collide else 0)
        if self._renderer is None:
            flags |= p.URDF_IGNORE_VISUAL_SHAPES
        try:
            with silenced():
                body = p.loadURDF(
                    path,
                    (0, 0, 0),
                    (0, 0, 0, 1),
                    useFixedBase=fixed_base,
                    flags=flags,
                    physicsClientId=self._client,
                )
        except p.error as error:
            raise ModelError(f"PyBullet cannot load {path}: {error}") from error
        info = p.getDynamicsInfo(body, -1, physicsClientId=self._client)
        self._inertial[body] = (info[3], info[4])
        outward = Pose(info[3], info[4]).inverse()
        self._outward[body] = (outward.position, outward.orientation)
        joints = [
            p.getJointInfo(body, i, physicsClientId=self._client)
            for i in range(p.getNumJoints(body, physicsClientId=self._client))
        ]
        self._movable[body] = [j[0] for j in joints if j[2] in _MOVABLE]
        if not fixed_base:
            self._free.add(body)
        if static:
            self._scenery.add(body)
        self._note_layout("load", body, len(joints))
        self._prepare_dynamics(body, joints)
        self.set_base_pose(body, position, orientation)
        return body

    def _prepare_dynamics(self, body, joints):
        client = self._client
        p.changeDynamics(
            body,
            -1,
            linearDamping=0.0,
            angularDamping=0.0,
            restitution=0.0,
            maxJointVelocity=MAX_COORDINATE_SPEED,
            physicsClientId=client,
        )
        for joint in joints:
            p.changeDynamics(
                body,
                joint[0],
                linearDamping=0.0,
                angularDamping=0.0,
                jointDamping=joint[6],
                restitution=0.0,
                maxJointVelocity=MAX_COORDINATE_SPEED,
                physicsClientId=client,
            )
        for number in range(len(self._movable[body])):
            self.release(body, number)

    def remove(self, body):
        """Remove a body."""
        p.removeBody(body, physicsClientId=self._client)
        del self._movable[body], self._inertial[body], self._outward[body]
        self._free.discard(body)
        self._friction = {key: mu for key, mu in self._friction.items() if key[0] != body}
        self._scaled = {key for key in self._scaled if key[0] != body}
        self._scenery.discard(body)
        self._batches.pop(body, None)
        self._motors = {key: call for key, call in self._motors.items() if key[0] != body}
        self._note_layout("remove", body)

    def joint_names(self, body):
        """Names of the movable joints, in joint order."""
        return [
            p.getJointInfo(body, i, physicsClientId=self._client)[1].decode()
            for i in self._movable[body]
        ]

    def link_indices(self, body):
        """Map of link name -> link index; the root link has -1."""
        names = {p.getBodyInfo(body, physicsClientId=self._client)[0].decode(): -1}
        for i in range(p.getNumJoints(body, physicsClientId=self._client)):
            names[p.getJointInfo(body, i, physicsClientId=self._client)[12].decode()] = i
        return names

    def set_surface(self, body, link, rolling=None, spinning=None, stiffness=None, damping=None):
        """Set the contact properties of one link (index as link_indices gives it)."""
        values = {
            "rollingFriction": rolling,
            "spinningFriction": spinning,
        }
        if stiffness is not None and damping is not None:
            values.update(contactStiffness=stiffness, contactDamping=damping)
        given = {key: value for key, value in values.items() if value is not None}
        if given:
            p.changeDynamics(body, link, physicsClientId=self._client, **given)

    def disable_self_collision(self, body, first, second):
        """Disable collision between two links of a body."""
        p.setCollisionFilterPair(body, body, first, second, 0, physicsClientId=self._client)
        self._note_layout("pair", body, body)

    def set_mass(self, body, link, mass, moments):
        """Change a link's mass [kg] and its moments of inertia (3,) along its principal axes."""
        p.changeDynamics(
            body, link, mass=mass, localInertiaDiagonal=tuple(moments), physicsClientId=self._client
        )

    def principal_axes(self, body, link):
        """Quaternion of the axes that set_mass's moments belong to, in the link frame."""
        return p.getDynamicsInfo(body, link, physicsClientId=self._client)[4]

    def set_joint_limits(self, body, joint, lower, upper):
        """Change the limits [rad, m] of a movable joint that has limits."""
        p.changeDynamics(
            body,
            self._movable[body][joint],
            jointLowerLimit=lower,
            jointUpperLimit=upper,
            physicsClientId=self._client,
        )

    def set_joint_damping(self, body, joint, damping):
        """Change the viscous damping [N m s/rad, N s/m] of a movable joint."""
        p.changeDynamics(
            body, self._movable[body][joint], jointDamping=damping, physicsClientId=self._client
        )


_SATURATED = 0.98  # of the friction limit: from here on a contact counts as sliding
_MAX_FRICTION = 10.0  # to which Bullet cuts the coefficient of a pair
# Bits that a link with a collide_bitmask of its own shares with all that have none, and where its
# own bits begin.
_COMMON, _SHIFT = 3, 8
_STATIC, _GHOST = 2, 64  # Bullet's group of what never moves, our own of ghosts


class Touch(Saving):
    """Contacts between bodies."""

    def set_friction(self, body, link, friction, scale=None):
        """Set the Coulomb coefficient of a link; that of a pair is the product of both.

        Args:
            body, link: as link_indices gives it.
            friction: coefficient along the direction of greatest friction.
            scale: (3,) factors from 0 to 1 along the link's principal axes; None: isotropic.
        """
        values = {"lateralFriction": friction}
        if scale is not None or (body, link) in self._scaled:
            values["anisotropicFriction"] = tuple(scale or (1.0, 1.0, 1.0))
            self._scaled.add((body, link))
        self._friction[body, link] = friction
        p.changeDynamics(body, link, physicsClientId=self._client, **values)

    def friction(self, body, link):
        """The coefficient that set_friction has set."""
        return self._friction[body, link]

    def set_bitmask(self, body, link, bits):
        """Let a link touch only what shares a bit (of 16) with it; the others have all bits."""
        self._scenery.discard(body)  # rays may go through it
        own = bits << _SHIFT
        p.setCollisionFilterGroupMask(
            body, link, own, own | (_COMMON if bits else 0), physicsClientId=self._client
        )
        self._note_layout("mask", body, link)

    def set_ghost(self, body, link):
        """Let a link touch only what never moves; rays go through it."""
        self._scenery.discard(body)
        p.setCollisionFilterGroupMask(body, link, _GHOST, _STATIC, physicsClientId=self._client)
        self._note_layout("mask", body, link)

    def set_pair_collision(self, body, link, other, other_link, collide):
        """Enable or disable collision between two links of different bodies."""
        p.setCollisionFilterPair(
            body, other, link, other_link, int(collide), physicsClientId=self._client
        )
        self._note_layout("pair", body, other)

    def touching(self, body):
        """Pairs in contact as of the last step.

        Returns:
            List of (link, other body, other link, normal force [N]).
        """
        return [
            (point[3], point[2], point[4], point[9])
            for point in p.getContactPoints(bodyA=body, physicsClientId=self._client)
            if point[9] > 0.0
        ]

    def overlaps(self, body, depth):
        """Contacts of a body in which it reaches deeper than `depth` [m] into another, now.

        Returns:
            List of (link, other body, other link, depth [m], normal (3,) towards the body).
        """
        p.performCollisionDetection(physicsClientId=self._client)
        return [
            (point[3], point[2], point[4], -point[8], point[7])
            for point in p.getContactPoints(bodyA=body, physicsClientId=self._client)
            if point[2] != body and point[8] < -depth
        ]

    def pair_depth(self, body, link, other, other_link):
        """How deep [m] two links overlap, also where they pass through each other; 0: not."""
        points = p.getClosestPoints(
            body, other, 0.0, link, other_link, physicsClientId=self._client
        )
        return max((-point[8] for point in points), default=0.0)

    def slip(self, body, links, slowest):
        """Sliding contacts of a body's links, as of the last step.

        Args:
            body: the body.
            links: those that are looked at.
            slowest: [m/s] below which nothing counts as sliding.

        Returns:
            List of (link, point (3,) [m], friction force (3,) [N] on the link, velocity (3,) [m/s]
            of the link's material against the other body's, limit [N]); world axes.
        """
        found = []
        for point in p.getContactPoints(bodyA=body, physicsClientId=self._client):
            link, normal_force = point[3], point[9]
            if normal_force <= 0.0 or link not in links:
                continue
            other = point[2], point[4]
            product = self._friction[body, link] * self._friction.get(other, 1.0)
            limit = min(product, _MAX_FRICTION) * normal_force
            a, b, one, two = point[10], point[12], point[11], point[13]
            force = (a * one[0] + b * two[0], a * one[1] + b * two[1], a * one[2] + b * two[2])
            if math.hypot(*force) < _SATURATED * limit:
                continue
            mine = self._point_velocity(body, link, point[5])
            its = self._point_velocity(*other, point[6]) if self._moves(other[0]) else (0, 0, 0)
            n = point[7]
            velocity = [u - v for u, v in zip(mine, its)]
            along = sum(u * v for u, v in zip(velocity, n))
            velocity = tuple(u - along * v for u, v in zip(velocity, n))
            if math.hypot(*velocity) > slowest:
                found.append((link, point[5], force, velocity, limit))
        return found

    def is_free(self, body):
        """Whether a body's root link is not fixed to the world."""
        return body in self._free

    def _moves(self, body):
        return bool(self._movable.get(body)) or body in self._free

    def _point_velocity(self, body, link, point):
        """Velocity (3,) of the material of a link at a world point."""
        centre, linear, angular, _ = self.link_velocity(body, link)
        return velocity_at(point, centre, linear, angular)

    def apply_force(self, body, link, force, point):
        """Apply a force (3,) [N] to a link at a world point for the next step only."""
        p.applyExternalForce(body, link, force, point, p.WORLD_FRAME, physicsClientId=self._client)


_BODY, _FRACTION = operator.itemgetter(0), operator.itemgetter(2)  # of a ray's hit


class Sensing(Sweep):
    """Questions to the collision shapes."""

    def ray_batch(self, origins, targets, mask=-1):
        """Cast rays between points (N, 3) of the world frame at what has a group of the mask.

        Returns:
            fractions (N,) of the way to the first hit, 1.0 for a miss; bodies (N,), -1: miss.
        """
        hits, limit = [], p.MAX_RAY_INTERSECTION_BATCH_SIZE
        origins, targets = np.asarray(origins), np.asarray(targets)
        for start in range(0, len(origins), limit):
            hits += p.rayTestBatch(
                origins[start : start + limit],
                targets[start : start + limit],
                collisionFilterMask=mask,
                physicsClientId=self._client,
            )
        return (
            np.fromiter(map(_FRACTION, hits), float, len(hits)),
            np.fromiter(map(_BODY, hits), int, len(hits)),
        )

    def contacts(self, body, link):
        """Contact points of one link as of the last step.

        Returns:
            List of sensors.contact.Contact that press or touch, in the engine's order.
        """
        found = []
        for point in p.getContactPoints(bodyA=body, linkIndexA=link, physicsClientId=self._client):
            if point[8] > 0.0 and point[9] <= 0.0:  # near, but without contact
                continue
            normal = np.array(point[7])
            force = (
                point[9] * normal
                + point[10] * np.array(point[11])
                + point[12] * np.array(point[13])
            )
            found.append(Contact(point[2], point[4], np.array(point[5]), normal, -point[8], force))
        return found

    def all_contacts(self):
        """Contact points of all bodies that press, as of the last step.

        Returns:
            (n, 3) places [m], (n, 3) unit normals, (n,) normal forces [N], in the world frame.
        """
        points = [
            (point[5], point[7], point[9])
            for point in p.getContactPoints(physicsClientId=self._client)
            if point[9] > 0.0
        ]
        places, normals, forces = zip(*points) if points else ((), (), ())
        return np.reshape(places, (-1, 3)), np.reshape(normals, (-1, 3)), np.array(forces, float)

    def contact_count(self, body, link):
        """Number of contact points of one link."""
        return len(p.getContactPoints(bodyA=body, linkIndexA=link, physicsClientId=self._client))
