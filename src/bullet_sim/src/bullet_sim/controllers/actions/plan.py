"""Trajectories of commands joined to what the joints are doing; holding and stopping."""

import copy
import math
from dataclasses import dataclass

from bullet_sim.controllers.actions.spline import End, Segment, active
from bullet_sim.controllers.angles import shortest_distance
from bullet_sim.errors import CommandError


@dataclass(frozen=True)
class Point:
    """A point of a trajectory: a value a joint, velocities and accelerations maybe missing.

    Attributes:
        time: since the trajectory's start [s].
    """

    time: float
    positions: tuple[float, ...]
    velocities: tuple[float, ...] = ()
    accelerations: tuple[float, ...] = ()

    def end(self, number, offset=0.0):
        """End of a segment: the values of one joint."""
        return End(
            self.positions[number] + offset,
            self.velocities[number] if self.velocities else None,
            self.accelerations[number] if self.accelerations else None,
        )


@dataclass(frozen=True)
class Command:
    """A trajectory as commanded.

    Attributes:
        joints: names, in the order of the points' values.
        points: Points; none: stop where you are.
        stamp: ROS time of its start [s]; 0: at once.
    """

    joints: tuple[str, ...]
    points: tuple[Point, ...]
    stamp: float = 0.0


def check(command, joints, partial):
    """Check a command.

    Args:
        command: Command.
        joints: names of the controller's joints.
        partial: whether some of them may be missing.

    Raises:
        JointsError: other joints.
        CommandError: times that do not increase, or the wrong count of values.
    """
    known, named = set(joints), set(command.joints)
    if not named or not named <= known or len(named) != len(command.joints):
        raise JointsError(
            f"trajectory is for joints {', '.join(command.joints) or '(none)'}, must be for "
            f"{', '.join(joints)}, each once"
        )
    if named != known and not partial:
        raise JointsError(
            f"trajectory has no joint {', '.join(name for name in joints if name not in named)}, "
            "which only allow_partial_joints_goal permits"
        )
    count, before = len(command.joints), -math.inf
    for number, point in enumerate(command.points):
        for what in ("positions", "velocities", "accelerations"):
            values = getattr(point, what)
            if len(values) != count and (values or what == "positions"):
                raise CommandError(
                    f"trajectory point #{number} has {len(values)} {what}, must have {count}"
                )
            if not all(math.isfinite(value) for value in values):
                raise CommandError(
                    f"trajectory point #{number} has {what} {values}, must be finite numbers"
                )
        if not point.time > before:
            raise CommandError(
                f"trajectory point #{number} is at {point.time} s, must be after {before} s"
            )
        before = point.time


class JointsError(CommandError):
    """A trajectory names other joints than its controller has."""


def join(current, command, joints, now, ahead, continuous, goal=None, tolerances=None):
    """Each joint's segments from now on: what it does until the command starts, then the command.

    Args:
        current: lists of Segments, one a joint.
        command: a checked Command with points.
        joints: names of the controller's joints.
        now: controllers' time of the next update [s].
        ahead: time from now to the command's start [s], negative for a start in the past.
        continuous: whether each joint turns without end, and takes the shorter way.
        goal: whose command it is; None: nobody's.
        tolerances: Tolerances of the goal.

    Returns:
        Lists of Segments.

    Raises:
        CommandError: all points are in the past.
    """
    start = now + ahead
    points = [point for point in command.points if start + point.time > now]
    if not points:
        late = -(ahead + command.points[-1].time)
        raise CommandError(
            f"all {len(command.points)} points of the trajectory are in the past, "
            f"the last by {late:.3g} s"
        )
    leave, result = max(start, now), []
    for number, name in enumerate(joints):
        segments = current[number]
        if name not in command.joints:
            left = [segment for segment in segments if segment.end >= now] or segments[-1:]
            result.append([_given(segment, goal) for segment in left])
            continue
        column = command.joints.index(name)
        values = (
            (tolerances.path[number], tolerances.arrival[number], tolerances.patience)
            if tolerances is not None
            else ()
        )
        kept = [s for s in segments if s is active(segments, now) or now < s.start <= leave]
        here = End(*active(segments, leave).sample(leave))
        offset = _offset(here.position, points[0].end(column).position) * continuous[number]
        made, before, since = [], here, 0.0
        time = leave
        for point in points:
            after = point.end(column, offset)
            end = start + point.time
            made.append(Segment(time, before, end, after, goal, since, *values))
            time, before, since = end, after, point.time
        result.append(kept + made)
    return result


def _offset(here, there):
    """Whole turns [rad] that bring an angle nearest to another."""
    return here + shortest_distance(here, there) - there


def _given(segment, goal):
    """A segment that counts for another goal from now on, without tolerances."""
    given = copy.copy(segment)
    given.goal = goal
    return given


def hold(positions, now, goal=None):
    """Segments that hold positions [rad, m] from a time on."""
    return [[Segment(now, End(p), now, End(p), goal)] for p in positions]


def stop(positions, velocities, now, duration, goal=None):
    """Segments that come to rest within a duration [s].

    Each is the first half of the symmetric motion that would return with the opposite velocity.
    """
    result = []
    for position, velocity in zip(positions, velocities):
        start = End(position, velocity, 0.0)
        back = Segment(now, start, now + 2.0 * duration, End(position, -velocity, 0.0))
        rest = End(*back.sample(now + duration))
        result.append([Segment(now, start, now + duration, rest, goal)])
    return result
