"""DeepRacer's reward parameters: waypoints and state."""

from __future__ import annotations

import bisect
import copy
import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from track_model.referee.course import Course
from track_model.track import Track

from paddock_gym.course import Motion, RunState, TrackObject

SPACING = 0.15  # of the waypoints of tracks other than DeepRacer's routes [m]


class Waypoints:
    """Points of the centreline.

    A route's waypoints are the points of its file, so that indices from the console are
    valid; any other track's are some 15 cm apart. On a circuit the last repeats the first.

    Attributes:
        points: (x, y) [m] each.
        closed: whether it is a circuit.
        length: of the centreline [m].
    """

    def __init__(self, track: Track, course: Course) -> None:
        self.closed, self.length = course.closed, course.length
        if track.spec.imported:
            points, along = (values.tolist() for values in _of_file(track, course))
        else:
            count = max(4, round(course.length / SPACING))
            along = (np.arange(count + (not self.closed)) * course.length / count).tolist()
            points = [course.pose(s)[:2] for s in along]
        self._along = [float(s) for s in along]
        self.points = [(float(x), float(y)) for x, y in points]
        if self.closed:
            self._along.append(self.length)
            self.points.append(self.points[0])

    def around(self, s: float) -> list[int]:
        """Indices [behind, ahead] of the waypoints around an arc length [m]."""
        at = s % self.length if self.closed else min(max(s, 0.0), self.length)
        ahead = min(max(bisect.bisect_right(self._along, at), 1), len(self._along) - 1)
        return [ahead - 1, ahead]


def _of_file(track: Track, course: Course) -> tuple[np.ndarray, np.ndarray]:
    """The file's points in the track's frame, and their arc lengths in increasing order."""
    x, y, yaw = track.lane.origin
    c, s = math.cos(yaw), math.sin(yaw)
    points = (np.asarray(track.spec.points) - (x, y)) @ np.array(((c, -s), (s, c)))
    along, _ = course.project(points)
    along[np.abs(along - course.length) < 1e-3] = 0.0 if course.closed else course.length
    order = np.argsort(along, kind="stable")
    return points[order], along[order]


NO_OBJECTS: dict[str, Any] = {
    "closest_objects": [0, 0],
    "objects_location": [],
    "objects_left_of_center": [],
    "objects_speed": [],
    "objects_heading": [],
    "objects_distance_from_center": [],
    "objects_distance": [],
    "object_in_camera": False,
}
CAMERA_HALF_ANGLE = 0.565  # of the front camera's field of view [rad]


def params(
    state: RunState,
    motion: Motion,
    command: tuple[float, float],
    waypoints: Waypoints,
    width: float,
    objects: Sequence[TrackObject] = (),
) -> dict[str, Any]:
    """All parameters of a reward function; angles in degrees, lengths in meters.

    Args:
        command: (speed [m/s], steering [rad]) of the action.
        width: of the lane here [m].
        objects: on the track.
    """
    speed, steering = command
    length = waypoints.length
    result = {
        "all_wheels_on_track": state.all_wheels_on,
        "x": motion.x,
        "y": motion.y,
        "heading": _degrees(motion.yaw),
        "distance_from_center": abs(state.lateral),
        "is_left_of_center": state.lateral > 0.0,
        "is_reversed": abs(state.heading_error) > math.pi / 2.0,
        "is_crashed": state.end == "crashed",
        "is_offtrack": state.off_track,
        "progress": state.progress,
        "steps": state.steps,
        "speed": speed,
        "steering_angle": math.degrees(steering),
        "track_width": width,
        "track_length": length,
        "waypoints": list(waypoints.points),
        "closest_waypoints": waypoints.around(state.s),
        "projection_distance": state.s % length if waypoints.closed else state.s,
    }
    no_objects = copy.deepcopy(NO_OBJECTS)  # a user's function may change the lists
    result.update(_of_objects(state, motion, objects, length) if objects else no_objects)
    return result


def _of_objects(
    state: RunState, motion: Motion, objects: Sequence[TrackObject], length: float
) -> dict[str, Any]:
    """The keys of boxes and other cars."""
    ahead = [(obj.s - state.s) % length for obj in objects]
    indices = range(len(objects))
    return {
        "closest_objects": [
            max(indices, key=ahead.__getitem__),
            min(indices, key=ahead.__getitem__),
        ],
        "objects_location": [(obj.x, obj.y) for obj in objects],
        "objects_left_of_center": [obj.lateral > 0.0 for obj in objects],
        "objects_speed": [obj.speed for obj in objects],
        "objects_heading": [_degrees(obj.yaw) for obj in objects],
        "objects_distance_from_center": [abs(obj.lateral) for obj in objects],
        "objects_distance": [obj.s % length for obj in objects],
        "object_in_camera": any(_in_view(motion, obj) for obj in objects),
    }


def _in_view(motion: Motion, obj: TrackObject) -> bool:
    bearing = math.atan2(obj.y - motion.y, obj.x - motion.x) - motion.yaw
    return abs(math.remainder(bearing, 2.0 * math.pi)) < CAMERA_HALF_ANGLE


def _degrees(yaw: float) -> float:
    return math.degrees(math.remainder(yaw, 2.0 * math.pi))
