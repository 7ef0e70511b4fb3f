"""State of truck and trailer: odometry with the hitch angle at its stamp, and its age."""

import math
import threading
from collections import deque
from dataclasses import dataclass

import rospy
from nav_msgs.msg import Odometry
from paddock_common.geometry import yaw_of
from sensor_msgs.msg import JointState

from cybertruck.trailer.kinematics import trailer_axle

HISTORY = 60  # messages stored for pairing, about half a second


@dataclass(frozen=True)
class RigState:
    """One odometry message and the hitch angle at its stamp.

    Attributes:
        stamp: Of the odometry [s].
        x, y, heading: Rear axle's centre and θ1 in the odometry frame [m, m, rad].
        speed: Of the rear axle's centre [m/s].
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
    """Subscribes odometry and, if a joint is named, joint states.

    Attributes:
        resets: Number of times the odometry's stamps went back: resets of the simulation.
    """

    def __init__(self, odom_topic="/odom", hitch_joint=None):
        """Subscribes.

        Args:
            odom_topic: nav_msgs/Odometry of the rear axle's centre, twist in the child frame.
            hitch_joint: Name of the hitch in /joint_states, or None for a truck alone.
        """
        self._news = threading.Condition()
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
            self._keep(self._hitch, message.header.stamp.to_sec(), angle)

    def _on_odometry(self, message):
        pose, heading = message.pose.pose.position, yaw_of(message.pose.pose.orientation)
        self._keep(
            self._odometry,
            message.header.stamp.to_sec(),
            (pose.x, pose.y, heading, message.twist.twist.linear.x),
        )

    def _keep(self, kept, stamp, value):
        """Stores a message and makes the newest state for which both messages are there."""
        with self._news:
            if kept and stamp < kept[-1][0]:  # the simulation was reset
                kept.clear()
                self.resets += kept is self._odometry
            kept.append((stamp, value))
            state = self._paired()
            if state is not None and (self._state is None or state.stamp != self._state.stamp):
                self._state = state
                self._news.notify_all()

    def _paired(self):
        """The newest odometry with hitch angles before and after it, or None."""
        if self._joint is None:
            stamp, values = self._odometry[-1]
            return RigState(stamp, *values, 0.0)
        if not self._hitch:
            return None
        for stamp, values in reversed(self._odometry):
            if stamp <= self._hitch[-1][0]:
                return RigState(stamp, *values, self._hitch_at(stamp))
        return None

    def _hitch_at(self, stamp):
        """The interpolated hitch angle at a time [rad]."""
        later = self._hitch[-1]
        for earlier in reversed(self._hitch):
            if earlier[0] <= stamp:
                share = (
                    0.0
                    if later[0] == earlier[0]
                    else ((stamp - earlier[0]) / (later[0] - earlier[0]))
                )
                return earlier[1] + share * (later[1] - earlier[1])
            later = earlier
        return later[1]

    @property
    def state(self):
        """The newest RigState, or None."""
        with self._news:
            return self._state

    def wait(self, after, wall_time):
        """Waits for a state that is newer than a stamp, or older, when time was reset.

        Args:
            after: Stamp [s]; None takes the newest there is.
            wall_time: Longest wait [s].

        Returns:
            RigState, or None after a time-out.
        """

        def is_new():
            return self._state is not None and (
                after is None or not 0.0 <= after - self._state.stamp
            )

        def is_reset():
            return (
                self._state is not None and after is not None and (self._state.stamp < after - 1.0)
            )

        with self._news:
            self._news.wait_for(lambda: is_new() or is_reset(), wall_time)
            return self._state if is_new() or is_reset() else None

    def staleness(self, timeout):
        """Returns what is missing.

        Args:
            timeout: Age in simulated time above which something counts as stale [s].

        Returns:
            A reason, or "" when all is fresh.
        """
        with self._news:
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
            return "odometry and joint states are not of the same time yet"
        if not state.is_finite():
            return "odometry or hitch angle is not finite"
        return ""
