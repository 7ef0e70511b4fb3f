"""The node joystick_relay.py: scales a joystick's commands, and says whether it drives."""

import threading

import rospy
from actionlib import SimpleActionServer
from geometry_msgs.msg import Twist
from std_msgs.msg import Bool
from twist_mux_msgs.msg import JoyPriorityAction, JoyPriorityResult, JoyTurboAction, JoyTurboResult
from visualization_msgs.msg import Marker

from paddock_common import nodes
from velocity_mux.turbo import Turbo

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
    """Runs the node; returns 1 when a parameter is wrong."""
    nodes.init_interruptible("joystick_relay")
    try:
        relay = Relay()
    except ValueError as error:
        rospy.logfatal("joystick_relay: %s", error)
        return 1
    while not rospy.is_shutdown():
        relay.show()
        rospy.rostime.wallsleep(MARKER_PERIOD)
    return 0
