#!/usr/bin/env python3
"""Stages of sending that can be switched off in a running bridge."""

import gc
import sys
import time

from bullet_bridge.transport import conversions, packed
from bullet_bridge.transport.publishing import QUEUE_SIZE, DirectConnection
from bullet_bridge.transport.relay import RelayedConnection
from nav_msgs.msg import Odometry
from rosgraph_msgs.msg import Clock
from rospy.impl.registration import get_topic_manager
from rospy.impl.tcpros_pubsub import QueuedConnection
from sensor_msgs.msg import JointState


class Connections:
    """Three wrappers of each subscriber's transport, which can be exchanged while it runs.

    Args:
        relay: Relay.
    """

    def __init__(self, relay):
        self._relay, self._sets = relay, {}
        for impl in list(get_topic_manager().pubs.values()):
            relayed = [c for c in impl.connections if isinstance(c, RelayedConnection)]
            if relayed:
                transports = [c._connection for c in relayed]
                self._sets[impl] = {
                    "relay": relayed,
                    "direct": [DirectConnection(t, QUEUE_SIZE) for t in transports],
                    "rospy": [QueuedConnection(t, QUEUE_SIZE) for t in transports],
                }

    @property
    def count(self):
        """Number of connections."""
        return sum(len(sets["relay"]) for sets in self._sets.values())

    def use(self, kind):
        """Send through `relay`, `direct` or `rospy` from now on; messages under way come first."""
        self._relay.drain()
        deadline = time.monotonic() + 5.0
        while self._under_way() and time.monotonic() < deadline:
            time.sleep(0.001)
        for impl, sets in self._sets.items():
            with impl.c_lock:
                impl.connections = [c for c in sets[kind] if not c.done]

    def _under_way(self):
        return any(
            connection._queue for sets in self._sets.values() for connection in sets["direct"]
        ) or any(connection._queue for sets in self._sets.values() for connection in sets["rospy"])


class Packing:
    """Sends joint states, odometry and the clock packed, or as messages that genpy serialises."""

    def __init__(self):
        self._packed = True
        self._wrap(packed.PackedJointState, self._joint_state)
        self._wrap(packed.PackedOdometry, self._odometry)
        self._wrap(packed.PackedClock, lambda _, time: Clock(conversions.stamp(time)))

    def use(self, packed_messages):
        """Choose."""
        self._packed = packed_messages

    def _wrap(self, kind, build):
        init, send = kind.__init__, kind.send

        def remember(sender, *arguments):
            init(sender, *arguments)
            sender.arguments = arguments

        def switched(sender, *values):
            if self._packed:
                send(sender, *values)
                return
            impl = sender._impl
            impl.acquire()
            try:
                impl.publish(build(sender, *values))
            finally:
                impl.release()

        kind.__init__, kind.send = remember, switched

    @staticmethod
    def _joint_state(sender, time, positions, velocities, efforts):
        message = JointState(
            name=list(sender.arguments[1]),
            position=list(positions),
            velocity=list(velocities),
            effort=list(efforts),
        )
        message.header.stamp = conversions.stamp(time)
        return message

    @staticmethod
    def _odometry(sender, time, position, orientation, linear, angular):
        _, frame, child_frame, variance = sender.arguments
        message = Odometry(child_frame_id=child_frame)
        message.header.stamp, message.header.frame_id = conversions.stamp(time), frame
        p, q, twist = message.pose.pose.position, message.pose.pose.orientation, message.twist.twist
        p.x, p.y, p.z = map(float, position)
        q.x, q.y, q.z, q.w = map(float, orientation)
        twist.linear.x, twist.linear.y, twist.linear.z = map(float, linear)
        twist.angular.x, twist.angular.y, twist.angular.z = map(float, angular)
        for covariance in (message.pose.covariance, message.twist.covariance):
            covariance[::7] = [variance] * 6
        return message


class Switches:
    """The stages, each with a function that switches it on (True) or off.

    Args:
        server: Server.
        packing: Packing.
    """

    def __init__(self, server, packing):
        relay = server._relay
        self.connections = connections = Connections(relay)
        begin, end, publish = relay.begin_batch, relay.end_batch, server._publish

        def batch(on):
            relay.begin_batch, relay.end_batch = (begin, end) if on else ((lambda: None),) * 2

        def freeze(on):
            gc.unfreeze()
            gc.collect()
            if on:
                gc.freeze()

        def everything(on):
            connections.use("relay" if on else "rospy")
            packing.use(on)
            batch(on)

        def direct(on):
            connections.use("direct" if on else "rospy")

        self.stages = {  # name: (switch, restore the bridge's own state)
            "packed messages": (packing.use, lambda: None),
            "direct sending (without relay, against rospy's threads)": (
                direct,
                lambda: connections.use("relay"),
            ),
            "relay (against direct sending)": (
                lambda on: connections.use("relay" if on else "direct"),
                lambda: None,
            ),
            "batch": (batch, lambda: None),
            "relay polls": (relay.set_polling, lambda: None),
            "/clock thinned": (
                lambda on: setattr(server, "_publish", publish if on else self._every(publish)),
                lambda: None,
            ),
            "switch interval 0.5 ms (against 5 ms)": (
                lambda on: sys.setswitchinterval(0.0005 if on else 0.005),
                lambda: sys.setswitchinterval(0.005),
            ),
            "gc.freeze": (freeze, gc.unfreeze),
            "nothing (the spread of the method)": (lambda on: None, lambda: None),
            "all of packing, relay, batch (against rospy)": (everything, lambda: None),
        }

    @staticmethod
    def _every(publish):
        return lambda thin: publish(False)
