"""The nodes twist_mux and twist_marker."""

import threading

import rospy
from diagnostic_msgs.msg import DiagnosticStatus
from diagnostic_updater import Updater
from geometry_msgs.msg import Point, Twist
from std_msgs.msg import Bool
from visualization_msgs.msg import Marker

from paddock_common import nodes
from velocity_mux.mux import Mux, read

FRAME = "base_footprint"
HEIGHT = 2.0  # of the arrow above the frame [m]
SHAFT, HEAD = 0.05, 0.1  # diameters of the arrow [m]


def tip(twist):
    """Tip of the arrow: forward speed, and sideways the larger of lateral speed and yaw rate.

    Returns:
        (x, y) [m for m/s, and for rad/s].
    """
    sideways = max(twist.linear.y, twist.angular.z, key=abs)
    return twist.linear.x, sideways


def arrow(twist):
    """visualization_msgs/Marker of a geometry_msgs/Twist."""
    marker = Marker(type=Marker.ARROW, action=Marker.ADD)
    marker.header.frame_id = FRAME
    marker.pose.position.z = HEIGHT
    marker.pose.orientation.w = 1.0
    marker.scale.x, marker.scale.y = SHAFT, HEAD
    marker.color.g = marker.color.a = 1.0
    marker.points = [Point(), Point(*tip(twist), 0.0)]
    return marker


def connect_marker():
    publisher = rospy.Publisher("marker", Marker, queue_size=1, latch=True)
    rospy.Subscriber("twist", Twist, lambda twist: publisher.publish(arrow(twist)), queue_size=1)


def show_marker():
    nodes.run("twist_marker", connect_marker)


DIAGNOSTICS_PERIOD = 1.0  # wall time [s]


class MuxNode:
    """Subscribes to all sources and locks, publishes cmd_vel_out."""

    def __init__(self):
        lists = {}
        for list_name in ("topics", "locks"):
            lists[list_name], problems = read(list_name, rospy.get_param("~" + list_name, []))
            for problem in problems:
                rospy.logerr("twist_mux: %s", problem)
        if not lists["topics"]:
            rospy.logerr("twist_mux: %s lists no source", rospy.resolve_name("~topics"))
        self._lock = threading.Lock()
        self._mux = Mux(lists["topics"], lists["locks"])
        self._publisher = rospy.Publisher("cmd_vel_out", Twist, queue_size=1)
        self._subscribers = [
            rospy.Subscriber(entry.topic, Twist, self._command, index, queue_size=1)
            for index, entry in enumerate(lists["topics"])
        ] + [
            rospy.Subscriber(entry.topic, Bool, self._set_lock, index, queue_size=1)
            for index, entry in enumerate(lists["locks"])
        ]
        for list_name, entries in lists.items():
            for entry in entries:
                rospy.loginfo(
                    "twist_mux: %s '%s': topic %s, timeout %s, priority %d",
                    "source" if list_name == "topics" else "lock",
                    entry.name,
                    rospy.resolve_name(entry.topic),
                    f"{entry.timeout:g} s" if entry.timeout else "none",
                    entry.priority,
                )
        self._updater = Updater()
        self._updater.setHardwareID("none")
        self._updater.add("Twist mux status", self._diagnose)

    def _command(self, message, index):
        with self._lock:
            if self._mux.command(index, rospy.get_time()):
                self._publisher.publish(message)

    def _set_lock(self, message, index):
        with self._lock:
            self._mux.lock(index, message.data, rospy.get_time())

    def _diagnose(self, status):
        now = rospy.get_time()
        with self._lock:
            mux = self._mux
            status.summary(DiagnosticStatus.OK, "ok")
            for index, source in enumerate(mux.sources):
                state = "masked" if mux.masked(index, now) else "unmasked"
                status.add(f"velocity {source.entry.name}", _diagnostic_text(state, source.entry))
            for lock in mux.locks:
                state = "locked" if lock.locked(now) else "free"
                status.add(f"lock {lock.entry.name}", _diagnostic_text(state, lock.entry))
            status.add("current priority", str(mux.lock_priority(now)))
        return status

    def spin(self):
        """Publishes the diagnostics until ROS shuts down."""
        while not rospy.is_shutdown():
            self._updater.force_update()
            rospy.rostime.wallsleep(DIAGNOSTICS_PERIOD)


def _diagnostic_text(state, entry):
    return (
        f"{state} (listening to {entry.topic} @ {entry.timeout:f}s with priority #{entry.priority})"
    )


def main():
    nodes.start("twist_mux", MuxNode).spin()
