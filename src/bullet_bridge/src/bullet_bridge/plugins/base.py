"""What models do and measure in ROS: the base of all plugins and sensors, also of users'."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from logging import ERROR, INFO, WARNING
from typing import Any, ClassVar, TypeVar

import roslib.message
import rospy
from bullet_sim.errors import SimError
from bullet_sim.parts import base as parts
from bullet_sim.parts.outputs import Output
from bullet_sim.pose import Pose
from bullet_sim.registry import ByClass
from paddock_common.reconfigure import describe
from rospy.impl.registration import get_topic_manager

from bullet_bridge.loop.received import Counted
from bullet_bridge.transport.publishing import all_or_none, check_type, note_endpoint, publisher
from bullet_bridge.transport.reconfigure import ValuesServer
from bullet_bridge.transport.senders import message_class, sender

T = TypeVar("T")

ROS_SIDE: ByClass[type[ModelPlugin]] = ByClass()  # of classes of specifications
ros_side = ROS_SIDE.enter


@dataclass(frozen=True)
class PluginContext(parts.PartContext):
    """What a plugin gets in ROS when its model is connected.

    Attributes:
        received: ReceivedCounts of the messages that it receives.
        jobs: JobQueue of the simulation thread.
    """

    received: Any = None
    jobs: Any = None


def make_plugin(
    context: PluginContext, plugin_class: type[ModelPlugin] | None = None
) -> ModelPlugin:
    """The ModelPlugin of a specification, as after a reset; it leaves no topic if it fails.

    Args:
        plugin_class: None: that of the specification's class, or of its closest base.
    """
    with all_or_none():
        plugin = (plugin_class or ROS_SIDE.of(context.spec))(context)
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

    def topics_sent(self) -> set[str]:
        """Resolved names of the topics that it publishes on."""
        return {publisher.name for publisher in self._publishers}

    def topics_received(self) -> set[str]:
        """Resolved names of the topics that it subscribes to."""
        return {endpoint.topic for endpoint in self._endpoints if isinstance(endpoint, Counted)}

    def service(self, name: str, service: Any, handler: Callable[[Any], Any]) -> None:
        """Offer a service; one whose name is taken is skipped with a warning, as in Gazebo.

        Args:
            service: its type, or the name of it.
            handler: see Part.service.
        """
        kind = roslib.message.get_service_class(service) if isinstance(service, str) else service

        def handle(request: Any) -> Any:
            try:
                response = handler(request)
            except SimError as error:
                raise rospy.ServiceException(str(error)) from None
            fields = {} if response is None else response
            return kind._response_class(**fields) if isinstance(fields, dict) else fields

        def make() -> Any:
            made: Any = rospy.Service(name, kind, handle)
            made.unregister = lambda: made.shutdown("its model is deleted")  # as a publisher
            return made

        self._offer(name, make)

    def reconfigure(
        self,
        namespace: str,
        config: Any,
        values: dict[str, Any],
        callback: Callable[[Any, int], Any],
    ) -> None:
        """Offer parameters by dynamic_reconfigure, skipped as a service is.

        Args:
            config: see Part.reconfigure; or a module that dynamic_reconfigure's generator makes.
            values: name -> first value.
            callback: as of dynamic_reconfigure's Server; runs in a thread of its own.
        """
        config = describe(config) if isinstance(config, tuple) else config
        self._offer(namespace, lambda: ValuesServer(config, values, callback, namespace))

    def transforms(self) -> Transforms:
        """What finds transforms on /tf, from now on."""
        found = Transforms()
        self._endpoints.append(found)
        return found

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


class Transforms:
    """The transforms on /tf."""

    def __init__(self) -> None:
        import tf2_ros  # takes a while, and few models need it

        self._buffer, self._error = tf2_ros.Buffer(), tf2_ros.TransformException
        self.unregister = tf2_ros.TransformListener(self._buffer).unregister

    def pose_in(self, frame: str, child: str) -> Pose:
        """The latest pose of a frame in another; raises a LookupError where there is none."""
        try:
            found = self._buffer.lookup_transform(frame, child, rospy.Time(0)).transform
        except self._error as error:
            raise LookupError(str(error)) from error
        p, q = found.translation, found.rotation
        return Pose((p.x, p.y, p.z), (q.x, q.y, q.z, q.w))


class Unsent:
    """In place of what sends on a topic that is left out."""

    def has_subscribers(self) -> bool:
        """It has none."""
        return False

    def send(self, _time: float, *_values: Any, **_options: Any) -> None:
        """Send nothing."""


class ModelPlugin(RosPart, parts.Part):
    """A Part with topics in ROS."""

    CACHE: ClassVar[tuple[str, ...]] = ("_endpoints", "_lacking")

    def __init__(self, context: PluginContext) -> None:
        RosPart.__init__(self, context.received)
        self._lacking: dict[str, list[str]] = {}  # package of messages -> topics left out
        super(RosPart, self).__init__(context)  # of the Part that it is
        self.offer()
        self.configure(getattr(self.spec, "xml", None))

    def configure(self, sdf: Any) -> None:
        """Read the plugin's element and make its topics; for users' classes.

        Args:
            sdf: PluginXml; None for specifications that the simulator reads itself.

        Raises:
            SimError: names the error and what would be valid; the plugin is skipped.
        """

    def output(self, output: Output) -> Any:
        """What sends on a topic of ROS, see Sender; nothing, where its message's package lacks."""
        kind = getattr(output, "message", output.MESSAGE)
        return Unsent() if self._lacks(output.topic, kind) else sender(self, output)

    def _lacks(self, topic: str, message: Any) -> bool:
        """Whether there is no type of messages, so that a topic is left out."""
        lacks = message_class(message) is None
        if lacks:
            self._lacking.setdefault(message.partition("/")[0], []).append(topic)
        return lacks

    def log(self, level: int, text: str) -> None:
        {INFO: rospy.loginfo, WARNING: rospy.logwarn, ERROR: rospy.logerr}[level]("%s", text)

    def listen(self) -> None:
        """Subscribe to commands, once; tell which topics were left out."""
        for topic, (message, callback) in self.commands().items():
            if not self._lacks(topic, message):
                self.subscribe(topic, message_class(message), callback)
        for package, topics in self._lacking.items():
            self.log_warning(
                f"plugin '{self.spec.name}' of '{self.model.name}' leaves out "
                f"{', '.join(topics)}: there is no package {package} with their messages; "
                f"'./run add {package}' brings it"
            )

    def message_type(self) -> str:
        """Type of what it publishes first, e.g. 'sensor_msgs/Imu'; '' if it publishes nothing."""
        return self._publishers[0].type if self._publishers else ""

    def call(self, work: Callable[[], T]) -> T:
        """Result of a function that the simulation thread runs, for services and callbacks."""
        return self.context.jobs.call(work)

    def is_subscribed(self) -> bool:
        """Whether a topic of it has subscribers."""
        return any(map(has_subscribers, self._publishers))

    def close(self) -> None:
        """End what the part has, and unregister the topics and services."""
        super(RosPart, self).close()
        RosPart.close(self)


class Preparing(ModelPlugin, parts.Preparing):
    """Acts when its model is there and after each reset alone."""


class Sensor(ModelPlugin, parts.Sensor):
    """Publishes what it measures while it has subscribers; the base of users' sensors.

    Attributes:
        message: class of its messages.
        relayed: see transport.publishing.publisher.
        pub: publisher on the topic of the specification.
    """

    message: Any = None
    relayed: ClassVar[bool] = True

    def __init__(self, context: PluginContext) -> None:
        super().__init__(context)
        self.pub = self.publisher(self.spec.topic, self.message, relayed=self.relayed)

    def make_output(self) -> None:
        """Its messages are made by measure(): one for a simulated time [s], or None."""

    def update(self, time: float, period: float) -> None:
        message = self.measure(time)
        if message is not None:
            self.pub.publish(message)


def enter_parts() -> None:
    """Enter each of the core's parts that nothing is added to in ROS."""
    for spec, part in parts.PARTS.items():
        if spec not in ROS_SIDE:
            facts = {"__module__": __name__, "__doc__": part.__doc__}
            ROS_SIDE[spec] = type(part.__name__, (ModelPlugin, part), facts)
