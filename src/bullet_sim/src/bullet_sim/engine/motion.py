"""Poses and velocities of links, positions of joints: read and set."""

import numpy as np

from bullet_sim.engine.client import Client, velocity_at
from bullet_sim.engine.library import p
from bullet_sim.pose import compose


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
