"""What models do and measure in ROS: the base of all plugins and sensors, also of users'."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, TypeVar

import numpy as np
import rospy
from bullet_sim.component import Component
from bullet_sim.pose import Array, Pose, Quat, Vec3, compose, cross, velocity_at
from rospy.impl.registration import get_topic_manager

from bullet_bridge.loop.clock import SubscribedSchedule, whole_rate
from bullet_bridge.loop.received import Counted
from bullet_bridge.transport.publishing import all_or_none, check_type, note_endpoint, publisher
from bullet_bridge.transport.reconfigure import ValuesServer

if TYPE_CHECKING:
    from bullet_sim.models.model import Model
    from bullet_sim.world import World

P = TypeVar("P", bound="ModelPlugin")
T = TypeVar("T")

# Class of a specification -> the ModelPlugin that does it, and its subclasses.
ROS_SIDE: dict[type, type[ModelPlugin]] = {}


def ros_side(*specs: type) -> Callable[[type[P]], type[P]]:
    """Decorator that enters a ModelPlugin for classes of specifications."""

    def enter(plugin: type[P]) -> type[P]:
        ROS_SIDE.update(dict.fromkeys(specs, plugin))
        return plugin

    return enter


@dataclass(frozen=True)
class PluginContext:
    """What a plugin gets when its model is connected.

    Attributes:
        spec: its entry in the model's file.
        seed: of its noise.
        number: of the entry in the model's file, from 0.
        received: ReceivedCounts of the messages that it receives.
        cameras: Cameras, which have images rendered.
        jobs: JobQueue of the simulation thread.
    """

    world: World
    model: Model
    spec: Any
    seed: int = 0
    received: Any = None
    cameras: Any = None
    jobs: Any = None
    number: int = 0


def make_plugin(
    context: PluginContext, plugin_class: type[ModelPlugin] | None = None
) -> ModelPlugin:
    """The ModelPlugin of a specification, as after a reset; it leaves no topic if it fails.

    Args:
        plugin_class: None: that of the specification's class, or of its closest base.
    """
    if plugin_class is None:
        bases = type(context.spec).__mro__
        plugin_class = next(ROS_SIDE[base] for base in bases if base in ROS_SIDE)
    with all_or_none():
        plugin = plugin_class(context)
        plugin.reset(context.world.time)
        plugin.listen()
    return plugin


def has_subscribers(publisher: Any) -> bool:
    """Whether a publisher, or None, has subscribers."""
    return publisher is not None and publisher.get_num_connections() > 0


class RosPart:
    """Has topics, which are closed with it.

    Args:
        received: ReceivedCounts of the messages that it receives.
    """

    def __init__(self, received: Any) -> None:
        self._received = received
        self._publishers: list[Any] = []
        self._endpoints: list[Any] = []

    def publisher(self, topic: str, message: type, **options: Any) -> rospy.Publisher:
        """A publisher; options: see transport.publishing.publisher."""
        endpoint = publisher(topic, message, **options)
        self._publishers.append(endpoint)
        self._endpoints.append(endpoint)
        return endpoint

    def subscribe(
        self, topic: str, message: type, callback: Callable[[Any], None], **options: Any
    ) -> Any:
        """Subscribe to a topic; `callback` gets each message; options: of rospy.Subscriber."""
        check_type(topic, message, get_topic_manager().get_subscriber_impl)
        endpoint = self._received.subscribe(topic, message, callback, **options)
        note_endpoint(endpoint)
        self._endpoints.append(endpoint)
        return endpoint

    def topics_received(self) -> set[str]:
        """Resolved names of the topics that it subscribes to."""
        return {endpoint.topic for endpoint in self._endpoints if isinstance(endpoint, Counted)}

    def service(self, name: str, service: type, handler: Callable[[Any], Any]) -> None:
        """Offer a service; one whose name is taken is skipped with a warning, as in Gazebo.

        Args:
            handler: function of a request; runs in a thread of its own, see ModelPlugin.call.
        """
        self._offer(name, lambda: _ServiceEndpoint(rospy.Service(name, service, handler)))

    def reconfigure(
        self,
        namespace: str,
        config: Any,
        values: dict[str, Any],
        callback: Callable[[Any, int], Any],
    ) -> None:
        """Offer parameters by dynamic_reconfigure, skipped as a service is.

        Args:
            config: module that dynamic_reconfigure's generator would make.
            values: name -> first value.
            callback: as of dynamic_reconfigure's Server; runs in a thread of its own.
        """
        self._offer(namespace, lambda: ValuesServer(config, values, callback, namespace))

    def transforms(self) -> Any:
        """Buffer of the transforms on /tf."""
        import tf2_ros  # takes a while, and few models need it

        buffer = tf2_ros.Buffer()
        self._endpoints.append(tf2_ros.TransformListener(buffer))
        return buffer

    def _offer(self, name: str, make: Callable[[], Any]) -> None:
        try:
            endpoint = make()
        except rospy.ServiceException as error:
            rospy.logwarn("%s is not offered a second time: %s", name, error)
            return
        note_endpoint(endpoint)
        self._endpoints.append(endpoint)

    def close(self) -> None:
        """Unregister the topics and services."""
        for endpoint in self._endpoints:
            endpoint.unregister()


class _ServiceEndpoint:
    """A rospy.Service that is closed like a publisher."""

    def __init__(self, service: Any) -> None:
        self._service = service

    def unregister(self) -> None:
        self._service.shutdown("its model is deleted")


class ModelPlugin(RosPart, Component):
    """Acts on its model, has topics. It runs whether or not there are subscribers.

    Attributes:
        COMMANDS: field of the specification with the name of a topic that it subscribes to ->
            message, name of the method that gets each one. It subscribes after the first reset,
            which would drop them, and to no topic without a name.
        schedule: of its updates.
        rng: generator of its noise, seeded.
        updated: time of the last update, or of the reset [s].
        every_step: update() is called after every physics step, not at the rate of the spec.
        whole_periods: each period counts from the step of the update before, as upstream.
        always: it is updated without subscribers, too.
        resets: /gazebo/reset_world resets it, as upstream's Reset() does; as an attribute of the
            specification it counts instead.
        waits_for_time: after simulated time went back it is silent until its time of before has
            passed again, as its original, which does not notice.
        reports: it publishes periodically, so that its rate can be measured.
        takes_images: it is a camera.
    """

    STATE: ClassVar[tuple[str, ...]] = ("schedule", "rng", "updated", "_asked")
    CACHE: ClassVar[tuple[str, ...]] = ("_endpoints",)
    COMMANDS: ClassVar[Mapping[str, tuple[type, str]]] = {}
    every_step: ClassVar[bool] = False
    whole_periods: ClassVar[bool] = False
    always: ClassVar[bool] = True
    reports: ClassVar[bool] = False
    takes_images: ClassVar[bool] = False
    resets: ClassVar[bool] = True
    waits_for_time: ClassVar[bool] = False

    def __init__(self, context: PluginContext) -> None:
        super().__init__(context.received)
        self.context, self.updated = context, 0.0
        self.world, self.model, self.spec = context.world, context.model, context.spec
        self.rng = np.random.default_rng(context.seed)
        self._asked: float = getattr(self.spec, "rate", 0.0)  # [Hz], 0: every step
        self.schedule = SubscribedSchedule(
            self._rate(),
            self.world.time_step,
            self.world.step_count,
            self.needs_update,
            lambda: self.start(self.world.time),
        )
        offset = Pose.from_xyz_rpy(*getattr(self.spec, "pose", ((0, 0, 0), (0, 0, 0))))
        self._offset = None if offset == Pose() else offset
        self.configure(getattr(self.spec, "xml", None))

    def _rate(self) -> float:
        """Of updates [Hz]; at most one a physics step, as in Gazebo."""
        fastest = 1.0 / self.world.time_step
        if self.every_step or self._asked <= 0.0:
            return fastest
        rate = min(self._asked, fastest)
        return whole_rate(rate, self.world.time_step) if self.whole_periods else rate

    @property
    def nominal_rate(self) -> float:
        """Of what it publishes [Hz] of simulated time."""
        return getattr(self.spec, "rate", 0.0) or 1.0 / self.world.time_step

    def on_time_step(self) -> None:
        """Continue after a change of the physics step, or of the rate (simulation thread)."""
        self.schedule.set_step(self.world.time_step, self._rate(), self.world.step_count)

    def configure(self, sdf: Any) -> None:
        """Read the plugin's element and make its topics; for users' classes.

        Args:
            sdf: PluginXml; None for specifications that the simulator reads itself.

        Raises:
            SimError: names the error and what would be valid; the plugin is skipped.
        """

    def listen(self) -> None:
        """Subscribe to commands, once."""
        for field, (message, method) in self.COMMANDS.items():
            if topic := getattr(self.spec, field):
                self.subscribe(topic, message, getattr(self, method))

    def message_type(self) -> str:
        """Type of what it publishes first, e.g. 'sensor_msgs/Imu'; '' if it publishes nothing."""
        return self._publishers[0].type if self._publishers else ""

    def call(self, work: Callable[[], T]) -> T:
        """Result of a function that the simulation thread runs, for services and callbacks."""
        return self.context.jobs.call(work)

    def set_rate(self, rate: float) -> None:
        """Change the rate of the updates [Hz]; 0: every physics step (simulation thread)."""
        self._asked = rate
        self.on_time_step()

    def needs_update(self) -> bool:
        """Whether it is to be updated: always, or while a topic of it has subscribers."""
        return self.always or any(map(has_subscribers, self._publishers))

    def prepare(self) -> None:
        """Prepare the model, once it is there and after each reset (simulation thread)."""

    def reset(self, time: float) -> None:
        """Restart as configured: schedule, noise, start()."""
        self.restart(time)

    def restart(self, time: float) -> None:
        """Restart schedule, noise and measurements after time went back; commands stay."""
        self.schedule.restart(self.world.step_count)
        self.rng, self.updated = np.random.default_rng(self.context.seed), time
        self.start(time)

    def go_back(self, time: float) -> None:
        """As restart(), unless it waits for its time: see waits_for_time."""
        if not self.waits_for_time:
            self.restart(time)

    @property
    def resets_with_model(self) -> bool:
        """Whether a reset of its model alone resets it."""
        return getattr(self.spec, "resets", self.resets)

    def sensor_state(self) -> tuple[Pose, Array, Array]:
        """Pose of the sensor frame in the world, velocity of its origin, world axes."""
        pose, linear, angular = self.model.link_state(self.spec.link)
        if self._offset is None:
            return pose, linear, angular
        arm = pose.matrix @ np.asarray(self._offset.position)
        return pose * self._offset, linear + cross(angular, arm), angular

    def sensor_motion(self) -> tuple[Vec3, Quat, Vec3, Vec3]:
        """As sensor_state, in tuples: position, quaternion, linear and angular velocity."""
        motion = self.model.link_motion(self.spec.link)
        offset = self._offset
        if offset is None:
            return motion
        origin, rotation, linear, angular = motion
        position, orientation = compose(origin, rotation, offset.position, offset.orientation)
        return position, orientation, velocity_at(position, origin, linear, angular), angular

    def is_message(self, step: int) -> bool:
        """Whether the update of a step publishes; others count as no message."""
        return True

    def pose(self) -> Pose:
        """Pose of the sensor frame in the world."""
        return self.sensor_state()[0]


class Preparing(ModelPlugin):
    """Acts when its model is there and after each reset alone."""

    always = False

    def needs_update(self) -> bool:
        """Never."""
        return False

    def update(self, time: float, period: float) -> None:
        """Nothing."""


class Sensor(ModelPlugin):
    """Publishes what it measures while it has subscribers.

    Attributes:
        relayed: see transport.publishing.publisher.
        pub: publisher on the topic of the specification.
    """

    message: Any = None
    relayed: ClassVar[bool] = True
    always = False
    reports = True
    resets = False

    def __init__(self, context: PluginContext) -> None:
        super().__init__(context)
        self.pub = self.publisher(self.spec.topic, self.message, relayed=self.relayed)

    def go_back(self, time: float) -> None:
        """As of a ModelPlugin; one that measures in every step does not wait."""
        if self._asked > 0.0:
            super().go_back(time)
        else:
            self.restart(time)

    def measure(self, time: float) -> Any:
        """A message for simulated time [s], or None."""
        raise NotImplementedError

    def update(self, time: float, period: float) -> None:
        message = self.measure(time)
        if message is not None:
            self.pub.publish(message)
