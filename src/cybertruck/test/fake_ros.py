"""Fake of rospy for a node without a master: a clock set by hand, recorded messages and logs."""

import rospy
import tf2_ros


class FakeRos:
    """Records what a node publishes, logs and subscribes.

    Attributes:
        now: ROS time [s].
        sent: (topic, message) in order.
        logged: (level, text) of the log in order.
        subscribed: topic -> callback.
        services: name -> callback.
        timers, periods: callbacks, and how often they are called [s].
        hooks: callbacks of rospy.on_shutdown.
    """

    def __init__(self):
        self.now = 0.0
        self.sent, self.logged, self.timers = [], [], []
        self.subscribed, self.services, self.hooks, self.periods = {}, {}, [], []

    def install(self, monkeypatch, parameters=()):
        """Replaces the parts of rospy that the nodes use.

        Args:
            monkeypatch: Of pytest.
            parameters: Dict of private name without "~" -> value.
        """
        given, fake = dict(parameters), self

        class Publisher:
            def __init__(self, topic, *_, queue_size=None, **__):
                self.topic, self.queue_size = topic, queue_size

            def publish(self, message):
                fake.sent.append((self.topic, message))

        class Broadcaster:
            def sendTransform(self, _transform):  # noqa: N802, tf2's name
                pass

        def log(level):
            return lambda text, *values: fake.logged.append(
                (level, text % values if values else text)
            )

        for name in ("loginfo", "logwarn", "logerr"):
            monkeypatch.setattr(rospy, name, log(name[3:]))
            say = log(name[3:])
            monkeypatch.setattr(
                rospy, name + "_throttle", lambda _period, *words, say=say: say(*words)
            )
        for name, value in (
            ("Publisher", Publisher),
            ("get_time", lambda: self.now),
            (
                "Subscriber",
                lambda topic, _kind, callback, **_: self.subscribed.update({topic: callback}),
            ),
            ("Service", lambda topic, _kind, callback: self.services.update({topic: callback})),
            (
                "Timer",
                lambda period, callback, reset=False: (
                    reset and (self.timers.append(callback), self.periods.append(period.to_sec()))
                ),
            ),
            ("on_shutdown", self.hooks.append),
            ("has_param", lambda name: name[1:] in given),
            (
                "get_param",
                lambda name, *default: given[name[1:]] if name[1:] in given else default[0],
            ),
        ):
            monkeypatch.setattr(rospy, name, value)
        monkeypatch.setattr(rospy.Time, "now", staticmethod(lambda: rospy.Time.from_sec(self.now)))
        monkeypatch.setattr(tf2_ros, "TransformBroadcaster", Broadcaster)

    def messages(self, topic):
        """Messages published on a topic, in order."""
        return [message for name, message in self.sent if name == topic]

    def texts(self, level):
        """Texts logged at a level, in order."""
        return [text for kind, text in self.logged if kind == level]
