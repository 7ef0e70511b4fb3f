"""The node twist_mux."""

import threading

import rospy
from diagnostic_msgs.msg import DiagnosticStatus
from diagnostic_updater import Updater
from geometry_msgs.msg import Twist
from std_msgs.msg import Bool

from paddock_common import nodes
from velocity_mux.entries import read
from velocity_mux.mux import Mux

DIAGNOSTICS_PERIOD = 1.0  # wall time [s]


class MuxNode:
    """Subscribes to all sources and locks, publishes cmd_vel_out."""

    def __init__(self):
        lists = {}
        for kind in ("topics", "locks"):
            lists[kind], problems = read(kind, rospy.get_param("~" + kind, []))
            for problem in problems:
                rospy.logerr("twist_mux: %s", problem)
        if not lists["topics"]:
            rospy.logerr("twist_mux: %s lists no source", rospy.resolve_name("~topics"))
        self._lock = threading.Lock()
        self._mux = Mux(lists["topics"], lists["locks"])
        self._publisher = rospy.Publisher("cmd_vel_out", Twist, queue_size=1)
        self._subscribers = [
            rospy.Subscriber(entry.topic, Twist, self._command, number, queue_size=1)
            for number, entry in enumerate(lists["topics"])
        ] + [
            rospy.Subscriber(entry.topic, Bool, self._set_lock, number, queue_size=1)
            for number, entry in enumerate(lists["locks"])
        ]
        for kind, entries in lists.items():
            for entry in entries:
                rospy.loginfo(
                    "twist_mux: %s '%s': topic %s, timeout %s, priority %d",
                    "source" if kind == "topics" else "lock",
                    entry.name,
                    rospy.resolve_name(entry.topic),
                    f"{entry.timeout:g} s" if entry.timeout else "none",
                    entry.priority,
                )
        self._updater = Updater()
        self._updater.setHardwareID("none")
        self._updater.add("Twist mux status", self._diagnose)

    def _command(self, message, number):
        with self._lock:
            if self._mux.command(number, rospy.get_time()):
                self._publisher.publish(message)

    def _set_lock(self, message, number):
        with self._lock:
            self._mux.lock(number, message.data, rospy.get_time())

    def _diagnose(self, status):
        now = rospy.get_time()
        with self._lock:
            mux = self._mux
            status.summary(DiagnosticStatus.OK, "ok")
            for number, source in enumerate(mux.sources):
                state = "masked" if mux.masked(number, now) else "unmasked"
                status.add(f"velocity {source.entry.name}", _words(state, source.entry))
            for lock in mux.locks:
                state = "locked" if lock.locked(now) else "free"
                status.add(f"lock {lock.entry.name}", _words(state, lock.entry))
            status.add("current priority", str(mux.lock_priority(now)))
        return status

    def spin(self):
        """Publishes the diagnostics until ROS ends."""
        while not rospy.is_shutdown():
            self._updater.force_update()
            rospy.rostime.wallsleep(DIAGNOSTICS_PERIOD)


def _words(state, entry):
    return (
        f"{state} (listening to {entry.topic} @ {entry.timeout:f}s with priority #{entry.priority})"
    )


def main():
    """Runs the node."""
    nodes.init_interruptible("twist_mux")
    MuxNode().spin()
    return 0
