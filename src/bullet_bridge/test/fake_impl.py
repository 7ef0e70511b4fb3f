"""Publishers, subscribers and cameras without a ROS master, and plugins made with them."""

import io
import types

import dynamic_reconfigure.server
from bullet_bridge.plugins import base
from bullet_bridge.plugins.base import PluginContext, make_plugin
from geometry_msgs.msg import Twist


class Impl:
    """Hands messages, read back from their bytes, to the fake publisher that owns it.

    Args:
        owner: has kind and publish(message).
    """

    closed = is_latch = False

    def __init__(self, owner):
        self._owner, self.seq, self.message_data_sent, self.connections = owner, 0, 0, [self]

    def acquire(self):
        """Nobody else publishes."""

    def release(self):
        """Nobody else publishes."""

    def write_data(self, data):
        assert len(data) == 4 + int.from_bytes(data[:4], "little")
        self._owner.publish(self._owner.kind().deserialize(data[4:]))

    def write_block(self, block):
        """As a ConnectionWrapper."""
        for message in block:
            self.write_data(message.tobytes())


class Topic:
    """Stands in for publishers, subscribers and services."""

    def __init__(self, name, kind, call=None, **_):
        self.name, self.kind, self.call, self.messages, self.subscribers = name, kind, call, [], 1
        self.closed, self.impl = False, Impl(self)

    def publish(self, message):
        """Keep it, and see that it can be sent."""
        message.serialize(io.BytesIO())
        self.messages.append(message)

    def get_num_connections(self):
        """One subscriber unless a test sets another number."""
        return self.subscribers

    def unregister(self):
        """Close; nothing stands behind it any more, as with rospy's."""
        self.closed, self.impl = True, None

    def shutdown(self, _reason):
        self.closed = True


class FakeServer:
    """Stands in for a ValuesServer: stores its arguments."""

    made: dict = {}

    def __init__(self, config, values, callback, namespace):
        self.config, self.values, self.callback, self.closed = config, dict(values), callback, False
        self.made[namespace] = self

    def unregister(self):
        self.closed = True

    close = unregister


class FakeReceivedCounts:
    """Stands in for ReceivedCounts: stores the last topic and its callback."""

    topic = take = None

    def subscribe(self, topic, kind, callback, **_options):
        self.topic, self.take = topic, callback
        return Topic(topic, kind)


class FakeCameras:
    """Stands in for Cameras: stores what is requested."""

    def __init__(self):
        self.sensors, self.requests = [], []

    def add(self, sensor):
        self.sensors.append(sensor)

    def remove(self, sensor):
        self.sensors.remove(sensor)

    def request(self, request):
        self.requests.append(request)


def fake_publishers(monkeypatch, *modules, subscribers=1):
    """Topics by name, of the publishers that plugins, and other modules, make from now on."""
    made = {}

    def publisher(name, kind, call=None, **_):
        if name not in made or made[name].closed:
            made[name] = Topic(name, kind, call)
            made[name].subscribers = subscribers
        return made[name]

    for module in (base, *modules):
        monkeypatch.setattr(module, "publisher", publisher)
    monkeypatch.setattr(FakeServer, "made", {})
    monkeypatch.setattr(base, "ValuesServer", FakeServer)
    monkeypatch.setattr(base.rospy, "Service", lambda name, kind, call: publisher(name, kind, call))
    return made


def fake_reconfigure(monkeypatch):
    """Parameters by name, of the servers of dynamic_reconfigure that are made from now on."""
    params = {}
    ros = types.SimpleNamespace(
        Publisher=lambda name, kind, **_: Topic(name, kind),
        Service=Topic,
        set_param=params.__setitem__,
    )
    monkeypatch.setattr(dynamic_reconfigure.server, "rospy", ros)
    return params


def twist(x, yaw=0.0, y=0.0):
    """geometry_msgs/Twist of a base: forward and to the left [m/s], turning [rad/s]."""
    message = Twist()
    message.linear.x, message.linear.y, message.angular.z = x, y, yaw
    return message


def plugin_of(world, model, spec, seed=0, received=None):
    """The plugin of a specification, as the simulation makes it."""
    sensors = model.description.sensors
    number = next((index for index, other in enumerate(sensors) if other is spec), len(sensors))
    context = PluginContext(
        world, model, spec, seed, number, FakeCameras(), received=received or FakeReceivedCounts()
    )
    return make_plugin(context)


def in_thread(plugin):
    """The plugin, whose calls of the simulation thread are made at once."""
    plugin.call = lambda work: work()
    return plugin
