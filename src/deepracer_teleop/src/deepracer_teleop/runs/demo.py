"""./run demo: the drive that shows and checks all functions.

The node `demo`: drives with the window's widgets and checks the car's motion. Runs offscreen or on
a screen. All manoeuvres are timed by ROS time; every wait also has a deadline in wall time. Writes
images, path and result.json to ~out_dir.
"""

import math
import os
import sys
import threading
import time

import numpy as np
import rospy
from deepracer_control.drivers.pursuit import Path, Pursuit
from paddock_common.settings import Number, parameter
from track_model.track import load_track

from deepracer_teleop.runs import results
from deepracer_teleop.runs.car import STILL, Car, Checks, DemoError
from deepracer_teleop.runs.results import along
from deepracer_teleop.window.node import connect, send_last


class LapStatusRecorder:
    """Stores LapStatus messages, in a subscriber's thread, up to the finish of a lap."""

    def __init__(self):
        self._lock = threading.Lock()
        self._status, self._errors, self._stale = None, [], False

    @property
    def status(self):
        """The newest LapStatus of this start, or None."""
        return self._status

    def restart(self):
        """Starts again; call it immediately before the referee is restarted."""
        with self._lock:
            self._status, self._errors, self._stale = None, [], True

    def callback(self, status):
        """Stores a LapStatus."""
        with self._lock:
            if self._stale and (status.laps or status.running):
                return  # it was sent before the referee was restarted
            self._stale = False
            if self._status is not None and self._status.laps:
                return  # messages after the finish do not count
            self._status = status
            if status.running:
                self._errors.append(abs(status.lateral_error))

    def result(self):
        """Returns the figures of the start: lap time and penalty [s], lateral errors [m]."""
        with self._lock:
            status, errors = self._status, np.array(self._errors or [0.0])
        return {
            "lap_time": round(status.last_lap_time, 4),
            "penalty": status.penalty,
            "mean_lateral_error": round(float(errors.mean()), 4),
            "max_lateral_error": round(float(errors.max()), 4),
        }


FILES = ("window.png", "camera.png", "birdseye.png", "path.csv")
WHEEL_RADIUS = 0.03  # [m]
REAR_AXLE = -0.081663  # x of the rear axle from base_link [m]
LOOKAHEAD = 0.45  # of the pure pursuit along the track [m]


