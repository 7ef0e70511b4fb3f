"""The only file that imports pybullet: bodies, joints, rays and pictures as plain arrays.

Poses are those of link frames (not of inertial frames), quaternions are (x, y, z, w).
"""

import importlib.util
import operator

import cv2
import numpy as np

from bullet_sim.errors import ModelError, RenderError
from bullet_sim.sensors.contact import Contact
from bullet_sim.system.quiet import quiet

with quiet():  # it greets on the terminal when it is imported
    import pybullet as p

# PyBullet has one maximum for all joints of a body and cuts their speeds there, 100 by default:
# the limits of single joints are kept by those who command them.
MAX_COORDINATE_SPEED = 1e4  # [rad/s, m/s]
_BODY, _FRACTION = operator.itemgetter(0), operator.itemgetter(2)  # of a ray's hit
_MOVABLE = (p.JOINT_REVOLUTE, p.JOINT_PRISMATIC)
# Below this sum of squared impulses of an iteration the constraint solver stops early. PyBullet's
# 1e-7 lets a braked car of 25 kg roll on by 1.4 mm a minute; this one by 0.5 mm, at the same speed.
SOLVER_RESIDUAL = 1e-8


class Engine:
    """One headless PyBullet client.

    Args:
        time_step: physics step [s].
        gravity: acceleration in the world frame [m/s^2].
        solver_iterations: of the constraint solver per step.
    """

    def __init__(self, time_step=0.001, gravity=(0.0, 0.0, -9.81), solver_iterations=50):
        self.time_step = float(time_step)
        self.gravity = tuple(float(g) for g in gravity)
        self._iterations = int(solver_iterations)
        with quiet():
            self._client = p.connect(p.DIRECT)
        self._renderer = None
        self._plugin = -1
        self._configure()

    def _configure(self):
        self._movable = {}
        self._planes = {}  # (body, link) -> local poses of its planes, () if it has others
        self._inertial, self._outward = {}, {}  # body -> centre in the root's frame, and back
        p.setTimeStep(self.time_step, physicsClientId=self._client)
        p.setGravity(*self.gravity, physicsClientId=self._client)
        p.setPhysicsEngineParameter(
            numSolverIterations=self._iterations,
            deterministicOverlappingPairs=1,
            enableFileCaching=0,
            enableConeFriction=1,
            solverResidualThreshold=SOLVER_RESIDUAL,
            physicsClientId=self._client,
        )

    def close(self):
        """Disconnect; the engine is not usable afterwards."""
        if self._client >= 0:
            p.disconnect(physicsClientId=self._client)
            self._client = -1

    def clear(self):
        """Remove every body and return to the state of a new engine."""
        p.resetSimulation(physicsClientId=self._client)
        self._configure()

    def set_gravity(self, gravity):
        """Set gravity [m/s^2] in the world frame."""
        self.gravity = tuple(float(g) for g in gravity)
        p.setGravity(*self.gravity, physicsClientId=self._client)

    def set_time_step(self, time_step):
        """Set the physics step [s]."""
        self.time_step = float(time_step)
        p.setTimeStep(self.time_step, physicsClientId=self._client)

    # bodies -----------------------------------------------------------------------------------
    def load(
        self,
        path,
        position=(0, 0, 0),
        orientation=(0, 0, 0, 1),
        fixed_base=False,
        self_collide=False,
    ):
        """Load a prepared URDF file; its root link's frame lands at the given world pose.

        Args:
            path: the file.
            position, orientation: the pose.
            fixed_base: the root link never moves.
            self_collide: links collide with each other, those of one joint excepted.

        Returns:
            The body's number.

        Raises:
            ModelError: PyBullet refuses the file.
        """
        flags = (
            p.URDF_USE_IMPLICIT_CYLINDER
            | p.URDF_USE_INERTIA_FROM_FILE
            | p.URDF_USE_MATERIAL_COLORS_FROM_MTL
        )
        if self_collide:
            flags |= p.URDF_USE_SELF_COLLISION
        try:
            with quiet():
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
        self._outward[body] = p.invertTransform(info[3], info[4])
        joints = [
            p.getJointInfo(body, i, physicsClientId=self._client)
            for i in range(p.getNumJoints(body, physicsClientId=self._client))
        ]
        self._movable[body] = [j[0] for j in joints if j[2] in _MOVABLE]
        self._prepare_dynamics(body, joints)
        self.set_base_pose(body, position, orientation)
        return body

    def _prepare_dynamics(self, body, joints):
        client = self._client
        p.changeDynamics(
            body, -1, linearDamping=0.0, angularDamping=0.0, restitution=0.0, physicsClientId=client
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
        self._planes = {key: planes for key, planes in self._planes.items() if key[0] != body}

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

    def set_surface(
        self, body, link, friction=None, rolling=None, spinning=None, stiffness=None, damping=None
    ):
        """Set the contact properties of one link (index as link_indices gives it)."""
        values = {
            "lateralFriction": friction,
            "rollingFriction": rolling,
            "spinningFriction": spinning,
        }
        if stiffness is not None and damping is not None:
            values.update(contactStiffness=stiffness, contactDamping=damping)
        given = {key: value for key, value in values.items() if value is not None}
        if given:
            p.changeDynamics(body, link, physicsClientId=self._client, **given)

    def disable_self_collision(self, body, first, second):
        """Make two links of a body pass through each other."""
        p.setCollisionFilterPair(body, body, first, second, 0, physicsClientId=self._client)

    # state ------------------------------------------------------------------------------------
    def step(self, count=1):
        """Advance by `count` time steps."""
        step, client = p.stepSimulation, self._client
        for _ in range(count):
            step(client)

    def base_pose(self, body):
        """World pose of the root link's frame: position (3,), quaternion (4,) as tuples."""
        position, orientation = p.getBasePositionAndOrientation(body, physicsClientId=self._client)
        return p.multiplyTransforms(position, orientation, *self._outward[body])

    def set_base_pose(self, body, position, orientation):
        """Move the root link's frame to a world pose; joints and velocities stay."""
        pose = p.multiplyTransforms(position, orientation, *self._inertial[body])
        p.resetBasePositionAndOrientation(body, *pose, physicsClientId=self._client)

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

    def link_motion(self, body, link):
        """As link_state, four tuples: several times as fast."""
        if link < 0:
            centre, axes = p.getBasePositionAndOrientation(body, physicsClientId=self._client)
            position, orientation = p.multiplyTransforms(centre, axes, *self._outward[body])
            linear, angular = p.getBaseVelocity(body, physicsClientId=self._client)
        else:
            state = p.getLinkState(
                body,
                link,
                computeLinkVelocity=1,
                computeForwardKinematics=1,
                physicsClientId=self._client,
            )
            centre, position, orientation = state[0], state[4], state[5]
            linear, angular = state[6], state[7]
        (u, v, w), (wx, wy, wz) = linear, angular
        x, y, z = position[0] - centre[0], position[1] - centre[1], position[2] - centre[2]
        return (
            position,
            orientation,
            (u + wy * z - wz * y, v + wz * x - wx * z, w + wx * y - wy * x),
            angular,
        )

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
        """Put the movable joints at positions (n,) [rad, m], at rest."""
        for joint, position in zip(self._movable[body], positions):
            p.resetJointState(body, joint, position, 0.0, physicsClientId=self._client)

    # motors -----------------------------------------------------------------------------------
    def drive_velocity(self, body, joint, velocity, effort):
        """Let the movable joint number `joint` track a velocity with at most `effort`."""
        p.setJointMotorControl2(
            body,
            self._movable[body][joint],
            p.VELOCITY_CONTROL,
            targetVelocity=velocity,
            force=effort,
            physicsClientId=self._client,
        )

    def drive_position(self, body, joint, position, effort, velocity):
        """Let a joint track a position with at most `effort` and `velocity`."""
        p.setJointMotorControl2(
            body,
            self._movable[body][joint],
            p.POSITION_CONTROL,
            targetPosition=position,
            force=effort,
            maxVelocity=velocity,
            positionGain=0.1,
            velocityGain=1.0,
            physicsClientId=self._client,
        )

    def release(self, body, joint):
        """Leave a joint to its friction: a velocity motor to 0 that is no stronger than that.

        The motor stays under drive_effort, so an effort has to overcome it, as in a real joint.
        """
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

    def push(self, body, link, force, torque):
        """Let a force (3,) [N] act at a link's centre of mass and a torque (3,) [N m], both along
        world axes, for the next step only; several add up."""
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

    def put_joint(self, body, joint, position):
        """Put the movable joint number `joint` at a position [rad, m], at rest."""
        p.resetJointState(
            body, self._movable[body][joint], position, 0.0, physicsClientId=self._client
        )

    # properties -------------------------------------------------------------------------------
    def set_mass(self, body, link, mass, moments):
        """Change a link's mass [kg] and its moments of inertia (3,) along its principal axes."""
        p.changeDynamics(
            body, link, mass=mass, localInertiaDiagonal=tuple(moments), physicsClientId=self._client
        )

    def principal_axes(self, body, link):
        """Quaternion of the axes that set_mass's moments belong to, in the link frame."""
        return p.getDynamicsInfo(body, link, physicsClientId=self._client)[4]

    def set_joint_limits(self, body, joint, lower, upper):
        """Change the stops [rad, m] of a movable joint that has stops."""
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

    @property
    def solver_iterations(self):
        """Iterations of the constraint solver per step."""
        return self._iterations

    def set_solver_iterations(self, count):
        """Change the iterations of the constraint solver per step."""
        self._iterations = int(count)
        p.setPhysicsEngineParameter(
            numSolverIterations=self._iterations, physicsClientId=self._client
        )

    # sensing ----------------------------------------------------------------------------------
    def ray_batch(self, origins, targets):
        """Cast rays between points (N, 3) of the world frame.

        Returns:
            fractions (N,) of the way to the first hit, 1.0 for a miss; bodies (N,), -1: miss.
        """
        hits, limit = [], p.MAX_RAY_INTERSECTION_BATCH_SIZE
        origins, targets = np.asarray(origins), np.asarray(targets)
        for start in range(0, len(origins), limit):
            hits += p.rayTestBatch(
                origins[start : start + limit],
                targets[start : start + limit],
                physicsClientId=self._client,
            )
        return (
            np.fromiter(map(_FRACTION, hits), float, len(hits)),
            np.fromiter(map(_BODY, hits), int, len(hits)),
        )

    def bodies_in_box(self, low, high):
        """Numbers of the bodies that may reach into a box of the world, given by two corners (3,).

        Their bounding boxes do; a plane, whose box has no end, counts by what is below it.
        """
        touching = (
            p.getOverlappingObjects(tuple(low), tuple(high), physicsClientId=self._client) or ()
        )
        return {body for body, link in touching if self._reaches(body, link, low, high)}

    def _reaches(self, body, link, low, high):
        """Whether a box goes below a link that is nothing but planes; True for any other."""
        key = (body, link)
        if key not in self._planes:
            shapes = p.getCollisionShapeData(body, link, physicsClientId=self._client)
            self._planes[key] = (
                [shape[5:7] for shape in shapes]
                if shapes and all(shape[2] == p.GEOM_PLANE for shape in shapes)
                else ()
            )
        planes = self._planes[key]
        if not planes or link >= 0:
            return True
        frame = p.getBasePositionAndOrientation(body, physicsClientId=self._client)
        for local in planes:
            position, orientation = p.multiplyTransforms(*frame, *local)
            normal = p.getMatrixFromQuaternion(orientation)[2::3]
            # the corner that is deepest below the plane
            corner = [a if n > 0 else b for n, a, b in zip(normal, low, high)]
            if sum(n * (x - y) for n, x, y in zip(normal, corner, position)) <= 0.0:
                return True
        return False

    def contacts(self, body, link):
        """Contact points of one link as of the last step.

        Returns:
            List of sensors.contact.Contact that press or touch, in the engine's order.
        """
        found = []
        for point in p.getContactPoints(bodyA=body, linkIndexA=link, physicsClientId=self._client):
            if point[8] > 0.0 and point[9] <= 0.0:  # near, but not there yet
                continue
            normal = np.array(point[7])
            force = (
                point[9] * normal
                + point[10] * np.array(point[11])
                + point[12] * np.array(point[13])
            )
            found.append(Contact(point[2], point[4], np.array(point[5]), normal, -point[8], force))
        return found

    def link_centre(self, body, link):
        """Centre of mass (3,) [m] of a link in the world."""
        if link < 0:
            return np.array(p.getBasePositionAndOrientation(body, physicsClientId=self._client)[0])
        return np.array(
            p.getLinkState(body, link, computeForwardKinematics=1, physicsClientId=self._client)[0]
        )

    def contact_count(self, body, link):
        """Number of contact points of one link."""
        return len(p.getContactPoints(bodyA=body, linkIndexA=link, physicsClientId=self._client))

    # pictures ---------------------------------------------------------------------------------
    def start_renderer(self, kind="auto"):
        """Choose the renderer: 'egl' (GPU or Mesa), 'tiny' (in PyBullet), 'auto': EGL if it works.

        Returns:
            'egl' or 'tiny'.

        Raises:
            RenderError: unknown kind, or EGL was asked for and does not work.
        """
        if kind not in ("auto", "egl", "tiny"):
            raise RenderError(f"renderer is '{kind}', must be auto, egl or tiny")
        if kind != "tiny" and self._plugin < 0:
            found = importlib.util.find_spec("eglRenderer")
            if found:
                with quiet():
                    self._plugin = p.loadPlugin(
                        found.origin, "_eglRendererPlugin", physicsClientId=self._client
                    )
            if self._plugin < 0 and kind == "egl":
                raise RenderError("the EGL renderer does not load: is libegl1 installed?")
        self._renderer = "egl" if kind != "tiny" and self._plugin >= 0 else "tiny"
        return self._renderer

    def render(self, width, height, view, projection, shadow=False):
        """Take a picture.

        Args:
            view, projection: column-major 4x4 matrices, 16 numbers each.

        Returns:
            (H, W, 3) uint8 RGB.
        """
        rgb, _ = self.render_with_depth(width, height, view, projection, shadow)
        return rgb

    def render_with_depth(self, width, height, view, projection, shadow=False, out=None):
        """As render, with the depth buffer (H, W) float32 in 0..1 (1 = nothing there).

        Args:
            out: (H, W, 3) uint8 array that takes the colours; None: a new one.
        """
        kind = p.ER_TINY_RENDERER if self._renderer != "egl" else p.ER_BULLET_HARDWARE_OPENGL
        picture = p.getCameraImage(
            width,
            height,
            viewMatrix=view,
            projectionMatrix=projection,
            shadow=int(shadow),
            lightDirection=(0.5, 0.4, 1.0),
            renderer=kind,
            flags=p.ER_NO_SEGMENTATION_MASK,
            physicsClientId=self._client,
        )
        rgba = np.asarray(picture[2], dtype=np.uint8).reshape(height, width, 4)
        depth = np.asarray(picture[3], dtype=np.float32).reshape(height, width)
        return cv2.cvtColor(rgba, cv2.COLOR_RGBA2RGB, dst=out), depth  # 30 times as fast as slicing
