"""What the filter says on /diagnostics."""

import time

import rospy
from diagnostic_msgs.msg import DiagnosticStatus
from diagnostic_updater import Updater

from robot_localization.estimate.state import NAMES, SIZE
from robot_localization.inputs.sensors import doubts

PERIOD = 1.0  # wall time between two messages [s]
LARGE = 1e3  # a variance from which on a number is not known


class Diagnostics:
    """Doubts about the sensors, how often an estimate comes, outliers.

    Args:
        options: Options.
        sensors: Sensors of the node.
    """

    def __init__(self, options, sensors):
        self._doubts = doubts(sensors, options.two_d_mode)
        self._frequency = options.frequency
        self._count = self._outliers = 0
        self._since = self._due = time.monotonic()
        self._rate = 0.0
        self._unknown = []
        self._updater = Updater()
        self._updater.setHardwareID("none")
        self._updater.add("Filter diagnostic updater", self._state)
        self._updater.add("odometry/filtered topic status", self._topic)

    def update(self, ekf, outliers):
        """Counts an estimate, and publishes when it is time."""
        self._count += ekf.initialized
        self._outliers += outliers
        now = time.monotonic()
        if now < self._due:
            return
        self._due = now + PERIOD
        self._rate = self._count / max(now - self._since, 1e-9)
        self._unknown = [NAMES[i] for i in range(SIZE) if not ekf.covariance[i, i] < LARGE]
        self._count, self._since = 0, now
        self._updater.force_update()
        self._outliers = 0

    def _state(self, status):
        level = DiagnosticStatus.OK
        for error, name, words in self._doubts:
            level = max(level, DiagnosticStatus.ERROR if error else DiagnosticStatus.WARN)
            status.add(f"{name}_configuration", words)
        if self._outliers:
            level = max(level, DiagnosticStatus.WARN)
            status.add("outliers", f"{self._outliers} measurements were left out as outliers")
        if self._unknown:
            level = max(level, DiagnosticStatus.WARN)
            status.add("covariance", f"hardly known: {', '.join(self._unknown)}")
        status.summary(level, "ok" if level == DiagnosticStatus.OK else "see the values")
        return status

    def _topic(self, status):
        status.summary(DiagnosticStatus.OK, f"{self._rate:.1f} per second of wall time")
        status.add("wanted", f"{self._frequency:g} Hz of ROS time")
        status.add("ROS time", f"{rospy.get_time():.3f}")
        return status
