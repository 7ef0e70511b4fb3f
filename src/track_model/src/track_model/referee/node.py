"""The referee's node: its topics, display and log."""

from __future__ import annotations

import contextlib
import csv
import math
import os
import threading
from collections.abc import Callable
from typing import Any, TextIO, Tuple

import rospy
from gazebo_msgs.msg import ModelState
from gazebo_msgs.srv import GetWorldProperties, SetModelState
from geometry_msgs.msg import Point, PoseStamped
from nav_msgs.msg import Odometry, Path
from paddock_common.geometry import planar_of, pose_of
from paddock_common.nodes import run
from paddock_common.settings import read
from shapely.geometry import Polygon
from std_msgs.msg import Header
from std_srvs.srv import Trigger, TriggerRequest, TriggerResponse
from visualization_msgs.msg import Marker

from track_model.files import writer as files
from track_model.geometry import Lane
from track_model.msg import LapStatus
from track_model.referee.course import Course
from track_model.referee.referee import Car, Referee, Rules, Status, wall_polygons
from track_model.track import load_track

SPACING = 0.05  # of the driven path's poses [m]
MAX_POSES = 4000  # of the driven path
Pose = Tuple[float, float, float]  # x, y [m], yaw [rad]
RATE = 5.0  # of path and text [Hz] of simulated time


def lane_marker(lane: Lane, frame: str) -> Marker:
    """Return the lane's surface as visualization_msgs/Marker: triangles, just below z = 0."""
    marker = Marker(type=Marker.TRIANGLE_LIST, action=Marker.ADD, ns="lane")
    marker.header.frame_id = frame
    marker.pose.orientation.w = marker.scale.x = marker.scale.y = marker.scale.z = 1.0
    marker.color.r = marker.color.g = marker.color.b = 0.6
    marker.color.a = 1.0
    left, right = (
        [Point(float(x), float(y), -0.002) for x, y in lane.edge(side)] for side in (1, -1)
    )
    for k in range(len(left) if lane.closed else len(left) - 1):
        after = (k + 1) % len(left)
        marker.points += [left[k], right[k], left[after], left[after], right[k], right[after]]
    return marker


class Display:
    """Publishers `~lane`, `~centreline` (latched; a circuit repeats its first pose), `~driven`
    and `~text`.
    """

    def __init__(self, lane: Lane, frame: str) -> None:
        self._frame = frame
        self._lock = threading.Lock()
        self._driven = Path()
        self._driven.header.frame_id = frame
        self._due = 0.0
        self._centreline = rospy.Publisher("~centreline", Path, queue_size=1, latch=True)
        self._path = rospy.Publisher("~driven", Path, queue_size=1, latch=True)
        self._text = rospy.Publisher("~text", Marker, queue_size=1)
        self._lane = rospy.Publisher("~lane", Marker, queue_size=1, latch=True)
        self._lane.publish(lane_marker(lane, frame))
        line = Path()
        line.header.frame_id = frame
        points = list(lane.curve) + ([lane.curve[0]] if lane.closed else [])
        for k, point in enumerate(points):
            a, b = points[max(k - 1, 0)], points[min(k + 1, len(points) - 1)]
            yaw = math.atan2(b[1] - a[1], b[0] - a[0])
            line.poses.append(PoseStamped(pose=pose_of(point[0], point[1], yaw)))
        self._centreline.publish(line)

    def clear(self) -> None:
        """Start a new driven path."""
        with self._lock:
            self._driven.poses = []
            self._due = 0.0

    def update(self, stamp: rospy.Time, pose: Pose, status: Status) -> None:
        """Update with the car's newest (x, y, yaw) and the referee's Status."""
        now = stamp.to_sec()
        with self._lock:
            poses = self._driven.poses
            if poses and now < poses[-1].header.stamp.to_sec():
                poses.clear()  # the simulation was reset
            last = poses[-1].pose.position if poses else None
            if last is None or math.dist((last.x, last.y), pose[:2]) >= SPACING:
                poses.append(PoseStamped(pose=pose_of(*pose)))
                poses[-1].header.stamp = stamp
                poses[-1].header.frame_id = self._frame
                del poses[:-MAX_POSES]
            if self._due - 2.0 / RATE < now < self._due:
                return
            self._due = now + 1.0 / RATE
            self._driven.header.stamp = stamp
            self._path.publish(self._driven)
        self._text.publish(self._marker(stamp, pose, status))

    def _marker(self, stamp: rospy.Time, pose: Pose, status: Status) -> Marker:
        marker = Marker(type=Marker.TEXT_VIEW_FACING, action=Marker.ADD, ns="referee")
        marker.header.stamp, marker.header.frame_id = stamp, self._frame
        marker.pose.position.x, marker.pose.position.y = pose[0], pose[1]
        marker.pose.position.z = 0.6
        marker.pose.orientation.w = 1.0
        marker.scale.z = 0.14
        marker.color.r = marker.color.g = marker.color.b = marker.color.a = 1.0
        lines = [f"lap {status.laps + 1}  {status.progress:.0f} %  {status.lap_time:.1f} s"]
        if status.best_lap_time:
            lines.append(f"best {status.best_lap_time:.2f} s")
        lines += [
            name.replace("_", " ")
            for name in ("off_track", "wrong_way", "stuck", "crashed")
            if getattr(status, name)
        ]
        marker.text = "\n".join(lines)
        return marker


