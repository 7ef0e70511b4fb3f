"""The node `goal`: service /goal, status, cancel; /odom in, /cmd_vel out."""

import math
import threading
import time

import rospy
from actionlib_msgs.msg import GoalStatus
from geometry_msgs.msg import PoseStamped, Twist
from nav_msgs.msg import Odometry
from paddock_common.geometry import planar_of, pose_of
from paddock_common.nodes import run
from paddock_common.settings import read
from paddock_common.waiting import flush
from std_srvs.srv import Trigger, TriggerResponse

from cybertruck.goal.controller import REACHED, RESET, STUCK, GoalController
from cybertruck.goal.settings import GoalSettings
from cybertruck.srv import Goal, GoalResponse


class GoalNode:
    """The go-to-goal node. It publishes commands only while it has a goal.

    Raises:
        ValueError: A parameter is wrong; the message names it.
    """

    def __init__(self):
        self._settings = read(GoalSettings, rospy.get_param)
        self._controller = GoalController(self._settings)
        self._lock = threading.RLock()  # service, odometry and timer have different threads
        self._pose, self._frame, self._received = None, "odom", None
        self._count, self._id = 0, None
        self._command = rospy.Publisher("cmd_vel", Twist, queue_size=10)
        self._status = rospy.Publisher("goal/status", GoalStatus, queue_size=10, latch=True)
        self._current = rospy.Publisher("goal/pose", PoseStamped, queue_size=10, latch=True)
        rospy.Subscriber("odom", Odometry, self._on_odometry, queue_size=1)
        rospy.Service("goal", Goal, self._on_goal)
        rospy.Service("goal/cancel", Trigger, self._on_cancel)
        rospy.Timer(
            rospy.Duration(min(0.1, self._settings.odom_timeout)), self._check_odometry, reset=True
        )
        rospy.on_shutdown(self._on_shutdown)
        variant = "with trailer" if self._settings.trailer else "without trailer"
        rospy.loginfo(
            "goal: ready, %s gains, %s, turns of %.2f m",
            self._settings.gains,
            variant,
            self._settings.radius,
        )

    def _on_goal(self, request):
        position = request.pose.position
        with self._lock:
            stale = self._odometry_is_stale()
            pose = None if stale else self._pose
            reason = self._controller.refusal((position.x, position.y, position.z), pose)
            if reason and self._pose is not None and stale and "no odometry" in reason:
                reason = f"no odometry for {self._settings.odom_timeout:g} s"
            if reason:
                rospy.logwarn("goal: refused (%g, %g): %s", position.x, position.y, reason)
                return GoalResponse(success=False)
            if self._controller.goal is not None:
                self._publish_status(GoalStatus.PREEMPTED, "replaced by a new goal")
            self._controller.start(position.x, position.y)
            self._count += 1
            self._id = f"goal-{self._count}"
            current = PoseStamped(pose=pose_of(position.x, position.y))
            current.header.stamp, current.header.frame_id = rospy.Time.now(), self._frame
            self._current.publish(current)
            self._publish_status(GoalStatus.ACTIVE, f"driving to ({position.x:g}, {position.y:g})")
        return GoalResponse(success=True)

    def _on_cancel(self, _request):
        with self._lock:
            if self._controller.goal is None:
                return TriggerResponse(success=False, message="there is no goal to cancel")
            self._stop_goal(GoalStatus.PREEMPTED, "cancelled")
        return TriggerResponse(success=True, message="cancelled")

    def _on_odometry(self, message):
        x, y, heading = planar_of(message.pose.pose)
        if not all(map(math.isfinite, (x, y, heading))):
            rospy.logwarn_throttle(
                5.0, "goal: the odometry has a value that is not finite; it is ignored"
            )
            return
        with self._lock:
            self._pose, self._frame = (x, y, heading), message.header.frame_id or "odom"
            self._received = (rospy.get_time(), time.monotonic())
            update = self._controller.update(x, y, heading, message.header.stamp.to_sec())
            if update is None:
                return
            state, linear, angular = update
            self._send(linear, angular)
            controller = self._controller
            if state == REACHED:
                self._publish_status(
                    GoalStatus.SUCCEEDED,
                    f"arrived, {controller.distance:.3f} m from the goal, drove "
                    f"{controller.driven:.2f} m, shortest {controller.shortest:.2f} m",
                )
            elif state == STUCK:
                self._publish_status(
                    GoalStatus.ABORTED,
                    f"stuck {controller.distance:.2f} m from the goal: moved less than "
                    f"{self._settings.stuck_distance:g} m in "
                    f"{self._settings.stuck_time:g} s",
                )
            elif state == RESET:
                self._publish_status(GoalStatus.ABORTED, "time went back: the simulation was reset")

    def _check_odometry(self, _event):
        with self._lock:
            if self._controller.goal is not None and self._odometry_is_stale():
                self._stop_goal(
                    GoalStatus.ABORTED,
                    f"no odometry for {self._settings.odom_timeout:g} s",
                )

    def _odometry_is_stale(self):
        """Returns whether there is no recent odometry.

        The time-out must have passed in ROS time, because of paused worlds, and in wall time,
        because messages of a world faster than real time may be a little late. ROS time below that
        of the last message means a reset: then only wall time is checked.
        """
        if self._received is None:
            return True
        limit = self._settings.odom_timeout
        age = rospy.get_time() - self._received[0]
        return (age >= limit or age < 0.0) and time.monotonic() - self._received[1] >= limit

    def _stop_goal(self, status, text):
        self._controller.stop()
        self._send(0.0, 0.0)
        self._publish_status(status, text)

    def _send(self, linear, angular):
        message = Twist()
        message.linear.x, message.angular.z = linear, angular
        self._command.publish(message)

    def _publish_status(self, status, text):
        message = GoalStatus(status=status, text=text)
        message.goal_id.stamp, message.goal_id.id = rospy.Time.now(), self._id
        self._status.publish(message)
        log = rospy.logwarn if status == GoalStatus.ABORTED else rospy.loginfo
        log("goal: %s: %s", self._id, text)

    def _on_shutdown(self):
        with self._lock:
            if self._controller.goal is not None:
                self._controller.stop()
                self._send(0.0, 0.0)
                flush(self._command)


def main():
    """Runs the node; exits with 1 and the reason if it cannot start."""
    run("goal", GoalNode)
