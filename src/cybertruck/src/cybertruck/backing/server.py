"""The back_up action: settings, plan, commands, feedback, errors."""

import dataclasses
import math
import threading
from dataclasses import dataclass, field

import numpy as np
import rospy
from actionlib import ActionServer
from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import Path as PathMessage
from paddock_common.geometry import pose_of
from paddock_common.nodes import start
from paddock_common.settings import Checked, from_table, number, read, text
from paddock_common.waiting import flush

from cybertruck.backing.state import StateSource
from cybertruck.msg import BackUpAction, BackUpFeedback, BackUpResult, CyberDriveStamped
from cybertruck.trailer.geometry import Geometry, TrailerError
from cybertruck.trailer.paths import from_points
from cybertruck.trailer.shapes import make_shape
from cybertruck.trailer.steering import IdealSteering, read_map
from cybertruck.trailer.tracker import (
    ARRIVED,
    BACKING,
    FAILED,
    MODES,
    TOP_SPEED,
    CurvatureHold,
    Tracker,
    Tuning,
)


class Driver:
    """Publishes /cmd_cyberdrive."""

    def __init__(self):
        self._publisher = rospy.Publisher(
            "/cmd_cyberdrive", CyberDriveStamped, queue_size=1, tcp_nodelay=True
        )
        self._steering = 0.0
        self._lock, self._is_shut_down = threading.RLock(), False
        rospy.on_shutdown(self._shut_down)

    def send(self, steering, speed):
        """Sends a steering angle [rad] and a speed [m/s]."""
        message = CyberDriveStamped()
        message.header.stamp = rospy.Time.now()
        message.drive.steering_angle, message.drive.speed = float(steering), float(speed)
        self._steering = float(steering)
        with self._lock:
            if not self._is_shut_down:
                self._publisher.publish(message)

    def stop(self):
        """Sends speed 0; the steering angle stays."""
        self.send(self._steering, 0.0)

    def _shut_down(self):
        """Stops the truck at shutdown; nothing follows, rospy closes the topic next."""
        with self._lock:
            self.stop()
            self._is_shut_down = True
        flush(self._publisher)

    @property
    def subscribers(self):
        """Number of subscribers."""
        return self._publisher.get_num_connections()


MAX_START_DISTANCE = 3.0  # from the trailer's axle to the path's first meters [m]
MAX_START_HEADING = math.radians(75.0)  # between trailer and path at the start [rad]


@dataclass(frozen=True)
class NodeSettings(Checked, error=TrailerError):
    """Settings of the node itself.

    Attributes:
        control_period: Simulated time between two commands [s].
        state_timeout: Time without odometry or joint states after which the truck stops [s].
        stuck_time: A goal is aborted when nothing moved for this time [s].
        odom_frame: Frame of goals' paths.
        hitch_joint: Name in /joint_states.
        steering_map: File of a measured map, or "" for the ideal tan φ / L.
    """

    control_period: float = number(0.032, above=0.0, unit="s")
    state_timeout: float = number(0.5, above=0.0, unit="s")
    stuck_time: float = number(5.0, above=0.0, unit="s")
    odom_frame: str = text("odom")
    hitch_joint: str = text("hitch_yaw_joint")
    steering_map: str = text("", empty=True)


@dataclass(frozen=True)
class Settings:
    """All settings: geometry, tuning, node, and the steering map."""

    geometry: Geometry
    tuning: Tuning
    node: NodeSettings
    steering: object


def settings_from(parameters):
    """Makes Settings from the node's private parameters.

    Args:
        parameters: Dict with truck.yaml's keys, of which the geometry is used, and the tables
            `tuning`, `node` and (optionally) `hitch_stop` [rad].

    Raises:
        TrailerError: Names the parameter, its value and what is valid.
    """
    geometry = read(Geometry, parameters.get, prefix="")
    node = from_table(NodeSettings, parameters.get("node", {}), "node", TrailerError)
    tuning = from_table(Tuning, parameters.get("tuning", {}), "tuning", TrailerError)
    steering = (
        read_map(node.steering_map)
        if node.steering_map
        else IdealSteering(geometry.wheelbase, geometry.max_steering)
    )
    return Settings(geometry, tuning, node, steering)


HOLD = "hold"  # a shape without a path: hold a curvature over a length


