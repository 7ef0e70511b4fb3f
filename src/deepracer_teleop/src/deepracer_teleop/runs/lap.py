"""The node `lap`: places the car, waits for its laps, records film, path and figures.

It does not drive: a driver on /cmd_vel does. Writes into ~out_dir: lap.mp4, lap.png (a frame of
the film), path.png, path.csv and result.json. Every wait ends: by ROS time and by wall time.
"""

import csv
import json
import math
import os
import sys
import threading
import time

import cv2
import numpy as np
import rospy
from cv_bridge import CvBridge
from deepracer_control.topics import CAMERA_TOPIC, ODOMETRY_TOPIC
from gazebo_msgs.msg import ModelState
from gazebo_msgs.srv import SetModelState
from nav_msgs.msg import Odometry
from sensor_msgs.msg import Image
from std_srvs.srv import Trigger
from track_model.referee.course import Course
from track_model.track import load_track

from deepracer_teleop.runs import birdseye
from deepracer_teleop.runs.film import Film
from deepracer_teleop.runs.recorder import Recorder
from track_model.msg import LapStatus

FILES = ("lap.mp4", "lap.png", "path.png", "path.csv", "result.json")
LEAD = 0.3  # start before the line of a circuit [m]
OPEN_LEAD = 0.15  # start after the line of an open course [m]


class LapError(RuntimeError):
    """The lap cannot continue; the message says why."""


class LapKeeper:
    """One or several starts on one track."""

    def __init__(self):
        """Reads the parameters and subscribes.

        Raises:
            ValueError, OSError: A parameter, the track or the folder is not good.
        """
        get = rospy.get_param
        self.out_dir = os.path.abspath(str(get("~out_dir")))
        os.makedirs(self.out_dir, exist_ok=True)
        for name in FILES:
            if os.path.exists(os.path.join(self.out_dir, name)):
                os.remove(os.path.join(self.out_dir, name))
        self.track = load_track(str(get("~track", "default")))
        self.course = Course(self.track.lane)
        self.driver = str(get("~driver", ""))
        self.starts, self.seed = int(get("~starts", 1)), int(get("~seed", 0))
        self.limit = float(get("~time_limit", 240.0))  # of a lap [s] of ROS time
        self.roam = float(get("~roam", 0.0))  # [s] of ROS time; 0: a lap
        self.patience = float(get("~patience", 120.0))  # without progress of time [s]
        if self.starts < 1 or not self.limit > 0.0:
            raise ValueError(
                f"~starts is {self.starts}, ~time_limit {self.limit}; both must be above 0"
            )
        self.film = Film(os.path.join(self.out_dir, "lap.mp4"), float(get("~film_rate", 15.0)))
        self.recorder = Recorder()
        self._bridge, self._lock = CvBridge(), threading.Lock()
        self._status, self._errors, self._frame = None, [], None
        self._filming = self._stale = False
        rospy.Subscriber(ODOMETRY_TOPIC, Odometry, self.recorder.callback, queue_size=200)
        rospy.Subscriber("/referee/status", LapStatus, self._judge, queue_size=200)
        rospy.Subscriber(CAMERA_TOPIC, Image, self._on_picture, queue_size=2, buff_size=2**24)

    # Subscribers' threads
    def _judge(self, status):
        with self._lock:
            if self._stale and (status.laps or status.running):
                return  # it was sent before the referee was restarted
            self._stale = False
            if self._status is not None and self._status.laps:
                return  # what comes after the finish does not count
            self._status = status
            if status.running:
                self._errors.append(abs(status.lateral_error))

    def _on_picture(self, message):
        status = self._status
        if not self._filming or status is None:
            return
        picture = self._bridge.imgmsg_to_cv2(message, "bgr8")
        words = (
            f"{self.driver}  lap {status.laps + 1}  {status.progress:3.0f} %  "
            f"{status.lap_time:5.1f} s  {status.speed:.2f} m/s"
        )
        frame = self.film.add(message.header.stamp.to_sec(), picture, words)
        if frame is not None and (self._frame is None or status.progress < 55.0):
            self._frame = frame

    # Main thread
    def wait(self, what, done):
        """Waits until done() is true.

        Raises:
            LapError: It takes longer than ~patience of wall time, or ROS ends.
        """
        deadline = time.monotonic() + self.patience
        while not done():
            if rospy.is_shutdown():
                raise LapError(f"interrupted while waiting for {what}")
            if time.monotonic() > deadline:
                raise LapError(f"no {what} within {self.patience:g} s")
            time.sleep(0.02)

    def place(self, number):
        """Places the car before the line; at random with several starts or from the second on."""
        s = -LEAD if self.track.closed else OPEN_LEAD
        side = turn = 0.0
        if self.starts > 1:
            rng = np.random.default_rng((self.seed, number))
            s += rng.uniform(-0.1, 0.1)
            side, turn = rng.uniform(-0.1, 0.1), math.radians(rng.uniform(-10.0, 10.0))
        x, y, yaw = self.course.pose(s)
        state = ModelState(
            model_name=str(rospy.get_param("~model", "racecar")), reference_frame="world"
        )
        state.pose.position.x = x - side * math.sin(yaw)
        state.pose.position.y = y + side * math.cos(yaw)
        state.pose.orientation.z = math.sin((yaw + turn) / 2.0)
        state.pose.orientation.w = math.cos((yaw + turn) / 2.0)
        answer = rospy.ServiceProxy("/gazebo/set_model_state", SetModelState)(state)
        if not answer.success:
            raise LapError(f"the car cannot be placed: {answer.status_message}")
        rospy.ServiceProxy("/referee/restart", Trigger)()
        with self._lock:
            self._status, self._errors, self._stale = None, [], True

    def run(self):
        """Does all starts; returns the list of results."""
        self.wait(f"odometry on {ODOMETRY_TOPIC}", lambda: self.recorder.last is not None)
        for name, _kind in (
            ("/gazebo/set_model_state", SetModelState),
            ("/referee/restart", Trigger),
        ):
            rospy.wait_for_service(name, self.patience)
        self.wait("driver on /cmd_vel that moves the car", lambda: abs(self.recorder.last.v) > 0.02)
        print(
            f"lap: {self.driver} on track {self.track.name}, {self.track.length:.1f} m"
            + (f", {self.starts} starts" if self.starts > 1 else ""),
            flush=True,
        )
        return [self.one(number) for number in range(self.starts)]

    def one(self, number):
        """Does one start; returns its result."""
        self.place(number)
        self.wait("word of the referee", lambda: self._status is not None)
        begin = self.recorder.last.t
        self._filming = number == 0
        outcome, shown = "time limit", 0.0
        last, since = begin, time.monotonic()
        while self.recorder.last.t - begin < (self.roam or self.limit):
            if rospy.is_shutdown():
                raise LapError("interrupted")
            now = self.recorder.last.t
            if now != last:
                last, since = now, time.monotonic()
            elif time.monotonic() - since > self.patience:
                raise LapError(f"simulated time has stood still for {self.patience:g} s")
            status = self._status
            if not self.roam and status.laps:
                outcome = "lap"
                break
            if not self.roam and (status.off_track or status.stuck):
                outcome = "off track" if status.off_track else "stuck"
                break
            if self.starts == 1 and now - shown > 5.0:
                shown = now
                print(
                    f"lap: {now - begin:5.0f} s  {status.progress:3.0f} %  "
                    f"{status.lateral_error * 100.0:+5.1f} cm",
                    flush=True,
                )
            time.sleep(0.02)
        self._filming = False
        if self.roam:
            outcome = "roamed"
        with self._lock:
            status, errors = self._status, np.array(self._errors or [0.0])
        way = [(sample.x, sample.y) for sample in self.recorder.since(begin)]
        result = {
            "start": number,
            "outcome": outcome,
            "lap_time": round(status.last_lap_time, 4),
            "penalty": status.penalty,
            "mean_lateral_error": round(float(errors.mean()), 4),
            "max_lateral_error": round(float(errors.max()), 4),
            "driven": round(float(np.linalg.norm(np.diff(way, axis=0), axis=1).sum()), 2),
        }
        print(
            f"lap: start {number}: {outcome}, {result['lap_time']:.2f} s, lateral error mean "
            f"{result['mean_lateral_error'] * 100.0:.1f} cm, max "
            f"{result['max_lateral_error'] * 100.0:.1f} cm",
            flush=True,
        )
        return result

    def write(self):
        """Writes the path and pictures of all that was driven."""
        self.film.close()
        with open(
            os.path.join(self.out_dir, "path.csv"), "w", newline="", encoding="ascii"
        ) as stream:
            writer = csv.writer(stream)
            writer.writerow(["t", "x", "y", "yaw", "v"])
            writer.writerows(
                [f"{value:.6f}" for value in (s.t, s.x, s.y, s.yaw, s.v)]
                for s in self.recorder.samples
            )
        pictures = [
            (
                "path.png",
                birdseye.draw(self.track, self.recorder.samples, names=(f"{self.driver} driver",)),
            )
        ]
        if self._frame is not None:
            pictures.append(("lap.png", self._frame))
        for name, picture in pictures:
            if not cv2.imwrite(os.path.join(self.out_dir, name), picture):
                raise LapError(f"cannot write {name} into {self.out_dir}")


