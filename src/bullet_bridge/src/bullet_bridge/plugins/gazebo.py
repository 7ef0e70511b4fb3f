"""Gazebo's own plugins that act without a command of its transport."""

from __future__ import annotations

from bullet_sim.plugins.gazebo import InitialVelocitySpec, StandingWheelsSpec

from bullet_bridge.plugins.base import Preparing, ros_side


@ros_side(StandingWheelsSpec)
class StandingWheelsPlugin(Preparing):
    """Gives wheels a velocity of 0 before each step."""

    def prepare(self) -> None:
        """From now on (simulation thread)."""
        self.model.joints.impose_velocities(self.spec.joints, [0.0] * len(self.spec.joints))


@ros_side(InitialVelocitySpec)
class InitialVelocityPlugin(Preparing):
    """Gives its model a velocity."""

    def prepare(self) -> None:
        """Now (simulation thread)."""
        self.model.set_velocity(self.spec.linear, self.spec.angular)
