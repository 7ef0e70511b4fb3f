"""The node `demo`: drives with the window's widgets and checks the car's motion.

Runs offscreen or on a screen. All manoeuvres are timed by ROS time; every wait also has a deadline
in wall time. Writes pictures, path and result.json into ~out_dir.
"""

import json
import math
import os
import sys
import time

import cv2
import rospy
from deepracer_control.topics import CAMERA_TOPIC, ODOMETRY_TOPIC
from nav_msgs.msg import Odometry
from PyQt5.QtTest import QTest
from track_model.track import load_track

from deepracer_teleop.drivers.mouse import Mouse
from deepracer_teleop.runs import birdseye
from deepracer_teleop.runs.recorder import Pursuit, Recorder, along
from deepracer_teleop.window.window import connect

FILES = ("window.png", "camera.png", "birdseye.png", "path.csv", "result.json")
WHEEL_RADIUS = 0.03  # [m]
REAR_AXLE = -0.081663  # x of the rear axle from base_link [m]
STILL = 0.01  # speed below which the car counts as stopped [m/s]


class DemoError(RuntimeError):
    """The demo cannot continue; the message says why."""


class Demo:
    """One drive."""

    def __init__(self, window, track, out_dir, drive_time, patience):
        """Subscribes to the odometry.

        Args:
            window: InterfaceWindow.
            track: track_model.track.Track.
            out_dir: Existing folder for the results.
            drive_time: How long to follow the track [s] of ROS time.
            patience: Longest wall time of any wait [s].
        """
        self.window, self.track, self.out_dir = window, track, out_dir
        self.drive_time, self.patience = drive_time, patience
        self.mouse = Mouse(window)
        self.recorder = Recorder()
        self.pursuit = Pursuit(track.centreline)
        self.speed = window.settings.default_speed * WHEEL_RADIUS  # commanded [m/s]
        self.checks = []
        self._frame = None

    # Waiting
    def wait(self, what, done, seconds=None):
        """Runs Qt's event loop until done() is true.

        Args:
            what: Awaited event, for the error.
            done: Function without arguments.
            seconds: Limit in ROS time [s]; reaching it is no error. None: only done() ends it.

        Raises:
            DemoError: The window was closed, or `patience` of wall time has passed.
        """
        begin, deadline = rospy.get_time(), time.monotonic() + self.patience
        while not done():
            if seconds is not None and rospy.get_time() - begin >= seconds:
                return
            if not self.window.isVisible() or rospy.is_shutdown():
                raise DemoError(f"interrupted while waiting for {what}")
            if self.window.exitCode:
                raise DemoError(self.window.troubleLabel.text())
            if time.monotonic() > deadline:
                raise DemoError(f"no {what} within {self.patience:g} s")
            QTest.qWait(5)

    def run_for(self, seconds):
        """Waits for a ROS time [s] to pass."""
        self.wait(f"{seconds:g} s of ROS time (does /clock run?)", lambda: False, seconds)

    def settle(self, limit=3.0):
        """Waits, within ROS time, until timed moves are over and the car has stopped."""
        self.wait("end of the timed move", lambda: not self.window.isMoving())
        self.run_for(0.1)
        self.wait("standing car", lambda: abs(self.recorder.last.v) < STILL, limit)
        return self.recorder.last

    def click(self, name):
        """Clicks a button with the mouse; returns the car's state just before."""
        before = self.recorder.last
        self.recorder.phase = name
        self.mouse.click(name)
        return before

    # Checks
    def check(self, what, measured, low, high, unit):
        """Prints and stores one check: low <= measured <= high."""
        passed = bool(low <= measured <= high)
        self.checks.append(
            {
                "what": what,
                "measured": round(measured, 5),
                "low": low,
                "high": high,
                "unit": unit,
                "ok": passed,
            }
        )
        ends = [
            "-inf" if low == -math.inf else f"{low:.3f}",
            f"{high:.3f}" if high < math.inf else "inf",
        ]
        print(
            f"demo: {what:<38} {measured:+8.3f} {unit:<5} expected {ends[0]} .. {ends[1]}  "
            f"{'ok' if passed else 'FAILED'}",
            flush=True,
        )

    # Manoeuvres
    def wait_for_car(self):
        """Waits for the first picture in the window, for odometry, and until the car stands."""
        rospy.Subscriber(ODOMETRY_TOPIC, Odometry, self.recorder.callback, queue_size=100)
        self.recorder.phase = "start"
        self.wait(f"odometry on {ODOMETRY_TOPIC}", lambda: self.recorder.last is not None)
        self.wait(
            f"picture on {CAMERA_TOPIC}", lambda: self.window.cameraLabel.pixmap() is not None
        )
        self.wait(
            f"car on {ODOMETRY_TOPIC} that stands still", lambda: abs(self.recorder.last.v) < STILL
        )
        self.wait(
            "subscriber of the window's commands",
            lambda: self.window.publisher().get_num_connections() > 0,
        )
        self.run_for(0.5)

    def drive_buttons(self):
        """Forward, Backwards, Left, Right, and Stop during a move."""
        way = self.speed * self.window.settings.linear_wait
        for name, sign in (("Forward", 1), ("Backwards", -1)):
            start = self.click(name)
            distance = along(start, self.settle())
            low, high = sorted((sign * way * 0.9, sign * way * 1.1))
            self.check(f"{name}: way along the heading", distance, low, high, "m")
        for name, low, high in (("Left", 5.0, 180.0), ("Right", -180.0, -5.0)):
            start = self.click(name)
            turned = math.degrees(self.settle().yaw - start.yaw)
            self.check(f"{name}: change of heading", turned, low, high, "deg")
        start = self.click("Forward")
        self.run_for(0.4)
        rolling = self.click("Stop")
        end = self.settle(0.5)
        self.check("Stop: speed when clicked", rolling.v, self.speed * 0.8, self.speed * 1.2, "m/s")
        self.check("Stop: speed 0.5 s later at most", abs(end.v), 0.0, STILL, "m/s")
        self.check("Stop: way of the cut move", along(start, end), 0.0, way * 0.7, "m")

    def drive_cruise(self):
        """Cruise on, slider to both sides, then along the track, then Stop."""
        self.recorder.phase = "cruise"
        self.mouse.toggle_cruise()
        self.run_for(0.5)
        self.check("Cruise: speed", self.recorder.last.v, self.speed * 0.9, self.speed * 1.1, "m/s")
        self.mouse.grab_slider()
        # right first: the Left and Right buttons have brought the car to the lane's left side
        for name, value, low, high in (("right", 15, -90.0, -5.0), ("left", -15, 5.0, 90.0)):
            start = self.recorder.last
            self.mouse.pull_slider(value)
            self.run_for(0.5)
            turned = math.degrees(self.recorder.last.yaw - start.yaw)
            self.check(f"Slider {name}: change of heading", turned, low, high, "deg")
        self.follow_track()
        self.mouse.release_slider()
        self.click("Stop")
        self.check("Stop in cruise: speed", abs(self.settle(0.5).v), 0.0, STILL, "m/s")
        self.mouse.toggle_cruise()

    def follow_track(self):
        """Drives along the centre line with the slider, steering 10 times a second."""
        begin = self.recorder.last
        start, _ = self.pursuit.nearest(begin.x, begin.y)
        worst, settled = 0.0, begin.t + 2.0
        next_print = 5.0
        while self.recorder.last.t - begin.t < self.drive_time:
            car = self.recorder.last
            curvature = self.pursuit.curvature(
                car.x + REAR_AXLE * math.cos(car.yaw),
                car.y + REAR_AXLE * math.sin(car.yaw),
                car.yaw,
            )
            self.mouse.pull_slider(self.mouse.slider_value(curvature))
            if car.t > settled:  # it starts beside the line after the turns before
                worst = max(worst, self.pursuit.nearest(car.x, car.y)[1])
            if car.t - begin.t > next_print:
                print(
                    f"demo: following the track, {next_print:.0f} of {self.drive_time:g} s",
                    flush=True,
                )
                next_print += 5.0
            if self._frame is None and car.t - begin.t > self.drive_time / 2.0:
                self._frame = self.window.lastPicture()
                self.grab_window()
            self.run_for(0.1)
        end = self.recorder.last
        finish, _ = self.pursuit.nearest(end.x, end.y)
        way = self.speed * (end.t - begin.t)
        self.check(
            "Track: way along the centre line",
            self.pursuit.progress(start, finish),
            0.85 * way,
            1.1 * way,
            "m",
        )
        self.check("Track: largest distance from it", worst, 0.0, self.track.width / 2.0, "m")

    # Results
    def grab_window(self):
        """Writes the window's screenshot."""
        path = os.path.join(self.out_dir, "window.png")
        if not self.window.grab().save(path):
            raise DemoError(f"cannot write {path}")

    def write(self):
        """Writes camera frame, bird's-eye picture and path."""
        self.recorder.write_csv(os.path.join(self.out_dir, "path.csv"))
        for name, picture in (
            ("camera.png", self._frame),
            ("birdseye.png", birdseye.draw(self.track, self.recorder.samples)),
        ):
            path = os.path.join(self.out_dir, name)
            if picture is None or not cv2.imwrite(path, picture):
                raise DemoError(f"cannot write {path}")

    def run(self):
        """Runs all manoeuvres; returns whether every check passed."""
        self.window.start()
        self.wait_for_car()
        print(
            f"demo: driving on track {self.track.name}, {self.track.length:.1f} m round", flush=True
        )
        self.drive_buttons()
        self.drive_cruise()
        self.write()
        return all(check["ok"] for check in self.checks)


