"""The car of a run: waits for it, operates it, checks it."""

import time

import rospy
from deepracer_control.topics import CAMERA_TOPIC, ODOMETRY_TOPIC
from nav_msgs.msg import Odometry
from PyQt5.QtTest import QTest

from deepracer_teleop.drivers import Mouse
from deepracer_teleop.runs.results import Recorder


class Checks:
    """A list of checks.

    Attributes:
        results: Dicts with what, measured, low, high, unit, ok.
    """

    def __init__(self):
        self.results = []

    def add(self, label, measured, low, high, unit):
        """Prints and stores one check: low <= measured <= high."""
        passed = bool(low <= measured <= high)
        self.results.append(
            {
                "what": label,
                "measured": round(measured, 5),
                "low": low,
                "high": high,
                "unit": unit,
                "ok": passed,
            }
        )
        print(
            f"demo: {label:<38} {measured:+8.3f} {unit:<5} expected {low:.3f} .. {high:.3f}  "
            f"{'ok' if passed else 'FAILED'}",
            flush=True,
        )

    @property
    def passed(self):
        """Number of checks that passed."""
        return sum(check["ok"] for check in self.results)

    @property
    def all_passed(self):
        """Whether every check passed."""
        return self.passed == len(self.results)


STILL = 0.01  # speed below which the car counts as stopped [m/s]


class DemoError(RuntimeError):
    """The demo cannot continue; the message has the reason."""


class Car:
    """The car behind a window.

    Attributes:
        mouse: Mouse on its widgets.
        recorder: Recorder of the odometry.
    """

    def __init__(self, window, timeout):
        """Records nothing yet; wait_for_car() subscribes.

        Args:
            timeout: Maximum wall time of any wait [s].
        """
        self.window, self._timeout = window, timeout
        self.mouse = Mouse(window)
        self.recorder = Recorder()

    @property
    def last(self):
        """The newest Sample of the odometry, or None."""
        return self.recorder.last

    def wait(self, label, done, seconds=None):
        """Runs Qt's event loop until done() is true.

        Args:
            label: Name of the awaited event in the error message.
            done: Function without arguments.
            seconds: Limit in ROS time [s]; reaching it is not an error. None: no limit.

        Raises:
            DemoError: The window was closed, or `timeout` of wall time has passed.
        """
        start, deadline = rospy.get_time(), time.monotonic() + self._timeout
        while not done():
            if seconds is not None and rospy.get_time() - start >= seconds:
                return
            if not self.window.isVisible() or rospy.is_shutdown():
                raise DemoError(f"interrupted while waiting for {label}")
            if self.window.exitCode:
                raise DemoError(self.window.troubleLabel.text())
            if time.monotonic() > deadline:
                raise DemoError(f"no {label} within {self._timeout:g} s")
            QTest.qWait(5)

    def run_for(self, seconds):
        """Waits for a ROS time [s] to pass."""
        self.wait(f"{seconds:g} s of ROS time (does /clock run?)", lambda: False, seconds)

    def wait_at_rest(self, limit=3.0):
        """Waits, within ROS time, until timed moves are finished and the car is at rest."""
        self.wait("end of the timed move", lambda: not self.window.isMoving())
        self.run_for(0.1)
        self.wait("car at rest", lambda: abs(self.last.v) < STILL, limit)
        return self.last

    def click(self, name):
        """Clicks a button with the mouse; returns the car's state just before."""
        before = self.last
        self.recorder.phase = name
        self.mouse.click(name)
        return before

    def wait_for_car(self):
        """Waits for the first image in the window, for odometry, and until the car is at rest."""
        rospy.Subscriber(ODOMETRY_TOPIC, Odometry, self.recorder.callback, queue_size=100)
        self.recorder.phase = "start"
        self.wait(f"odometry on {ODOMETRY_TOPIC}", lambda: self.last is not None)
        self.wait(f"image on {CAMERA_TOPIC}", lambda: self.window.cameraLabel.pixmap() is not None)
        self.wait(f"car at rest on {ODOMETRY_TOPIC}", lambda: abs(self.last.v) < STILL)
        self.wait(
            "subscriber of the window's commands",
            lambda: self.window.publisher().get_num_connections() > 0,
        )
        self.run_for(0.5)