COLUMNS = (
    "t",
    "x",
    "y",
    "yaw",
    "speed",
    "arc_length",
    "lateral_error",
    "progress",
    "laps",
    "lap_time",
    "penalty",
    "wheels_off",
    "events",
)


class Log:
    """Writes the CSV file.

    Args:
        path: the file; missing folders are created. Empty: nothing is written.
        on_error: called with one line of text if a later row cannot be written (the disk is full);
            the log stops there.

    Raises:
        OSError: it cannot be opened.
    """

    def __init__(self, path: str, on_error: Callable[[str], object] = lambda text: None) -> None:
        self._stream: TextIO | None = None
        self._writer: Any = None
        self._path, self._on_error = path, on_error
        if path:
            os.makedirs(os.path.dirname(os.path.abspath(path)), exist_ok=True)
            self._stream = open(path, "w", newline="", encoding="utf-8")
            self._writer = csv.writer(self._stream)
            self._writer.writerow(COLUMNS)

    def add(self, pose: Pose, status: Status, events: list[str]) -> None:
        """Write one row.

        Args:
            pose: (x, y, yaw) [m], [rad].
            status: its wheels_off becomes letters such as FL (front left).
        """
        if self._writer is None:
            return
        names = ("FL", "FR", "RL", "RR")
        off = " ".join(name for name, is_off in zip(names, status.wheels_off) if is_off)
        numbers = (
            status.time,
            *pose,
            status.speed,
            status.arc_length,
            status.lateral_error,
            status.progress,
        )
        self._try(
            self._writer.writerow,
            [
                *(f"{number:.6f}" for number in numbers),
                status.laps,
                f"{status.lap_time:.6f}",
                f"{status.penalty:g}",
                off,
                " ".join(events),
            ],
        )

    def close(self) -> None:
        """Finish the file."""
        if self._stream is not None:
            self._try(self._stream.close)
            self._stream = self._writer = None

    def _try(self, write: Callable[..., object], *arguments: Any) -> None:
        """Write; an error stops the log and is reported once."""
        try:
            write(*arguments)
        except OSError as error:
            stream: Any = self._stream
            self._stream = self._writer = None
            with contextlib.suppress(OSError):
                stream.close()  # what is buffered cannot be written either
            self._on_error(f"{self._path} cannot be written: {error.strerror}; it stops here")


SERVICE_TIMEOUT = 5.0  # wall time to wait for the simulator's service [s]


