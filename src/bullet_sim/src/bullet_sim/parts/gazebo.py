"""Gazebo's own plugins that act without a command of its transport."""

from __future__ import annotations

import numpy as np

from bullet_sim.parts.base import Part, Preparing, part_of
from bullet_sim.plugins.gazebo import (
    InitialVelocitySpec,
    LiftDragSpec,
    RandomVelocitySpec,
    StandingWheelsSpec,
)
from bullet_sim.pose import Vec3

NANO = 1e-9  # [s] by which times may be off


@part_of(StandingWheelsSpec)
class StandingWheelsPlugin(Preparing):
    """Gives wheels a velocity of 0 before each step."""

    def prepare(self) -> None:
        """From now on (simulation thread)."""
        self.model.joints.impose_velocities(self.spec.joints, [0.0] * len(self.spec.joints))


@part_of(InitialVelocitySpec)
class InitialVelocityPlugin(Preparing):
    """Gives its model a velocity."""

    def prepare(self) -> None:
        """Now (simulation thread)."""
        self.model.set_velocity(self.spec.linear, self.spec.angular)


@part_of(RandomVelocitySpec)
class RandomVelocityPlugin(Part):
    """Gives a link a velocity before each step."""

    STATE = ("_velocity", "_drawn")
    every_step = True

    def start(self, time: float) -> None:
        """As Reset() of Gazebo's, which keeps the velocity and counts periods from time 0."""
        self._velocity: Vec3 = getattr(self, "_velocity", self.spec.first)
        self._drawn = 0.0

    def prepare(self) -> None:
        """Before the first step (simulation thread)."""
        self.update(self.world.time, 0.0)

    def update(self, time: float, period: float) -> None:
        spec, now = self.spec, time + self.world.time_step
        if now - self._drawn > spec.period + NANO:
            drawn = self.rng.uniform(-1.0, 1.0, 3)
            drawn *= spec.speed / (np.linalg.norm(drawn) or 1.0)
            x, y, z = (
                float(min(max(value, low), high))
                for value, (low, high) in zip(drawn, (spec.x, spec.y, spec.z))
            )
            self._velocity, self._drawn = (x, y, z), now
        if not self.model.is_static:
            part, _ = self.model.link_in_body(spec.link)
            self.model.body.set_link_velocity(part, self._velocity)


@part_of(LiftDragSpec)
class LiftDragPlugin(Part):
    """Applies lift and drag to a link in every step.

    As in Gazebo the velocity is that of the center of pressure in the link's frame, and the force
    acts as far from the center of mass as that is from the frame.
    """

    every_step = True
    resets = False

    def update(self, time: float, period: float) -> None:
        spec, model = self.spec, self.model
        if model.is_static:
            return
        pose, linear, angular = model.link_state(spec.link)
        rotation = pose.matrix
        arm = rotation @ np.array(spec.cp)
        angle = model.joints.state()[0].get(spec.joint, 0.0) if spec.joint else 0.0
        force = spec.force(rotation, linear + np.cross(angular, arm), angle)
        if force.any():
            part, _ = model.link_in_body(spec.link)
            model.body.apply_force(part, force, model.body.link_center(part) + arm)
