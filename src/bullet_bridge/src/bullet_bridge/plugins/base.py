"""What a model publishes through the simulator: the base of its sensors and plugins."""

import numpy as np
from bullet_sim.component import Component
from bullet_sim.pose import Pose, cross

from bullet_bridge.loop.clock import SubscribedSchedule
from bullet_bridge.transport.publishing import publisher


class Output(Component):
    """One sensor of one model.

    Args:
        world, model: of the core.
        spec: the sensor's specification.
        seed: of its noise.
    """

    STATE = ("schedule", "rng")
    message = None
    relayed = True  # see publishing.publisher
    reports = True  # it publishes periodically, so that its rate can be measured
    every_step = False  # update() is called after every step, not at the rate of the spec

    def __init__(self, world, model, spec, seed):
        self.world, self.model, self.spec, self.seed = world, model, spec, seed
        fastest = 1.0 / world.time_step  # as in Gazebo: at most one message per step
        rate = fastest if self.every_step else min(spec.rate or fastest, fastest)
        self.schedule = SubscribedSchedule(
            rate, world.time_step, world.step_count, self.has_subscribers
        )
        self.publisher = publisher(spec.topic, self.message, relayed=self.relayed)
        offset = Pose.from_xyz_rpy(*getattr(spec, "pose", ((0, 0, 0), (0, 0, 0))))
        self._offset = None if offset == Pose() else offset
        self.restart()

    def restart(self):
        """Restart schedule and noise after a reset."""
        self.schedule.restart(self.world.step_count)
        self.rng = np.random.default_rng(self.seed)

    def attach(self, arrivals):
        """Subscribe to the output's input topics, if any, through Arrivals."""

    def has_subscribers(self):
        """Whether the output has subscribers."""
        return self.publisher.get_num_connections() > 0

    def update(self, time):
        """Read the sensor and publish it for simulated time [s]."""
        raise NotImplementedError

    def close(self):
        """Unregister the topic."""
        self.publisher.unregister()

    def sensor_state(self):
        """Pose of the sensor frame in the world, velocity of its origin, world axes."""
        pose, linear, angular = self.model.link_state(self.spec.link)
        if self._offset is None:
            return pose, linear, angular
        arm = pose.matrix @ np.asarray(self._offset.position)
        return pose * self._offset, linear + cross(angular, arm), angular


class DifferenceOutput(Output):
    """Compares a state with that of its last message, which it forgets without subscribers."""

    STATE = ("_before",)

    def restart(self):
        super().restart()
        self._before = None

    def has_subscribers(self):
        subscribed = super().has_subscribers()
        if not subscribed:
            self._before = None
        return subscribed