def make_tracker(goal, trailer, settings: Settings):
    """Checks a goal and makes its tracker, starting at the trailer's pose.

    Args:
        goal: Has the fields of cybertruck/BackUpGoal.
        trailer: (x, y [m], θ2 [rad]) of the trailer's axle now, in the odometry frame.

    Returns:
        Tracker, or CurvatureHold for the shape "hold".

    Raises:
        TrailerError: The goal cannot be driven; names the value and what is valid.
    """
    tuning = settings.tuning
    if goal.speed != 0.0:
        if not 0.0 < goal.speed < TOP_SPEED:
            raise TrailerError(
                f"speed {goal.speed:g} m/s; it must be above 0 and below "
                f"{TOP_SPEED:g}, or 0 for the default"
            )
        tuning = dataclasses.replace(tuning, speed=goal.speed)
    if goal.shape == HOLD and not goal.path.poses:
        if len(goal.size) != 2:
            raise TrailerError(
                f"hold: {len(goal.size)} numbers; it must be curvature [1/m], left "
                "positive as driven, and length [m]"
            )
        return CurvatureHold(*goal.size, settings.geometry, settings.steering, tuning)
    path = goal_path(goal, trailer, settings.node.odom_frame)
    tracker = Tracker(path, settings.geometry, settings.steering, tuning)
    tracker.start(trailer[0], trailer[1])
    _, heading = path.errors(trailer[0], trailer[1], trailer[2] + math.pi, tracker.arc)
    x, y, _, _ = path.sample(np.clip(tracker.arc, 0.0, path.length))
    distance = math.hypot(trailer[0] - x, trailer[1] - y)
    if distance > MAX_START_DISTANCE:
        raise TrailerError(
            f"path: it starts {distance:.1f} m from the trailer; it must be within "
            f"{MAX_START_DISTANCE:g} m"
        )
    if tracker.arc >= path.length:
        raise TrailerError("path: the trailer is at or beyond its end already")
    if abs(heading) > MAX_START_HEADING:
        raise TrailerError(
            f"path: its direction differs by {math.degrees(abs(heading)):.0f} degrees from the "
            f"trailer's backwards; it must be at most {math.degrees(MAX_START_HEADING):.0f}"
        )
    return tracker


def goal_path(goal, trailer, frame):
    """Makes the Path of a goal.

    Args:
        goal: Has the fields of cybertruck/BackUpGoal.
        trailer: (x, y, θ2) as of make_tracker.
    """
    poses = goal.path.poses
    if bool(poses) == bool(goal.shape):
        raise TrailerError(
            "goal: it must have either a path or a shape, it has "
            + ("both" if poses else "neither")
        )
    if not poses:
        x, y, heading = trailer
        return make_shape(goal.shape, tuple(goal.size)).moved(x, y, heading + math.pi)
    frame_id = goal.path.header.frame_id or frame
    if frame_id.lstrip("/") != frame:
        raise TrailerError(f"path: its frame is '{frame_id}'; it must be '{frame}'")
    return path_of(goal.path)


def path_of(message):
    """Makes the Path of a nav_msgs/Path."""
    return from_points([(item.pose.position.x, item.pose.position.y) for item in message.poses])


POLL = 0.1  # wall time between checks for cancel and shutdown when no message arrives [s]
FEEDBACK_PERIOD = 0.1  # simulated time [s]
REST_SPEED = 0.005  # the truck counts as at rest below [m/s]
REST_TIME = 3.0  # maximum simulated wait for that [s]
PATH_STEP = 10  # samples between published points of a path; the last one is added
MOVED = 0.02  # a truck that moved less in stuck_time is stuck [m]


class Stopped(Exception):
    """A goal is aborted; the text is the reason."""


class Cancelled(Exception):
    """The client or a newer goal cancelled the goal."""


@dataclass
class Job:
    """An accepted goal."""

    handle: object
    tracker: object
    cancelled: threading.Event = field(default_factory=threading.Event)
    errors: list = field(default_factory=list)  # lateral errors while backing [m]
    reason: str = "cancelled"