def clean(out_dir):
    """Makes the folder and removes the results of an earlier run."""
    os.makedirs(out_dir, exist_ok=True)
    for name in FILES:
        if os.path.exists(os.path.join(out_dir, name)):
            os.remove(os.path.join(out_dir, name))


def main():
    """Runs the node `demo`; returns its exit code, which result.json repeats."""
    os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
    begin = time.monotonic()
    window, demo, error, out_dir = None, None, "", None
    try:
        window = connect("demo")
        out_dir = os.path.abspath(rospy.get_param("~out_dir", "out"))
        clean(out_dir)
        demo = Demo(
            window,
            load_track(rospy.get_param("~track", "default")),
            out_dir,
            float(rospy.get_param("~drive_time", 30.0)),
            float(rospy.get_param("~patience", 60.0)),
        )
        passed = demo.run()
    except (DemoError, OSError, ValueError) as problem:
        passed, error = False, str(problem)
        print(f"demo: FAILED: {error}", file=sys.stderr, flush=True)
    finally:
        if window is not None:
            window.close()  # sends one zero
            window.finish()
    if out_dir is not None:
        result = {
            "ok": passed,
            "error": error,
            "checks": demo.checks if demo else [],
            "wall_seconds": round(time.monotonic() - begin, 1),
        }
        with open(os.path.join(out_dir, "result.json"), "w", encoding="utf-8") as stream:
            json.dump(result, stream, indent=2)
            stream.write("\n")
        good = sum(check["ok"] for check in result["checks"])
        print(
            f"demo: {good} of {len(result['checks'])} checks passed, files in {out_dir}: "
            f"{'OK' if passed else 'FAILED'}",
            flush=True,
        )
    time.sleep(0.1)
    return 0 if passed else 1


if __name__ == "__main__":
    sys.exit(main())
