"""The params of a DeepRacer reward function."""

import copy
import math

NO_OBJECTS = {
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


def params(standing, motion, command, waypoints, width, objects=()):
    """Everything a reward function may ask; angles in degrees, lengths in metres.

    Args:
        standing: course.judge.Standing.
        motion: course.motion.Motion.
        command: (speed [m/s], steering [rad]) of the action.
        waypoints: Waypoints.
        width: of the lane here [m].
        objects: course.objects.Placed on the track.

    Returns:
        dict.
    """
    speed, steering = command
    length = waypoints.length
    found = {
        "all_wheels_on_track": standing.all_wheels_on,
        "x": motion.x,
        "y": motion.y,
        "heading": _degrees(motion.yaw),
        "distance_from_center": abs(standing.lateral),
        "is_left_of_center": standing.lateral > 0.0,
        "is_reversed": abs(standing.heading_error) > math.pi / 2.0,
        "is_crashed": standing.end == "crashed",
        "is_offtrack": standing.off_track,
        "progress": standing.progress,
        "steps": standing.steps,
        "speed": speed,
        "steering_angle": math.degrees(steering),
        "track_width": width,
        "track_length": length,
        "waypoints": list(waypoints.points),
        "closest_waypoints": waypoints.around(standing.s),
        "projection_distance": standing.s % length if waypoints.closed else standing.s,
    }
    found.update(_of_objects(standing, motion, objects, length) if objects else _empty())
    return found


def _empty():
    return copy.deepcopy(NO_OBJECTS)


def _of_objects(standing, motion, objects, length):
    """The keys of boxes and other cars."""
    ahead = [(thing.s - standing.s) % length for thing in objects]
    numbers = range(len(objects))
    return {
        "closest_objects": [
            max(numbers, key=ahead.__getitem__),
            min(numbers, key=ahead.__getitem__),
        ],
        "objects_location": [(thing.x, thing.y) for thing in objects],
        "objects_left_of_center": [thing.lateral > 0.0 for thing in objects],
        "objects_speed": [thing.speed for thing in objects],
        "objects_heading": [_degrees(thing.yaw) for thing in objects],
        "objects_distance_from_center": [abs(thing.lateral) for thing in objects],
        "objects_distance": [thing.s % length for thing in objects],
        "object_in_camera": any(_in_view(motion, thing) for thing in objects),
    }


def _in_view(motion, thing):
    bearing = math.atan2(thing.y - motion.y, thing.x - motion.x) - motion.yaw
    return abs(math.remainder(bearing, 2.0 * math.pi)) < CAMERA_HALF_ANGLE


def _degrees(yaw):
    return math.degrees(math.remainder(yaw, 2.0 * math.pi))