class RefereeNode:
    """Referee, its topics and its services.

    Raises:
        ValueError: a parameter or the track is not valid.
        OSError: the CSV file cannot be written.
    """

    def __init__(self) -> None:
        walled = True if rospy.get_param("~walls", False) else None  # None: as its file says
        track = load_track(str(rospy.get_param("~track", "default")), walled)
        rules, car = read(Rules, rospy.get_param), read(Car, rospy.get_param)
        walls: list[Polygon] = []
        if track.spec.walls.enabled:
            walls = wall_polygons(
                files.wall_boxes(track.lane, track.spec), track.spec.walls.thickness
            )
        self._referee = Referee(Course(track.lane), walls, rules, car)
        self._model = str(rospy.get_param("~model", "racecar"))
        self._log = Log(str(rospy.get_param("~csv", "")), rospy.logerr)
        self._lock = threading.Lock()
        self._last_stamp: rospy.Time | None = None
        self._restarted = -math.inf  # ROS time of the last restart [s]; older odometry is ignored
        self._status = rospy.Publisher("~status", LapStatus, queue_size=50)
        self._display = Display(track.lane, str(rospy.get_param("~frame", "odom")))
        self._move = rospy.ServiceProxy("/gazebo/set_model_state", SetModelState)
        self._world = rospy.ServiceProxy("/gazebo/get_world_properties", GetWorldProperties)
        rospy.Service("~put_back", Trigger, self._on_put_back)
        rospy.Service("~restart", Trigger, self._on_restart)
        rospy.on_shutdown(self._log.close)
        rospy.Subscriber("odom", Odometry, self._receive, queue_size=200)

    def _receive(self, message: Odometry) -> None:
        pose, twist = planar_of(message.pose.pose), message.twist.twist
        if not all(map(math.isfinite, (*pose, twist.linear.x))):
            rospy.logerr_throttle(1.0, f"referee: odometry contains {pose!r}; it is ignored")
            return
        stamp, last = message.header.stamp, self._last_stamp
        if stamp == last:
            return
        self._last_stamp = stamp
        with self._lock:
            if last is not None and stamp < last:  # the simulation was reset
                self._restarted = -math.inf
            time = stamp.to_sec()
            if time <= self._restarted:
                return
            status, events = self._referee.update(time, *pose, twist.linear.x)
            self._log.add(pose, status, events)
            self._publish(message.header, status)
        self._display.update(stamp, pose, status)
        for event in events:
            self._log_event(event, status)
        if self._referee.rules.auto_reset and {"off_track", "crash", "stuck"} & set(events):
            threading.Thread(target=self._reset_car, daemon=True).start()

    def _publish(self, header: Header, status: Status) -> None:
        message = LapStatus(
            **{name: getattr(status, name) for name in LapStatus.__slots__ if name != "header"}
        )
        message.header.stamp, message.header.frame_id = header.stamp, header.frame_id
        self._status.publish(message)

    @staticmethod
    def _log_event(event: str, status: Status) -> None:
        if event == "lap":
            rospy.loginfo(
                "lap %d: %.3f s, penalties %g s", status.laps, status.last_lap_time, status.penalty
            )
        elif event == "start":
            rospy.loginfo("the lap has started")
        else:
            rospy.logwarn("%s at %.2f m", event.replace("_", " "), status.arc_length)

    def _put_back(self) -> str:
        """Put the car on the centreline, at rest; returns an error text or ''."""
        with self._lock:
            pose = pose_of(*self._referee.put_back_pose())
        state = ModelState(model_name=self._model, reference_frame="world", pose=pose)
        try:
            self._move.wait_for_service(SERVICE_TIMEOUT)
            response = self._move(state)
        except (rospy.ROSException, rospy.ServiceException) as error:
            return f"no response from {self._move.resolved_name}: {error}"
        return "" if response.success else response.status_message

    def _reset_car(self) -> None:
        error = self._put_back()
        if error:
            rospy.logerr("referee: the car is not put back: %s", error)

    def _on_put_back(self, _: TriggerRequest) -> TriggerResponse:
        error = self._put_back()
        return TriggerResponse(success=not error, message=error or "put on the centreline")

    def _on_restart(self, _: TriggerRequest) -> TriggerResponse:
        try:
            now = self._world().sim_time  # /clock may be late, as odometry may
        except rospy.ServiceException:  # no simulator; a bag is played
            now = rospy.get_time()
        with self._lock:
            self._referee.restart()
            self._restarted = now
        self._display.clear()
        return TriggerResponse(success=True, message="laps and penalties are 0")


def main() -> None:
    """Run the node until ROS shuts down."""
    run("referee", RefereeNode, (ValueError, OSError))
