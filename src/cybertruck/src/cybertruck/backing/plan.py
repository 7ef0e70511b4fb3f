"""Action goal -> tracker; no ROS."""

import dataclasses
import math

import numpy as np

from cybertruck.backing.settings import MAX_START_DISTANCE, MAX_START_HEADING
from cybertruck.trailer.geometry import TrailerError
from cybertruck.trailer.hold import CurvatureHold
from cybertruck.trailer.paths import from_points
from cybertruck.trailer.shapes import make_shape
from cybertruck.trailer.tracker import TOP_SPEED, Tracker

HOLD = "hold"  # a shape without a path: hold a curvature over a length


def make_tracker(goal, trailer, settings):
    """Checks a goal and makes its tracker, starting at the trailer's pose.

    Args:
        goal: What has the fields of cybertruck/BackUpGoal.
        trailer: (x, y [m], θ2 [rad]) of the trailer's axle now, in the odometry frame.
        settings: Settings.

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
                f"hold: {len(goal.size)} numbers; it takes curvature [1/m], left "
                "positive as driven, and length [m]"
            )
        return CurvatureHold(*goal.size, settings.geometry, settings.steering, tuning)
    path = goal_path(goal, trailer, settings.node.odom_frame)
    tracker = Tracker(path, settings.geometry, settings.steering, tuning)
    tracker.begin(trailer[0], trailer[1])
    _, heading = path.errors(trailer[0], trailer[1], trailer[2] + math.pi, tracker.arc)
    x, y, _, _ = path.place(np.clip(tracker.arc, 0.0, path.length))
    distance = math.hypot(trailer[0] - x, trailer[1] - y)
    if distance > MAX_START_DISTANCE:
        raise TrailerError(
            f"path: it begins {distance:.1f} m from the trailer; it must be within "
            f"{MAX_START_DISTANCE:g} m"
        )
    if tracker.arc >= path.length:
        raise TrailerError("path: the trailer stands at or behind its end already")
    if abs(heading) > MAX_START_HEADING:
        raise TrailerError(
            f"path: it leads {math.degrees(abs(heading)):.0f} degrees away from where the "
            f"trailer backs to; at most {math.degrees(MAX_START_HEADING):.0f} are taken"
        )
    return tracker


def goal_path(goal, trailer, frame):
    """Makes the Path of a goal.

    Args:
        goal: What has the fields of cybertruck/BackUpGoal.
        trailer: (x, y, θ2) as above.
        frame: The odometry frame's name.
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
    given = goal.path.header.frame_id or frame
    if given.lstrip("/") != frame:
        raise TrailerError(f"path: its frame is '{given}'; it must be '{frame}'")
    return from_points([(item.pose.position.x, item.pose.position.y) for item in poses])