class BackUpServer:
    """Accepts one goal at a time; a newer one preempts it.

    Raises:
        TrailerError: A parameter is wrong.
    """

    def __init__(self):
        self._settings = settings_from(rospy.get_param("~", {}))
        self._source = StateSource("/odom", self._settings.node.hitch_joint)
        self._driver = Driver()
        self._path_out = rospy.Publisher("~path", PathMessage, queue_size=1, latch=True)
        self._changed = threading.Condition()
        self._waiting = self._current = None
        self._server = ActionServer(
            "back_up", BackUpAction, self._on_goal, self._on_cancel, auto_start=False
        )
        self._server.start()

    def _on_goal(self, handle):
        try:
            reason = self._source.staleness(self._settings.node.state_timeout)
            if reason:
                raise TrailerError(reason)
            trailer = self._source.state.trailer(self._settings.geometry)
            tracker = make_tracker(handle.get_goal(), trailer, self._settings)
        except TrailerError as error:
            rospy.logwarn("goal refused: %s", error)
            handle.set_rejected(BackUpResult(message=str(error)), str(error))
            return
        handle.set_accepted()
        with self._changed:
            older = [job for job in (self._waiting, self._current) if job is not None]
            for job in older:
                job.reason = "replaced by a newer goal"
                job.cancelled.set()
            if self._waiting is not None:
                self._waiting.handle.set_canceled(BackUpResult(message=self._waiting.reason))
            self._waiting = Job(handle, tracker)
            self._changed.notify_all()

    def _on_cancel(self, handle):
        with self._changed:
            for job in (self._waiting, self._current):
                if job is not None and job.handle == handle:
                    job.cancelled.set()

    def run(self):
        """Executes goals until ROS shuts down."""
        while not rospy.is_shutdown():
            with self._changed:
                self._current = None
                self._changed.wait_for(lambda: self._waiting is not None, POLL)
                self._current, self._waiting = self._waiting, None
            if self._current is not None:
                self._execute(self._current)

    def _execute(self, job):
        """Executes a goal and sets its result."""
        if job.tracker.path is not None:
            self._show(job.tracker.path)
        try:
            self._follow(job)
        except Cancelled:
            if rospy.is_shutdown():
                return
            self._stop_truck()
            job.handle.set_canceled(self._result(job, False, job.reason), job.reason)
        except Stopped as reason:
            self._stop_truck()
            rospy.logerr("backing aborted: %s", reason)
            job.handle.set_aborted(self._result(job, False, str(reason)), str(reason))
        else:
            self._stop_truck()
            job.handle.set_succeeded(self._result(job, True, "arrived"), "arrived")

    def _follow(self, job):
        """Commands the truck until the path's end.

        Raises:
            Cancelled: By the client, a newer goal, or shutdown.
            Stopped: The state is stale, the truck is stuck, or the trailer cannot be unfolded.
        """
        node, stamp, feedback_stamp, mode = self._settings.node, None, -math.inf, BACKING
        moved_at, self._resets = None, self._source.resets
        while True:
            state = self._next_state(job, stamp)
            stamp = state.stamp
            trailer = state.trailer(self._settings.geometry)
            status = job.tracker.step(*trailer, state.hitch_angle)
            if status.mode != mode:
                mode = int(status.mode)
                rospy.loginfo(
                    "%s at %.2f m, hitch at %.0f degrees",
                    MODES[mode],
                    status.arc,
                    math.degrees(state.hitch_angle),
                )
            if mode == FAILED:
                raise Stopped(
                    "the trailer could not be unfolded, its hitch is at "
                    f"{math.degrees(state.hitch_angle):.0f} degrees"
                )
            if mode == BACKING:
                job.errors.append(float(status.lateral))
            if stamp - feedback_stamp >= FEEDBACK_PERIOD:
                feedback_stamp = stamp
                progress = float(np.clip(status.arc / job.tracker.length, 0.0, 1.0))
                job.handle.publish_feedback(
                    BackUpFeedback(
                        float(status.lateral), float(status.heading), state.hitch_angle, progress
                    )
                )
            if mode == ARRIVED:
                return
            if moved_at is None or math.hypot(state.x - moved_at[1], state.y - moved_at[2]) > MOVED:
                moved_at = stamp, state.x, state.y
            elif stamp - moved_at[0] > node.stuck_time:
                raise Stopped(f"the truck has not moved for {node.stuck_time:g} s")
            self._driver.send(status.steering, status.speed)

    def _next_state(self, job, stamp):
        """Waits for the state of the next control period.

        Raises:
            Cancelled, Stopped: See _follow.
        """
        node = self._settings.node
        while True:
            if job.cancelled.is_set() or rospy.is_shutdown():
                raise Cancelled
            state = self._source.wait(
                None if stamp is None else stamp + node.control_period - 1e-6, POLL
            )
            reason = self._source.staleness(node.state_timeout)
            # checked first: during a reset the state looks stale
            if self._source.resets != self._resets or (
                state is not None and stamp is not None and state.stamp < stamp
            ):
                raise Stopped("time went back: the simulation was reset")
            if reason:
                raise Stopped(reason)
            if state is not None:
                return state

    def _stop_truck(self):
        """Stops the truck and waits for rest, while states arrive and without a reset."""
        self._driver.stop()
        start = rospy.get_time()
        while not rospy.is_shutdown() and 0.0 <= rospy.get_time() - start < REST_TIME:
            state = self._source.state
            if state is None or self._source.staleness(self._settings.node.state_timeout):
                break
            if rospy.get_time() - start > 0.2 and abs(state.speed) < REST_SPEED:
                break
            if self._source.wait(state.stamp, POLL) is None and rospy.get_time() == start:
                break  # paused
        self._driver.stop()

    def _result(self, job, success, message):
        """Compares the trailer's pose with the path's end."""
        result = BackUpResult(success=success, message=message)
        if job.errors:
            errors = np.array(job.errors)
            result.rms_lateral_error = float(np.sqrt(np.mean(errors**2)))
            result.max_lateral_error = float(np.max(np.abs(errors)))
        path, state = job.tracker.path, self._source.state
        if path is None:
            return result
        x, y, heading = state.trailer(self._settings.geometry)
        end_x, end_y, _, _ = path.sample(path.length)
        result.end_distance = float(np.hypot(x - end_x, y - end_y))
        result.end_heading_error = float(path.errors(x, y, heading + math.pi, path.length)[1])
        return result

    def _show(self, path):
        """Publishes the path for rviz."""
        message = PathMessage()
        message.header.stamp = rospy.Time.now()
        message.header.frame_id = self._settings.node.odom_frame
        last = len(path.points) - 1
        for index in np.unique(np.append(np.arange(0, last - 5, PATH_STEP), last)):
            pose = pose_of(*path.points[index], path.headings[index])
            message.poses.append(PoseStamped(header=message.header, pose=pose))
        self._path_out.publish(message)


def main():
    """Runs the node; exits with 1 and the reason if it cannot start."""
    start("back_up", BackUpServer).run()
