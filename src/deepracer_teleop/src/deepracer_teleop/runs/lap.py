"""./run lap: laps by a driver, with their film and result.

The node `lap`: places the car, waits for its laps, records film, path and figures. It does not
drive: a driver on /cmd_vel does. Writes into ~out_dir: lap.mp4, lap.png (a frame of the film),
path.png, path.csv and result.json. Every wait ends: by ROS time and by wall time.
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
from paddock_common.geometry import quaternion_of
from paddock_common.settings import check, number, read, text
from paddock_common.waiting import WaitTimeout, wait_until
from sensor_msgs.msg import Image
from std_srvs.srv import Trigger
from track_model.referee.course import Course
from track_model.track import load_track

from deepracer_teleop.recording import Film
from deepracer_teleop.runs import results
from deepracer_teleop.runs.demo import Judge
from deepracer_teleop.runs.results import Recorder
from paddock_common import nodes
from track_model.msg import LapStatus


@dataclass(frozen=True)
class LapSettings:
    """Parameters of the node beyond ~out_dir and ~track.

    Attributes:
        driver: Name for the overlay and the report.
        model: Name of the car in the simulator.
        starts: Number of starts; with several all are placed at random.
        seed: Of the random places.
        time_limit: Of a lap [s] of ROS time.
        roam: Drive so long instead of a lap [s] of ROS time; 0: a lap.
        patience: Longest wall time without progress [s].
        film_rate: Of the film [Hz].
    """

    driver: str = text("", empty=True)
    model: str = text("racecar")
    starts: int = number(1, min=1, integer=True)
    seed: int = number(0, min=0, integer=True)
    time_limit: float = number(240.0, above=0.0, unit="s")
    roam: float = number(0.0, min=0.0, unit="s")
    patience: float = number(120.0, above=0.0, unit="s")
    film_rate: float = number(15.0, above=0.0, unit="Hz")

    def __post_init__(self):
        check(self)


MOST_PROGRESS = 55.0  # [%] of the lap, up to which a frame may be the picture of the lap


class LapFilm:
    """Adds camera frames to a Film, in the subscriber's thread.

    Args:
        film: Film.
        judge: Judge.
        driver: its name.

    Attributes:
        film: as above.
        seeing: whether a frame has come.
        filming: whether frames are added; False at first.
        frame: (H, W, 3) uint8 BGR, the picture of the lap, or None.
    """

    def __init__(self, film, judge, driver):
        self.film, self._judge, self._driver = film, judge, driver
        self._bridge, self.frame = CvBridge(), None
        self.seeing = self.filming = False

    def callback(self, message):
        """Adds a camera frame."""
        self.seeing = True
        status = self._judge.status
        if not self.filming or status is None:
            return
        words = (
            f"{self._driver}  lap {status.laps + 1}  {status.progress:3.0f} %  "
            f"{status.lap_time:5.1f} s  {status.speed:.2f} m/s"
        )
        try:
            picture = self._bridge.imgmsg_to_cv2(message, "bgr8")
            frame = self.film.add(message.header.stamp.to_sec(), picture, words)
        except (CvBridgeError, OSError) as error:
            rospy.logerr_throttle(10.0, f"film: {error}")
            return
        if frame is not None and (self.frame is None or status.progress < MOST_PROGRESS):
            self.frame = frame


FILES = ("lap.mp4", "lap.png", "path.png", "path.csv")
LEAD = 0.3  # start before the line of a circuit [m]
OPEN_LEAD = 0.15  # start after the line of an open course [m]
PRINT_PERIOD = 5.0  # of ROS time, between lines about the progress [s]


class LapError(RuntimeError):
    """The lap cannot continue; the message says why."""


ERRORS = (LapError, WaitTimeout, rospy.ROSException, rospy.ServiceException, ValueError, OSError)


class LapKeeper:
    """One or several starts on one track."""

    def __init__(self):
        """Reads the parameters and subscribes.

        Raises:
            ValueError, OSError: A parameter, the track or the folder is not good.
        """
        self.out_dir = os.path.abspath(str(rospy.get_param("~out_dir")))
        results.prepare(self.out_dir, FILES)
        self.track = load_track(str(rospy.get_param("~track", "default")))
        self.course = Course(self.track.lane)
        self.settings = read(LapSettings, rospy.get_param)
        self.film = Film(os.path.join(self.out_dir, "lap.mp4"), self.settings.film_rate)
        self.recorder, self.judge = Recorder(), Judge()
        self._camera = LapFilm(self.film, self.judge, self.settings.driver)
        rospy.Subscriber(ODOMETRY_TOPIC, Odometry, self.recorder.callback, queue_size=200)
        rospy.Subscriber("/referee/status", LapStatus, self.judge.callback, queue_size=200)
        rospy.Subscriber(CAMERA_TOPIC, Image, self._camera.callback, queue_size=2, buff_size=2**24)

    def wait(self, what, done):
        """Waits until done() is true.

        Raises:
            WaitTimeout, rospy.ROSInterruptException: As wait_until with ~patience.
        """
        wait_until(done, self.settings.patience, what, poll_period=0.02)

    def place(self, number):
        """Places the car before the line; at random with several starts or from the second on."""
        s = -LEAD if self.track.closed else OPEN_LEAD
        side = turn = 0.0
        if self.settings.starts > 1:
            rng = np.random.default_rng((self.settings.seed, number))
            s += rng.uniform(-0.1, 0.1)
            side, turn = rng.uniform(-0.1, 0.1), math.radians(rng.uniform(-10.0, 10.0))
        x, y, yaw = self.course.pose(s)
        state = ModelState(model_name=self.settings.model, reference_frame="world")
        state.pose.position.x = x - side * math.sin(yaw)
        state.pose.position.y = y + side * math.cos(yaw)
        state.pose.orientation = quaternion_of(yaw + turn)
        answer = rospy.ServiceProxy("/gazebo/set_model_state", SetModelState)(state)
        if not answer.success:
            raise LapError(f"the car cannot be placed: {answer.status_message}")
        self.judge.restart()  # before the referee: its first word after it must not be missed
        rospy.ServiceProxy("/referee/restart", Trigger)()

    def run(self):
        """Does all starts; returns the list of results."""
        self.wait(f"odometry on {ODOMETRY_TOPIC}", lambda: self.recorder.last is not None)
        for name in ("/gazebo/set_model_state", "/referee/restart"):
            rospy.wait_for_service(name, self.settings.patience)
        self.wait("driver on /cmd_vel that moves the car", lambda: abs(self.recorder.last.v) > 0.02)
        self.wait(f"picture on {CAMERA_TOPIC}", lambda: self._camera.seeing)  # the first: seconds
        print(
            f"lap: {self.settings.driver} on track {self.track.name}, {self.track.length:.1f} m"
            + (f", {self.settings.starts} starts" if self.settings.starts > 1 else ""),
            flush=True,
        )
        return [self.one(number) for number in range(self.settings.starts)]

    def one(self, number):
        """Does one start; returns its result."""
        self.place(number)
        self.wait("word of the referee", lambda: self.judge.status is not None)
        begin = self.recorder.last.t
        self._camera.filming = number == 0
        outcome = self._watch(begin)
        self._camera.filming = False
        way = [(sample.x, sample.y) for sample in self.recorder.since(begin)]
        driven = round(float(np.linalg.norm(np.diff(way, axis=0), axis=1).sum()), 2)
        result = {"start": number, "outcome": outcome, **self.judge.result(), "driven": driven}
        print(
            f"lap: start {number}: {outcome}, {result['lap_time']:.2f} s, lateral error mean "
            f"{result['mean_lateral_error'] * 100.0:.1f} cm, max "
            f"{result['max_lateral_error'] * 100.0:.1f} cm",
            flush=True,
        )
        return result

    def _watch(self, begin):
        """Follows one start to its end.

        Args:
            begin: ROS time of the start [s].

        Returns:
            The outcome: "lap", "off track", "stuck" or "time limit"; "roamed".

        Raises:
            LapError: Simulated time stands still, or ROS ends.
        """
        settings = self.settings
        last, since, shown = begin, time.monotonic(), 0.0
        while self.recorder.last.t - begin < (settings.roam or settings.time_limit):
            if rospy.is_shutdown():
                raise LapError("interrupted")
            now = self.recorder.last.t
            if now != last:
                last, since = now, time.monotonic()
            elif time.monotonic() - since > settings.patience:
                raise LapError(f"simulated time has stood still for {settings.patience:g} s")
            status = self.judge.status
            if not settings.roam and status.laps:
                return "lap"
            if not settings.roam and (status.off_track or status.stuck):
                return "off track" if status.off_track else "stuck"
            if settings.starts == 1 and now - shown > PRINT_PERIOD:
                shown = now
                print(
                    f"lap: {now - begin:5.0f} s  {status.progress:3.0f} %  "
                    f"{status.lateral_error * 100.0:+5.1f} cm",
                    flush=True,
                )
            time.sleep(0.02)
        return "roamed" if settings.roam else "time limit"

    def write(self):
        """Writes the path and pictures of all that was driven."""
        self.film.close()
        samples = self.recorder.samples
        self.recorder.write_csv(os.path.join(self.out_dir, "path.csv"))
        names = (f"{self.settings.driver} driver",)
        picture = results.draw(self.track, samples, names=names)
        results.write_picture(self.out_dir, "path.png", picture)
        if self._camera.frame is not None:
            results.write_picture(self.out_dir, "lap.png", self._camera.frame)


def report(keeper, starts, error):
    """Writes result.json and prints the last line.

    Args:
        keeper: LapKeeper.
        starts: Results of the starts that were done.
        error: Why it ended early, or "".

    Returns:
        Whether every start came to its end.
    """
    done = sum(result["outcome"] in ("lap", "roamed") for result in starts)
    passed = not error and done == keeper.settings.starts
    results.write_result(
        keeper.out_dir,
        {
            "ok": passed,
            "error": error,
            "track": keeper.track.name,
            "driver": keeper.settings.driver,
            "film_frames": keeper.film.frames,
            "starts": starts,
        },
    )
    if starts:
        times = [result["lap_time"] for result in starts if result["lap_time"]]
        print(
            f"lap: {keeper.settings.driver} on {keeper.track.name}: {done} of "
            f"{keeper.settings.starts} done"
            + (f", lap {np.mean(times):.2f} s" if times else "")
            + f", lateral error mean {np.mean([r['mean_lateral_error'] for r in starts]):.3f} m,"
            f" max {np.max([r['max_lateral_error'] for r in starts]):.3f} m; files in "
            f"{keeper.out_dir}: {'OK' if passed else 'FAILED'}",
            flush=True,
        )
    return passed


def main():
    """Runs the node; returns its exit code, which result.json repeats."""
    nodes.init_interruptible("lap")
    keeper, starts, error = None, [], ""
    try:
        keeper = LapKeeper()
        starts = keeper.run()
        keeper.write()
    except KeyError as problem:
        error = f"parameter {problem} is missing"
    except ERRORS as problem:
        error = str(problem)
    if error:
        print(f"lap: FAILED: {error}", file=sys.stderr, flush=True)
    if keeper is None:
        return 1
    return 0 if report(keeper, starts, error) else 1


if __name__ == "__main__":
    sys.exit(main())
