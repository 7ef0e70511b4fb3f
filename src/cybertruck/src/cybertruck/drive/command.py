"""The newest drive command and its age. No ROS."""

import math
import threading

from paddock_common.rules import Number


def refusal(**values):
    """Reason to refuse a command, or '' when all its numbers are finite."""
    for name, value in values.items():
        if not math.isfinite(value):
            return f"{name} is {value}, must be a finite number"
    return ""


class Command:
    """The last commanded steering and speed; callbacks write, the drive loop reads.

    Args:
        timeout: age [s] above which the truck stops.

    Attributes:
        timeout: the same.
    """

    def __init__(self, timeout):
        self.timeout = float(Number(above=0.0, unit="s").check("command_timeout", timeout))
        self._lock = threading.Lock()
        self._steering = self._speed = 0.0
        self._time = None

    def give(self, steering, speed, time):
        """Set a checked command given at a time [s]."""
        with self._lock:
            self._steering, self._speed, self._time = steering, speed, time

    def stop(self):
        """Speed 0 until the next command; the steering angle stays."""
        with self._lock:
            self._speed, self._time = 0.0, None

    def target(self, now):
        """Target at a time [s].

        Returns:
            (steering [rad], speed [m/s], expired): expired is True once, when the command has
            just become too old.
        """
        with self._lock:
            if self._time is None:
                return self._steering, 0.0, False
            # joint states lag a little behind the clock; further ahead, the clock went back
            if -self.timeout <= now - self._time <= self.timeout:
                return self._steering, self._speed, False
            self._speed, self._time = 0.0, None
            return self._steering, 0.0, True
