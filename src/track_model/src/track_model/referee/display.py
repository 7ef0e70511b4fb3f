"""Displays for rviz: the lane, centreline, driven path, progress text."""

import math
import threading

import rospy
from geometry_msgs.msg import Point, PoseStamped
from nav_msgs.msg import Path
from visualization_msgs.msg import Marker

SPACING = 0.05  # of the driven path's poses [m]
LONGEST = 4000  # length of the driven path [poses]
RATE = 5.0  # of path and text [Hz] of simulated time


def pose_stamped(x, y, yaw):
    """Return a PoseStamped on the ground without header."""
    pose = PoseStamped()
    pose.pose.position.x, pose.pose.position.y = x, y
    pose.pose.orientation.z, pose.pose.orientation.w = math.sin(yaw / 2), math.cos(yaw / 2)
    return pose


def lane_marker(lane, frame):
    """The lane's surface as visualization_msgs/Marker: triangles, just below z = 0."""
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

    Args:
        lane: geometry.Lane.
        frame: of the track.
    """

    def __init__(self, lane, frame):
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
            line.poses.append(pose_stamped(float(point[0]), float(point[1]), yaw))
        self._centreline.publish(line)

    def clear(self):
        """Begin a new driven path."""
        with self._lock:
            self._driven.poses = []
            self._due = 0.0

    def update(self, stamp, pose, status):
        """Update with the car's newest (x, y, yaw) and the referee's Status."""
        now = stamp.to_sec()
        with self._lock:
            poses = self._driven.poses
            if poses and now < poses[-1].header.stamp.to_sec():
                poses.clear()  # the simulation was reset
            last = poses[-1].pose.position if poses else None
            if last is None or math.dist((last.x, last.y), pose[:2]) >= SPACING:
                poses.append(pose_stamped(*pose))
                poses[-1].header.stamp = stamp
                poses[-1].header.frame_id = self._frame
                del poses[:-LONGEST]
            if self._due - 2.0 / RATE < now < self._due:
                return
            self._due = now + 1.0 / RATE
            self._driven.header.stamp = stamp
            self._path.publish(self._driven)
        self._text.publish(self._marker(stamp, pose, status))

    def _marker(self, stamp, pose, status):
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
