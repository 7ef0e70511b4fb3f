"""What drives bodies: the motors of joints, forces on links."""

from bullet_sim.engine.client import Client
from bullet_sim.engine.library import p


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
