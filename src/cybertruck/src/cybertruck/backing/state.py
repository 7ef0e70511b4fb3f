"""State of truck and trailer: odometry with the hitch angle at its stamp, and its age."""

import math
import threading
from collections import deque
from dataclasses import dataclass

import numpy as np
import rospy
from nav_msgs.msg import Odometry
from paddock_common.geometry import planar_of
from sensor_msgs.msg import JointState

from cybertruck.trailer.kinematics import trailer_axle

HISTORY = 60  # messages stored for pairing, about half a second


@dataclass(frozen=True)
class TruckState:
    """One odometry message and the hitch angle at its stamp.

    Attributes:
        stamp: Of the odometry [s].
        x, y, heading: Rear axle's center and θ1 in the odometry frame [m, m, rad].
        speed: Of the rear axle's center [m/s].
        hitch_angle: ψ [rad], 0 without a hitch.
    """

    stamp: float
    x: float
    y: float
    heading: float
    speed: float
    hitch_angle: float

    def trailer(self, geometry):
        """(x, y [m], θ2 [rad]) of the trailer's axle."""
        return trailer_axle(self.x, self.y, self.heading, self.hitch_angle, geometry)

    def is_finite(self):
        """Whether all numbers are finite."""
        return all(map(math.isfinite, (self.x, self.y, self.heading, self.speed, self.hitch_angle)))


class StateSource:
    """Subscribes to odometry and, if a joint is named, joint states.

    Args:
        odom_topic: nav_msgs/Odometry of the rear axle's center, twist in the child frame.
        hitch_joint: Name of the hitch in /joint_states, or None without a trailer.

    Attributes:
        resets: Number of times the odometry's stamps went back: resets of the simulation.
    """

    def __init__(self, odom_topic="/odom", hitch_joint=None):
        self._changed = threading.Condition()
        self._state = None
        self.resets = 0
        self._odometry = deque(maxlen=HISTORY)
        self._hitch = deque(maxlen=HISTORY)
        self._joint = hitch_joint
        self._subscribers = [
            rospy.Subscriber(
                odom_topic, Odometry, self._on_odometry, queue_size=HISTORY, tcp_nodelay=True
            )
        ]
        if hitch_joint is not None:
            self._subscribers.append(
                rospy.Subscriber(
                    "/joint_states",
                    JointState,
                    self._on_joints,
                    queue_size=HISTORY,
                    tcp_nodelay=True,
                )
            )

    def _on_joints(self, message):
        if self._joint in message.name:
            angle = message.position[message.name.index(self._joint)]
            self._store(self._hitch, message.header.stamp.to_sec(), angle)

    def _on_odometry(self, message):
        self._store(
            self._odometry,
            message.header.stamp.to_sec(),
            (*planar_of(message.pose.pose), message.twist.twist.linear.x),
        )

    def _store(self, messages, stamp, value):
        """Stores a message and makes the newest state for which both messages have arrived."""
        with self._changed:
            if messages and stamp < messages[-1][0]:  # the simulation was reset
                messages.clear()
                self.resets += messages is self._odometry
            messages.append((stamp, value))
            state = self._paired()
            if state is not None and (self._state is None or state.stamp != self._state.stamp):
                self._state = state
                self._changed.notify_all()

    def _paired(self):
        """The newest odometry with hitch angles before and after it, or None."""
        if self._joint is None:
            stamp, values = self._odometry[-1]
            return TruckState(stamp, *values, 0.0)
        if not self._hitch:
            return None
        for stamp, values in reversed(self._odometry):
            if stamp <= self._hitch[-1][0]:
                return TruckState(stamp, *values, float(np.interp(stamp, *zip(*self._hitch))))
        return None

    @property
    def state(self):
        """The newest TruckState, or None."""
        with self._changed:
            return self._state

    def wait(self, after, wall_time):
        """Waits for a state that is newer than a stamp, or older after a reset of time.

        Args:
            after: Stamp [s]; None: the newest one.
            wall_time: Maximum wait [s].

        Returns:
            TruckState, or None after a time-out.
        """

        def is_new():
            return self._state is not None and (
                after is None or not after - 1.0 <= self._state.stamp <= after
            )

        with self._changed:
            return self._state if self._changed.wait_for(is_new, wall_time) else None

    def staleness(self, timeout):
        """Returns what is missing.

        Args:
            timeout: Age in simulated time above which a message is stale [s].

        Returns:
            A reason, or "" when all is fresh.
        """
        with self._changed:
            state = self._state
            odometry = self._odometry[-1][0] if self._odometry else None
            hitch = self._hitch[-1][0] if self._hitch else None
        now = rospy.get_time()
        if odometry is None:
            return f"no odometry on {self._subscribers[0].resolved_name} yet"
        if now - odometry > timeout:
            return f"no odometry for {now - odometry:.2f} s"
        if self._joint is not None and hitch is None:
            return f"no joint '{self._joint}' in /joint_states yet"
        if self._joint is not None and now - hitch > timeout:
            return f"no joint '{self._joint}' in /joint_states for {now - hitch:.2f} s"
        if state is None:
            return "odometry and joint states do not overlap in time yet"
        if not state.is_finite():
            return "odometry or hitch angle is not finite"
        return ""