def main():
    """Runs the node; returns its exit code, which result.json repeats."""
    rospy.init_node("lap")
    keeper, results, error = None, [], ""
    try:
        keeper = LapKeeper()
        results = keeper.run()
        keeper.write()
    except (
        LapError,
        rospy.ROSException,
        rospy.ServiceException,
        ValueError,
        OSError,
        KeyError,
    ) as problem:
        error = f"parameter {problem} is missing" if isinstance(problem, KeyError) else str(problem)
        print(f"lap: FAILED: {error}", file=sys.stderr, flush=True)
    if keeper is None:
        return 1
    done = sum(result["outcome"] in ("lap", "roamed") for result in results)
    passed = not error and done == keeper.starts
    with open(os.path.join(keeper.out_dir, "result.json"), "w", encoding="utf-8") as stream:
        json.dump(
            {
                "ok": passed,
                "error": error,
                "track": keeper.track.name,
                "driver": keeper.driver,
                "film_frames": keeper.film.frames,
                "starts": results,
            },
            stream,
            indent=2,
        )
        stream.write("\n")
    if results:
        times = [result["lap_time"] for result in results if result["lap_time"]]
        print(
            f"lap: {keeper.driver} on {keeper.track.name}: {done} of {keeper.starts} done"
            + (f", lap {np.mean(times):.2f} s" if times else "")
            + f", lateral error mean {np.mean([r['mean_lateral_error'] for r in results]):.3f} m,"
            f" max {np.max([r['max_lateral_error'] for r in results]):.3f} m; files in "
            f"{keeper.out_dir}: {'OK' if passed else 'FAILED'}",
            flush=True,
        )
    return 0 if passed else 1


if __name__ == "__main__":
    sys.exit(main())
