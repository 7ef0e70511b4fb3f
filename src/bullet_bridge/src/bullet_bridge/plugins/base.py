"""What models do and measure in ROS: the base of all plugins and sensors, also of users' own."""

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from bullet_sim.component import Component
from bullet_sim.pose import Pose, cross

from bullet_bridge.loop.clock import SubscribedSchedule
from bullet_bridge.transport.publishing import all_or_none, note_endpoint, publisher

ROS_SIDE = {}  # class of a specification -> the ModelPlugin that does it, and its subclasses


def ros_side(*specs):
    """Decorator that enters a ModelPlugin for classes of specifications."""

    def enter(kind):
        ROS_SIDE.update(dict.fromkeys(specs, kind))
        return kind

    return enter


@dataclass(frozen=True)
class PluginContext:
    """What a plugin gets when its model is connected.

    Attributes:
        world, model: of the core.
        spec: what the model's file says about it.
        seed: of its noise.
        arrivals: Arrivals, which count the messages that it receives.
        cameras: Cameras, which have images rendered.
    """

    world: Any
    model: Any
    spec: Any
    seed: int = 0
    arrivals: Any = None
    cameras: Any = None


def make_plugin(context, kind=None):
    """The ModelPlugin of a specification, as after a reset; it leaves no topic if it fails.

    Args:
        context: PluginContext.
        kind: its class; None: that of the specification's class, or of its nearest base.
    """
    kind = kind or next(ROS_SIDE[spec] for spec in type(context.spec).__mro__ if spec in ROS_SIDE)
    with all_or_none():
        plugin = kind(context)
        plugin.reset(context.world.time)
    return plugin


class ModelPlugin(Component):
    """Acts on its model, has topics. It runs whether or not there are subscribers.

    Args:
        context: PluginContext.

    Attributes:
        context, world, model, spec: as above.
        schedule: of its updates.
        rng: generator of its noise, seeded.
        updated: time of the last update, or of the reset [s].
        every_step: update() is called after every physics step, not at the rate of the spec.
        always: it is updated without subscribers, too.
        reports: it publishes periodically, so that its rate can be measured.
    """

    STATE = ("schedule", "rng", "updated")
    CACHE = ("_endpoints", "_publishers")
    every_step: ClassVar[bool] = False
    always: ClassVar[bool] = True
    reports: ClassVar[bool] = False

    def __init__(self, context):
        self.context, self.updated = context, 0.0
        self.world, self.model, self.spec = context.world, context.model, context.spec
        self._publishers, self._endpoints = [], []
        self.rng = np.random.default_rng(context.seed)
        fastest = 1.0 / self.world.time_step  # as in Gazebo: at most one message per step
        rate = fastest if self.every_step else min(self.spec.rate or fastest, fastest)
        self.schedule = SubscribedSchedule(
            rate,
            self.world.time_step,
            self.world.step_count,
            self.is_wanted,
            lambda: self.start(self.world.time),
        )
        offset = Pose.from_xyz_rpy(*getattr(self.spec, "pose", ((0, 0, 0), (0, 0, 0))))
        self._offset = None if offset == Pose() else offset
        self.configure(getattr(self.spec, "xml", None))

    def configure(self, sdf):
        """Read the plugin's element and make its topics; for classes of users' own.

        Args:
            sdf: PluginXml; None for specifications that the simulator reads itself.

        Raises:
            SimError: names what is wrong and what would be valid; the plugin is left out.
        """

    def publisher(self, topic, message, **options):
        """A publisher, which is closed with the plugin.

        Args:
            topic: its full name.
            message: class of the messages.
            options: see transport.publishing.publisher.
        """
        made = publisher(topic, message, **options)
        self._publishers.append(made)
        self._endpoints.append(made)
        return made

    def subscribe(self, topic, message, callback):
        """Subscribe to a topic until the plugin is closed; `callback` gets each message."""
        made = self.context.arrivals.subscribe(topic, message, callback)
        note_endpoint(made)
        self._endpoints.append(made)
        return made

    def message_type(self):
        """Type of what it publishes first, e.g. 'sensor_msgs/Imu'; '' if it publishes nothing."""
        return self._publishers[0].type if self._publishers else ""

    def is_wanted(self):
        """Whether it is to be updated: always, or while a topic of it has subscribers."""
        return self.always or any(made.get_num_connections() > 0 for made in self._publishers)

    def reset(self, time):
        """Begin as configured: schedule, noise, start()."""
        self.schedule.restart(self.world.step_count)
        self.rng, self.updated = np.random.default_rng(self.context.seed), time
        self.start(time)

    def sensor_state(self):
        """Pose of the sensor frame in the world, velocity of its origin, world axes."""
        pose, linear, angular = self.model.link_state(self.spec.link)
        if self._offset is None:
            return pose, linear, angular
        arm = pose.matrix @ np.asarray(self._offset.position)
        return pose * self._offset, linear + cross(angular, arm), angular

    def pose(self):
        """Pose of the sensor frame in the world."""
        return self.sensor_state()[0]

    def close(self):
        """Unregister the topics."""
        for endpoint in self._endpoints:
            endpoint.unregister()


class Sensor(ModelPlugin):
    """Publishes what it measures while it has subscribers.

    Attributes:
        message: class of its messages.
        relayed: see transport.publishing.publisher.
        pub: publisher on the topic of the specification.
    """

    message: ClassVar[Any] = None
    relayed: ClassVar[bool] = True
    always = False
    reports = True

    def __init__(self, context):
        super().__init__(context)
        self.pub = self.publisher(self.spec.topic, self.message, relayed=self.relayed)

    def measure(self, time):
        """A message for simulated time [s], or None."""
        raise NotImplementedError

    def update(self, time, period):
        """Publish a measurement."""
        message = self.measure(time)
        if message is not None:
            self.pub.publish(message)
