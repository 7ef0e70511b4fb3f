"""joystick_relay.py: a joystick's twists, with turbo and priority."""

import threading
from dataclasses import dataclass

import rospy
from actionlib import SimpleActionServer
from geometry_msgs.msg import Twist
from paddock_common.settings import Number
from std_msgs.msg import Bool
from twist_mux_msgs.msg import JoyPriorityAction, JoyPriorityResult, JoyTurboAction, JoyTurboResult
from visualization_msgs.msg import Marker

from paddock_common import nodes


@dataclass(frozen=True)
class Range:
    """Speeds of the first and the last step [m/s or rad/s]."""

    minimum: float
    maximum: float

    def at(self, step, steps):
        """Speed at a step, 1..steps; with one step alone the minimum."""
        if steps == 1:
            return self.minimum
        return self.minimum + (self.maximum - self.minimum) * (step - 1) / (steps - 1)


class Turbo:
    """Steps for linear and angular speed, changed by buttons.

    Args:
        parameters: Values of `~turbo`: steps, init_step, linear_forward_min, _max and so on.

    Raises:
        ValueError: A value is not a positive number.
    """

    def __init__(self, parameters):
        def positive(name, default):
            return Number(above=0.0).check(f"turbo/{name}", parameters.get(name, default))

        def speeds(name, default):
            return Range(
                positive(name + "_min", default.minimum), positive(name + "_max", default.maximum)
            )

        one = Range(1.0, 1.0)
        self.steps = int(positive("steps", 1))
        self.forward = speeds("linear_forward", one)
        self.backward = speeds("linear_backward", self.forward)
        self.lateral = speeds("linear_lateral", one)
        self.angular = speeds("angular", one)
        center = (self.steps + 1) // 2
        first = parameters.get("init_step", center)
        self._first = int(first) if 1 <= first <= self.steps else center
        self.reset()

    def reset(self):
        """Back to the first steps."""
        self.step = self.angular_step = self._first

    def change(self, by):
        """One step more (1) or less (-1) of both."""
        self.step = min(max(self.step + by, 1), self.steps)
        self.change_angular(by)

    def change_angular(self, by):
        """One step more (1) or less (-1) of the yaw rate."""
        self.angular_step = min(max(self.angular_step + by, 1), self.steps)

    def scale(self, x, y, yaw):
        """Speeds of a joystick's command.

        Args:
            x: Forward, -1..1.
            y: To the left, -1..1.
            yaw: To the left, -1..1.

        Returns:
            (forward [m/s], left [m/s], yaw rate [rad/s]).

        Raises:
            ValueError: A number is not within -1..1.
        """
        for name, value in (("linear.x", x), ("linear.y", y), ("angular.z", yaw)):
            if not -1.0 <= value <= 1.0:
                raise ValueError(f"{name} is {value:g}, must be within -1..1")
        forward = self.forward if x >= 0.0 else self.backward
        return (
            x * forward.at(self.step, self.steps),
            y * self.lateral.at(self.step, self.steps),
            yaw * self.angular.at(self.angular_step, self.steps),
        )


MARKER_PERIOD = 1.0  # wall time between two markers [s]


class Relay:
    """Subscribes to joy_vel_in, publishes joy_vel_out, joy_priority and text_marker."""

    def __init__(self):
        self._lock = threading.Lock()
        self._turbo = Turbo(rospy.get_param("~turbo", {}))
        self._drives = bool(rospy.get_param("~priority", True))
        self._out = rospy.Publisher("joy_vel_out", Twist, queue_size=1)
        self._priority = rospy.Publisher("joy_priority", Bool, queue_size=1, latch=True)
        self._marker = rospy.Publisher("text_marker", Marker, queue_size=1, latch=True)
        self._priority.publish(self._drives)
        turbo = self._turbo
        self._servers = [
            self._server("joy_priority_action", JoyPriorityAction, JoyPriorityResult, self._swap)
        ] + [
            self._server(name, JoyTurboAction, JoyTurboResult, change)
            for name, change in (
                ("joy_turbo_increase", lambda: turbo.change(1)),
                ("joy_turbo_decrease", lambda: turbo.change(-1)),
                ("joy_turbo_angular_increase", lambda: turbo.change_angular(1)),
                ("joy_turbo_angular_decrease", lambda: turbo.change_angular(-1)),
                ("joy_turbo_reset", turbo.reset),
            )
        ]
        rospy.Subscriber("joy_vel_in", Twist, self._command, queue_size=1)

    def _server(self, name, action, result, change):
        def execute(_):
            with self._lock:
                change()
            server.set_succeeded(result())

        server = SimpleActionServer(name, action, execute, auto_start=False)
        server.start()
        return server

    def _swap(self):
        self._drives = not self._drives
        rospy.loginfo("the joystick %s", "drives" if self._drives else "does not drive")
        self._priority.publish(self._drives)
        if self._drives:
            self._out.publish(Twist())
        self.show()

    def _command(self, message):
        with self._lock:
            if not self._drives:
                return
            twist = Twist()
            try:
                if message.linear.z or message.angular.x or message.angular.y:
                    raise ValueError("linear.z, angular.x and angular.y must be 0")
                twist.linear.x, twist.linear.y, twist.angular.z = self._turbo.scale(
                    message.linear.x, message.linear.y, message.angular.z
                )
            except ValueError as error:
                rospy.logerr_throttle(1.0, f"joystick_relay: command of the joystick: {error}")
            self._out.publish(twist)

    def show(self):
        """Publishes the text above the robot."""
        marker = Marker(type=Marker.TEXT_VIEW_FACING, action=Marker.ADD)
        marker.header.frame_id = "base_footprint"
        marker.pose.position.z, marker.pose.orientation.w, marker.scale.z = 2.0, 1.0, 0.5
        marker.color.r = marker.color.g = marker.color.b = marker.color.a = 1.0
        marker.text = "Manual" if self._drives else "Autonomous"
        self._marker.publish(marker)


def main():
    relay = nodes.start("joystick_relay", Relay)
    while not rospy.is_shutdown():
        relay.show()
        rospy.rostime.wallsleep(MARKER_PERIOD)
