"""./run lap: laps of a driver, with film and result.

The node `lap`: puts the car at the start, waits for its laps, records film, path and figures. It
does not drive: a driver on /cmd_vel does. Writes to ~out_dir: lap.mp4, lap.png (a frame of it),
path.png, path.csv and result.json. Every wait has a limit in ROS time or wall time.
"""

import math
import os
import sys
import time
from dataclasses import dataclass

import numpy as np
import rospy
from cv_bridge import CvBridge, CvBridgeError
from deepracer_control.topics import CAMERA_TOPIC, ODOMETRY_TOPIC
from gazebo_msgs.msg import ModelState
from gazebo_msgs.srv import SetModelState
from nav_msgs.msg import Odometry
from paddock_common.geometry import pose_of
from paddock_common.settings import Checked, number, read, text
from paddock_common.waiting import WaitTimeout, wait_until
from sensor_msgs.msg import Image
from std_srvs.srv import Trigger
from track_model.referee.course import Course, standing_start
from track_model.track import load_track

from deepracer_teleop.recording import Film
from deepracer_teleop.runs import results
from deepracer_teleop.runs.demo import LapStatusRecorder
from deepracer_teleop.runs.results import Recorder
from paddock_common import nodes
from track_model.msg import LapStatus


@dataclass(frozen=True)
class LapSettings(Checked):
    """Parameters of the node beyond ~out_dir and ~track.

    Attributes:
        driver: Name for the overlay and the report.
        model: Name of the car in the simulator.
        starts: Number of starts; with several all poses are random.
        seed: Seed of the random poses.
        time_limit: Limit of a lap in ROS time [s].
        roam: ROS time to drive instead of a lap [s]; 0: a lap.
        timeout: Maximum wall time without progress [s]; parameter ~patience.
        film_rate: Frame rate of the film [Hz].
    """

    driver: str = text("", empty=True)
    model: str = text("racecar")
    starts: int = number(1, min=1, integer=True)
    seed: int = number(0, min=0, integer=True)
    time_limit: float = number(240.0, above=0.0, unit="s")
    roam: float = number(0.0, min=0.0, unit="s")
    timeout: float = number(120.0, "patience", above=0.0, unit="s")
    film_rate: float = number(15.0, above=0.0, unit="Hz")


MAX_PROGRESS = 55.0  # of the lap, up to which a frame may become lap.png [%]


class LapFilm:
    """Adds camera frames to a Film, in the subscriber's thread.

    Attributes:
        film: as above.
        receiving: whether a frame was received.
        recording: whether frames are added; False at first.
        frame: (H, W, 3) uint8 BGR, the frame for lap.png, or None.
    """

    def __init__(self, film: Film, referee: LapStatusRecorder, driver):
        self.film, self._referee, self._driver = film, referee, driver
        self._bridge, self.frame = CvBridge(), None
        self.receiving = self.recording = False

    def callback(self, message):
        """Adds a camera frame."""
        self.receiving = True
        status = self._referee.status
        if not self.recording or status is None:
            return
        text_line = (
            f"{self._driver}  lap {status.laps + 1}  {status.progress:3.0f} %  "
            f"{status.lap_time:5.1f} s  {status.speed:.2f} m/s"
        )
        try:
            image = self._bridge.imgmsg_to_cv2(message, "bgr8")
            frame = self.film.add(message.header.stamp.to_sec(), image, text_line)
        except (CvBridgeError, OSError) as error:
            rospy.logerr_throttle(10.0, f"film: {error}")
            return
        if frame is not None and (self.frame is None or status.progress < MAX_PROGRESS):
            self.frame = frame


FILES = ("lap.mp4", "lap.png", "path.png", "path.csv")
PRINT_PERIOD = 5.0  # of ROS time, between lines about the progress [s]


class LapError(RuntimeError):
    """The lap cannot continue; the message has the reason."""


ERRORS = (LapError, WaitTimeout, rospy.ROSException, rospy.ServiceException, ValueError, OSError)