class Demo:
    """One drive.

    Args:
        out_dir: Existing folder for the results.
        drive_time: ROS time for which to follow the track [s].
    """

    def __init__(self, car: Car, track, out_dir, drive_time):
        self.car, self.track, self.out_dir = car, track, out_dir
        self.drive_time = drive_time
        self.path = Path(track.centreline, closed=track.closed)
        self.pursuit = Pursuit(self.path, LOOKAHEAD)
        self.speed = car.window.settings.default_speed * WHEEL_RADIUS  # commanded [m/s]
        self.checks = Checks()
        self._frame = None

    def drive_buttons(self):
        """Forward, Backwards, Left, Right, and Stop during a move."""
        distance = self.speed * self.car.window.settings.linear_wait
        for name, sign in (("Forward", 1), ("Backwards", -1)):
            start = self.car.click(name)
            driven = along(start, self.car.wait_at_rest())
            low, high = sorted((sign * distance * 0.9, sign * distance * 1.1))
            self.checks.add(f"{name}: distance along the heading", driven, low, high, "m")
        for name, low, high in (("Left", 5.0, 180.0), ("Right", -180.0, -5.0)):
            start = self.car.click(name)
            change = math.degrees(self.car.wait_at_rest().yaw - start.yaw)
            self.checks.add(f"{name}: change of heading", change, low, high, "deg")
        start = self.car.click("Forward")
        self.car.run_for(0.4)
        rolling = self.car.click("Stop")
        end = self.car.wait_at_rest(0.5)
        self.checks.add(
            "Stop: speed when clicked", rolling.v, self.speed * 0.8, self.speed * 1.2, "m/s"
        )
        self.checks.add("Stop: speed 0.5 s later at most", abs(end.v), 0.0, STILL, "m/s")
        self.checks.add(
            "Stop: distance of the stopped move", along(start, end), 0.0, distance * 0.7, "m"
        )

    def drive_cruise(self):
        """Cruise on, slider to both sides, then along the track, then Stop."""
        self.car.recorder.phase = "cruise"
        self.car.mouse.toggle_cruise()
        self.car.run_for(0.5)
        self.checks.add("Cruise: speed", self.car.last.v, self.speed * 0.9, self.speed * 1.1, "m/s")
        self.car.mouse.grab_slider()
        # right first: the Left and Right buttons have brought the car to the lane's left side
        for name, value, low, high in (("right", 15, -90.0, -5.0), ("left", -15, 5.0, 90.0)):
            start = self.car.last
            self.car.mouse.pull_slider(value)
            self.car.run_for(0.5)
            change = math.degrees(self.car.last.yaw - start.yaw)
            self.checks.add(f"Slider {name}: change of heading", change, low, high, "deg")
        self.follow_track()
        self.car.mouse.release_slider()
        self.car.click("Stop")
        self.checks.add(
            "Stop in cruise: speed", abs(self.car.wait_at_rest(0.5).v), 0.0, STILL, "m/s"
        )
        self.car.mouse.toggle_cruise()

    def follow_track(self):
        """Drives along the center line with the slider, steering 10 times a second."""
        initial = self.car.last
        start = self.path.nearest(initial.x, initial.y)
        worst, converged = 0.0, initial.t + 2.0
        next_print = 5.0
        while self.car.last.t - initial.t < self.drive_time:
            car = self.car.last
            self.car.mouse.pull_slider(self.car.mouse.slider_value(self._curvature(car)))
            if car.t > converged:  # the previous turns have moved it off the line
                worst = max(worst, self.path.distance(car.x, car.y))
            if car.t - initial.t > next_print:
                print(
                    f"demo: following the track, {next_print:.0f} of {self.drive_time:g} s",
                    flush=True,
                )
                next_print += 5.0
            if self._frame is None and car.t - initial.t > self.drive_time / 2.0:
                self._frame = self.car.window.lastPicture()
                self.grab_window()
            self.car.run_for(0.1)
        end = self.car.last
        driven = self.path.arc_length(start, self.path.nearest(end.x, end.y))
        distance = self.speed * (end.t - initial.t)
        self.checks.add(
            "Track: distance along the center line", driven, 0.85 * distance, 1.1 * distance, "m"
        )
        self.checks.add("Track: maximum distance from it", worst, 0.0, self.track.width / 2.0, "m")

    def _curvature(self, car):
        """Returns the curvature [1/m] from a Sample of the car to the goal point."""
        x = car.x + REAR_AXLE * math.cos(car.yaw)
        y = car.y + REAR_AXLE * math.sin(car.yaw)
        return self.pursuit.command(x, y, car.yaw)[1]

    def grab_window(self):
        """Writes the window's screenshot."""
        path = os.path.join(self.out_dir, "window.png")
        if not self.car.window.grab().save(path):
            raise DemoError(f"cannot write {path}")

    def write(self):
        """Writes camera frame, bird's-eye view and path."""
        samples = self.car.recorder.samples
        self.car.recorder.write_csv(os.path.join(self.out_dir, "path.csv"))
        results.write_image(self.out_dir, "camera.png", self._frame)
        results.path_figure(self.track, samples).savefig(os.path.join(self.out_dir, "birdseye.png"))

    def run(self):
        """Runs all manoeuvres; returns whether every check passed."""
        self.car.window.start()
        self.car.wait_for_car()
        print(
            f"demo: driving on track {self.track.name}, {self.track.length:.1f} m long", flush=True
        )
        self.drive_buttons()
        self.drive_cruise()
        self.write()
        return self.checks.all_passed


def demo_from_parameters(window, out_dir):
    """Returns a Demo with the node's private parameters.

    Raises:
        ValueError: A parameter or the track is not valid; the message has its name.
    """
    seconds = Number(above=0.0, unit="s")
    return Demo(
        Car(window, parameter(rospy.get_param, "patience", 60.0, seconds)),
        load_track(rospy.get_param("~track", "default")),
        out_dir,
        parameter(rospy.get_param, "drive_time", 30.0, seconds),
    )


def report(out_dir, passed, error, checks: Checks, seconds):
    """Writes result.json and prints the last line.

    Args:
        passed: Whether all manoeuvres ran and every check passed.
        error: Why it stopped early, or "".
        seconds: Wall time of the demo [s].
    """
    result = {"ok": passed, "error": error, "checks": checks.results}
    results.write_result(out_dir, {**result, "wall_seconds": round(seconds, 1)})
    print(
        f"demo: {checks.passed} of {len(checks.results)} checks passed, files in {out_dir}: "
        f"{'OK' if passed else 'FAILED'}",
        flush=True,
    )


def main():
    """Runs the node `demo`; returns its exit code, which result.json repeats."""
    os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
    start = time.monotonic()
    window, demo, error, out_dir = None, None, "", None
    try:
        window = connect("demo")
        out_dir = os.path.abspath(rospy.get_param("~out_dir", "out"))
        results.prepare(out_dir, FILES)
        demo = demo_from_parameters(window, out_dir)
        passed = demo.run()
    except (DemoError, OSError, ValueError) as problem:
        passed, error = False, str(problem)
        print(f"demo: FAILED: {error}", file=sys.stderr, flush=True)
    finally:
        if window is not None:
            window.close()  # sends one zero
            window.finish()
            send_last(window)
    if out_dir is not None:
        checks = demo.checks if demo else Checks()
        report(out_dir, passed, error, checks, time.monotonic() - start)
    return 0 if passed else 1


if __name__ == "__main__":
    sys.exit(main())
