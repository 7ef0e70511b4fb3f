"""What drives bodies: the motors of joints, forces on links."""

from bullet_sim.engine.client import Client
from bullet_sim.engine.library import p


class Motors(Client):
    """Motors keep their command from step to step, forces and efforts last one step."""

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