class LapRun:
    """One or several starts on one track.

    Raises:
        ValueError, OSError: A parameter, the track or the folder is not valid.
    """

    def __init__(self):
        self.out_dir = os.path.abspath(str(rospy.get_param("~out_dir")))
        results.prepare(self.out_dir, FILES)
        self.track = load_track(str(rospy.get_param("~track", "default")))
        self.course = Course(self.track.lane)
        self.settings = read(LapSettings, rospy.get_param)
        self.film = Film(os.path.join(self.out_dir, "lap.mp4"), self.settings.film_rate)
        self.recorder, self.referee = Recorder(), LapStatusRecorder()
        self._camera = LapFilm(self.film, self.referee, self.settings.driver)
        rospy.Subscriber(ODOMETRY_TOPIC, Odometry, self.recorder.callback, queue_size=200)
        rospy.Subscriber("/referee/status", LapStatus, self.referee.callback, queue_size=200)
        rospy.Subscriber(CAMERA_TOPIC, Image, self._camera.callback, queue_size=2, buff_size=2**24)

    def wait(self, label, done):
        """Waits until done() is true.

        Raises:
            WaitTimeout, rospy.ROSInterruptException: As wait_until with ~patience.
        """
        wait_until(done, self.settings.timeout, label, poll_period=0.02)

    def put_at_start(self, index):
        """Puts the car before the line; with several starts at a random pose."""
        s = standing_start(self.course)
        side = rotation = 0.0
        if self.settings.starts > 1:
            rng = np.random.default_rng((self.settings.seed, index))
            s += rng.uniform(-0.1, 0.1)
            side, rotation = rng.uniform(-0.1, 0.1), math.radians(rng.uniform(-10.0, 10.0))
        pose = pose_of(*self.course.pose(s, side, rotation))
        state = ModelState(model_name=self.settings.model, pose=pose, reference_frame="world")
        response = rospy.ServiceProxy("/gazebo/set_model_state", SetModelState)(state)
        if not response.success:
            raise LapError(f"the car cannot be put at the start: {response.status_message}")
        self.referee.restart()  # before the referee: its first message must not be missed
        rospy.ServiceProxy("/referee/restart", Trigger)()

    def run(self):
        """Runs all starts; returns the list of results."""
        self.wait(f"odometry on {ODOMETRY_TOPIC}", lambda: self.recorder.last is not None)
        for name in ("/gazebo/set_model_state", "/referee/restart"):
            rospy.wait_for_service(name, self.settings.timeout)
        self.wait("driver on /cmd_vel that moves the car", lambda: abs(self.recorder.last.v) > 0.02)
        self.wait(
            f"image on {CAMERA_TOPIC}", lambda: self._camera.receiving
        )  # the first takes seconds
        print(
            f"lap: {self.settings.driver} on track {self.track.name}, {self.track.length:.1f} m"
            + (f", {self.settings.starts} starts" if self.settings.starts > 1 else ""),
            flush=True,
        )
        return [self.run_start(index) for index in range(self.settings.starts)]

    def run_start(self, index):
        """Runs one start; returns its result."""
        self.put_at_start(index)
        self.wait("message of the referee", lambda: self.referee.status is not None)
        start = self.recorder.last.t
        self._camera.recording = index == 0
        outcome = self._monitor(start)
        self._camera.recording = False
        path = [(sample.x, sample.y) for sample in self.recorder.since(start)]
        driven = round(float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum()), 2)
        result = {"start": index, "outcome": outcome, **self.referee.result(), "driven": driven}
        print(
            f"lap: start {index}: {outcome}, {result['lap_time']:.2f} s, lateral error mean "
            f"{result['mean_lateral_error'] * 100.0:.1f} cm, max "
            f"{result['max_lateral_error'] * 100.0:.1f} cm",
            flush=True,
        )
        return result

    def _monitor(self, start):
        """Monitors one start until its outcome.

        Args:
            start: ROS time of the start [s].

        Returns:
            The outcome: "lap", "off track", "stuck" or "time limit"; "roamed".

        Raises:
            LapError: Simulated time does not advance, or ROS shuts down.
        """
        settings = self.settings
        last, since, printed = start, time.monotonic(), 0.0
        while self.recorder.last.t - start < (settings.roam or settings.time_limit):
            if rospy.is_shutdown():
                raise LapError("interrupted")
            now = self.recorder.last.t
            if now != last:
                last, since = now, time.monotonic()
            elif time.monotonic() - since > settings.timeout:
                raise LapError(f"simulated time has not advanced for {settings.timeout:g} s")
            status = self.referee.status
            if not settings.roam and status.laps:
                return "lap"
            if not settings.roam and (status.off_track or status.stuck):
                return "off track" if status.off_track else "stuck"
            if settings.starts == 1 and now - printed > PRINT_PERIOD:
                printed = now
                print(
                    f"lap: {now - start:5.0f} s  {status.progress:3.0f} %  "
                    f"{status.lateral_error * 100.0:+5.1f} cm",
                    flush=True,
                )
            time.sleep(0.02)
        return "roamed" if settings.roam else "time limit"

    def write(self):
        """Writes path and images of all starts."""
        self.film.close()
        samples = self.recorder.samples
        self.recorder.write_csv(os.path.join(self.out_dir, "path.csv"))
        names = (f"{self.settings.driver} driver",)
        figure = results.path_figure(self.track, samples, names)
        figure.savefig(os.path.join(self.out_dir, "path.png"))
        if self._camera.frame is not None:
            results.write_image(self.out_dir, "lap.png", self._camera.frame)


def report(run: LapRun, starts, error):
    """Writes result.json and prints the last line.

    Args:
        error: Why it stopped early, or "".

    Returns:
        Whether every start was completed.
    """
    done = sum(result["outcome"] in ("lap", "roamed") for result in starts)
    passed = not error and done == run.settings.starts
    results.write_result(
        run.out_dir,
        {
            "ok": passed,
            "error": error,
            "track": run.track.name,
            "driver": run.settings.driver,
            "film_frames": run.film.frames,
            "starts": starts,
        },
    )
    if starts:
        times = [result["lap_time"] for result in starts if result["lap_time"]]
        print(
            f"lap: {run.settings.driver} on {run.track.name}: {done} of "
            f"{run.settings.starts} done"
            + (f", lap {np.mean(times):.2f} s" if times else "")
            + f", lateral error mean {np.mean([r['mean_lateral_error'] for r in starts]):.3f} m,"
            f" max {np.max([r['max_lateral_error'] for r in starts]):.3f} m; files in "
            f"{run.out_dir}: {'OK' if passed else 'FAILED'}",
            flush=True,
        )
    return passed


def main():
    """Runs the node; returns its exit code, which result.json repeats."""
    nodes.init_interruptible("lap")
    run, starts, error = None, [], ""
    try:
        run = LapRun()
        starts = run.run()
        run.write()
    except KeyError as problem:
        error = f"parameter {problem} is missing"
    except ERRORS as problem:
        error = str(problem)
    if error:
        print(f"lap: FAILED: {error}", file=sys.stderr, flush=True)
    if run is None:
        return 1
    return 0 if report(run, starts, error) else 1


if __name__ == "__main__":
    sys.exit(main())
