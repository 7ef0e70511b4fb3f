"""The node `referee`: ground truth in, LapStatus, paths and a CSV out; resets the car."""

import math
import threading

import rospy
from gazebo_msgs.msg import ModelState
from gazebo_msgs.srv import SetModelState
from nav_msgs.msg import Odometry
from paddock_common.angles import yaw_of
from paddock_common.nodes import run
from paddock_common.settings import read
from std_srvs.srv import Trigger, TriggerResponse

from track_model.files import writer as files
from track_model.msg import LapStatus
from track_model.referee.course import Course
from track_model.referee.display import Display
from track_model.referee.log import Log
from track_model.referee.referee import Referee, wall_polygons
from track_model.referee.rules import Car, Rules
from track_model.track import load_track

SERVICE_TIMEOUT = 5.0  # wall time to wait for the simulator's service [s]


class RefereeNode:
    """Referee, its topics and its services.

    Raises:
        ValueError: a parameter or the track is not valid.
        OSError: the CSV file cannot be written.
    """

    def __init__(self):
        track = load_track(str(rospy.get_param("~track", "default")))
        rules, car = read(Rules, rospy.get_param), read(Car, rospy.get_param)
        walls = ()
        if track.spec.walls.enabled:
            walls = wall_polygons(
                files.wall_boxes(track.lane, track.spec), track.spec.walls.thickness
            )
        self._referee = Referee(Course(track.lane), walls, rules, car)
        self._model = str(rospy.get_param("~model", "racecar"))
        self._log = Log(str(rospy.get_param("~csv", "")), rospy.logerr)
        self._lock = threading.Lock()
        self._last_stamp = None
        self._status = rospy.Publisher("~status", LapStatus, queue_size=50)
        self._display = Display(track.lane, str(rospy.get_param("~frame", "odom")))
        self._move = rospy.ServiceProxy("/gazebo/set_model_state", SetModelState)
        rospy.Service("~put_back", Trigger, self._put_back_asked)
        rospy.Service("~restart", Trigger, self._restart_asked)
        rospy.on_shutdown(self._log.close)
        rospy.Subscriber("odom", Odometry, self._receive, queue_size=200)

    def _receive(self, message):
        position, twist = message.pose.pose.position, message.twist.twist
        pose = (position.x, position.y, yaw_of(message.pose.pose.orientation))
        if not all(map(math.isfinite, (*pose, twist.linear.x))):
            rospy.logerr_throttle(1.0, f"referee: odometry holds {pose!r}; it is ignored")
            return
        if message.header.stamp == self._last_stamp:
            return
        self._last_stamp = message.header.stamp
        with self._lock:
            status, events = self._referee.update(
                message.header.stamp.to_sec(), *pose, twist.linear.x
            )
            self._log.add(pose, status, events)
            self._publish(message.header, status)
        self._display.update(message.header.stamp, pose, status)
        for event in events:
            self._log_event(event, status)
        if self._referee.rules.auto_reset and {"off_track", "crash", "stuck"} & set(events):
            threading.Thread(target=self._reset_car, daemon=True).start()

    def _publish(self, header, status):
        message = LapStatus(
            **{name: getattr(status, name) for name in LapStatus.__slots__ if name != "header"}
        )
        message.header.stamp, message.header.frame_id = header.stamp, header.frame_id
        self._status.publish(message)

    @staticmethod
    def _log_event(event, status):
        if event == "lap":
            rospy.loginfo(
                "lap %d: %.3f s, penalties %g s", status.laps, status.last_lap_time, status.penalty
            )
        elif event == "start":
            rospy.loginfo("the lap has started")
        else:
            rospy.logwarn("%s at %.2f m", event.replace("_", " "), status.arc_length)

    def _put_back(self):
        """Place the car on the centreline, at rest; returns an error text or ''."""
        with self._lock:
            x, y, yaw = self._referee.put_back_pose()
        state = ModelState(model_name=self._model, reference_frame="world")
        state.pose.position.x, state.pose.position.y = x, y
        state.pose.orientation.z, state.pose.orientation.w = math.sin(yaw / 2), math.cos(yaw / 2)
        try:
            self._move.wait_for_service(SERVICE_TIMEOUT)
            answer = self._move(state)
        except (rospy.ROSException, rospy.ServiceException) as error:
            return f"no answer from {self._move.resolved_name}: {error}"
        return "" if answer.success else answer.status_message

    def _reset_car(self):
        error = self._put_back()
        if error:
            rospy.logerr("referee: the car is not put back: %s", error)

    def _put_back_asked(self, _):
        error = self._put_back()
        return TriggerResponse(success=not error, message=error or "put on the centreline")

    def _restart_asked(self, _):
        with self._lock:
            self._referee.restart()
        self._display.clear()
        return TriggerResponse(success=True, message="laps and penalties are 0")


def main():
    """Run the node until ROS shuts down."""
    run("referee", RefereeNode, (ValueError, OSError))
