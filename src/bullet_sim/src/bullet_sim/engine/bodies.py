"""Bodies: loading, removing, their links, and the properties that can be changed."""

from bullet_sim.engine.library import p
from bullet_sim.engine.motion import Motion
from bullet_sim.engine.motors import Motors
from bullet_sim.engine.saving import Saving
from bullet_sim.errors import ModelError
from bullet_sim.pose import Pose
from bullet_sim.system.output import silenced

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
