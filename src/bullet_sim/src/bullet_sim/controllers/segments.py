"""Trajectories of joints: splines, tolerances, how a command replaces what is left of one."""

from __future__ import annotations

import copy
import math
from collections.abc import Callable, Sequence
from dataclasses import astuple, dataclass, field, replace
from functools import partial
from typing import Any, Iterable, Tuple

from bullet_sim.component import Stateful
from bullet_sim.controllers.pid import shortest_distance
from bullet_sim.errors import CommandError


@dataclass(frozen=True)
class Tolerance:
    """Bounds of a joint's errors [rad, m, and per s, s^2]; 0: none."""

    position: float = 0.0
    velocity: float = 0.0
    acceleration: float = 0.0

    def holds(self, position: float, velocity: float) -> bool:
        """Whether errors of position and velocity are within; accelerations are not measured."""
        return not (abs(position) > self.position > 0.0 or abs(velocity) > self.velocity > 0.0)

    def updated(self, other: Tolerance) -> Tolerance:
        """With another's bounds: above 0 they replace, below 0 they remove, 0 leaves these."""
        return Tolerance(
            *(
                theirs if theirs > 0.0 else 0.0 if theirs < 0.0 else own
                for own, theirs in zip(astuple(self), astuple(other))
            )
        )


NO_TOLERANCE = Tolerance()
NamedTolerances = Iterable[Tuple[str, Tolerance]]  # by joint name


@dataclass(frozen=True)
class Tolerances:
    """Tolerances of a full trajectory.

    Attributes:
        path, arrival: a Tolerance of each joint along the path and at the end.
        goal_time_tolerance: time after the end to get within `arrival` [s].
    """

    path: tuple[Tolerance, ...]
    arrival: tuple[Tolerance, ...]
    goal_time_tolerance: float = 0.0

    def updated(
        self,
        joints: Sequence[str],
        path: NamedTolerances,
        arrival: NamedTolerances,
        goal_time_tolerance: float,
    ) -> Tolerances:
        """With those of a goal.

        Args:
            path, arrival: (joint name, Tolerance) pairs.
            goal_time_tolerance: above 0 it replaces, below 0 it is 0, 0 leaves the present one [s].
        """
        changed = []
        for own, pairs in ((self.path, path), (self.arrival, arrival)):
            mine = dict(zip(joints, own))
            for name, tolerance in pairs:
                if name in mine:
                    mine[name] = mine[name].updated(tolerance)
            changed.append(tuple(mine.values()))
        wait = (
            self.goal_time_tolerance if goal_time_tolerance == 0 else max(0.0, goal_time_tolerance)
        )
        return replace(self, path=changed[0], arrival=changed[1], goal_time_tolerance=wait)


@dataclass(frozen=True)
class End:
    """An end of a segment: position [rad, m], velocity and acceleration, None where not given."""

    position: float
    velocity: float | None = None
    acceleration: float | None = None


class Segment:
    """A polynomial of time between two ends.

    Linear where one end has no velocity, cubic where both have one, of the fifth degree where both
    have accelerations, too: the lowest degree that has these values at its ends. A segment without
    duration is at its first end.

    Args:
        start, end: times [s].
        goal: that it belongs to; None: no goal.
        from_start: time of the first end since the start of its trajectory [s].
        path, arrival: Tolerances along it and of its end.
        goal_time_tolerance: time after its end to get within `arrival` [s].
    """

    def __init__(
        self,
        start: float,
        first: End,
        end: float,
        last: End,
        goal: Goal | None = None,
        from_start: float = 0.0,
        path: Tolerance = NO_TOLERANCE,
        arrival: Tolerance = NO_TOLERANCE,
        goal_time_tolerance: float = 0.0,
    ) -> None:
        self.start, self.end = start, end
        self.goal, self.from_start = goal, from_start
        self.path, self.arrival, self.goal_time_tolerance = path, arrival, goal_time_tolerance
        self._coefficients = _coefficients(first, last, end - start)

    def sample(self, time: float) -> tuple[float, float, float]:
        """Position, velocity and acceleration at a time; at rest before and after it."""
        duration = self.end - self.start
        t = min(max(time - self.start, 0.0), duration)
        position = velocity = acceleration = 0.0
        for c in reversed(self._coefficients):
            acceleration = acceleration * t + 2.0 * velocity
            velocity = velocity * t + position
            position = position * t + c
        if not 0.0 <= time - self.start <= duration:
            return position, 0.0, 0.0
        return position, velocity, acceleration


def _coefficients(first: End, last: End, duration: float) -> tuple[float, ...]:
    """Of 1, t, t^2 ... for a segment's ends."""
    p, distance = first.position, last.position - first.position
    if duration <= 0.0:
        return (p,)
    if first.velocity is None or last.velocity is None:
        return p, distance / duration
    # in units of the duration: what is left beyond the start's motion
    u, v = first.velocity * duration, last.velocity * duration
    if first.acceleration is None or last.acceleration is None:
        scaled: tuple[float, ...] = (p, u, 3.0 * distance - 2.0 * u - v, u + v - 2.0 * distance)
    else:
        a, b = first.acceleration * duration**2 / 2.0, last.acceleration * duration**2 / 2.0
        scaled = (
            p,
            u,
            a,
            10.0 * distance - 6.0 * u - 4.0 * v - 3.0 * a + b,
            -15.0 * distance + 8.0 * u + 7.0 * v + 3.0 * a - 2.0 * b,
            6.0 * distance - 3.0 * u - 3.0 * v - a + b,
        )
    return tuple(c / duration**n for n, c in enumerate(scaled))


class Course:
    """Segments of one joint in the order of their starts, each made when it is first asked for:
    a trajectory may have very many points.

    Args:
        before: those that come first.
        count: number of the others.
        make: from the number of one of these to the Segment.
    """

    def __init__(
        self,
        before: Iterable[Segment],
        count: int = 0,
        make: Callable[[int], Segment] | None = None,
    ) -> None:
        self._made: list[Segment | None] = list(before)
        self._first, self._make = len(self._made), make
        self._made += [None] * count

    def __len__(self) -> int:
        return len(self._made)

    def __getitem__(self, place: int) -> Segment:
        segment = self._made[place]
        if segment is None:
            assert self._make is not None
            segment = self._made[place] = self._make(range(len(self))[place] - self._first)
        return segment

    def place(self, time: float) -> int:
        """Which one acts at a time: the last that has started, or the first."""
        low, high = 0, len(self)
        while low < high:
            middle = (low + high) // 2
            if self[middle].start <= time:
                low = middle + 1
            else:
                high = middle
        return max(low - 1, 0)

    def active(self, time: float) -> Segment:
        """The segment that acts at a time, see place()."""
        return self[self.place(time)]


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

    def end(self, index: int, offset: float = 0.0) -> End:
        """End of a segment: the values of one joint."""
        return End(
            self.positions[index] + offset,
            self.velocities[index] if self.velocities else None,
            self.accelerations[index] if self.accelerations else None,
        )


@dataclass(frozen=True)
class Command:
    """A trajectory as commanded.

    Attributes:
        joints: names, in the order of the points' values.
        points: Points; none: stop where the joints are.
        stamp: ROS time of its start [s]; 0: immediately.
    """

    joints: tuple[str, ...]
    points: tuple[Point, ...]
    stamp: float = 0.0


def check(command: Command, joints: Sequence[str], partial: bool) -> None:
    """Check a command.

    Args:
        partial: whether some of them may be missing.

    A point may have more values than there are names, as upstream; they are not used.

    Raises:
        JointsError: other joints.
        CommandError: times that do not increase, or the wrong count of values.
    """
    known, named = set(joints), set(command.joints)
    if not named or not named <= known or len(named) != len(command.joints):
        raise JointsError(
            f"{JOINTS} It is for {', '.join(command.joints) or '(none)'}, must be for "
            f"{', '.join(joints)}, each once"
        )
    if named != known and not partial:
        raise JointsError(
            f"{JOINTS} It lacks {', '.join(name for name in joints if name not in named)}, "
            "which only allow_partial_joints_goal permits"
        )
    count, before = len(command.joints), -math.inf
    for index, point in enumerate(command.points):
        given = len(point.positions)
        if given < count:
            raise CommandError(
                f"{SIZES} Point #{index} has {given} positions, must have at least {count}"
            )
        for quantity in ("positions", "velocities", "accelerations"):
            values = getattr(point, quantity)
            if values and len(values) != given:
                raise CommandError(
                    f"{SIZES} Point #{index} has {len(values)} {quantity}, must have {given} as it "
                    "has positions"
                )
            if not all(math.isfinite(value) for value in values):
                raise CommandError(
                    f"trajectory point #{index} has {quantity} {values}, must be finite numbers"
                )
        if not point.time > before:
            raise CommandError(
                "Trajectory message contains waypoints that are not strictly increasing in time. "
                f"Point #{index} is at {point.time} s, must be after {before} s"
            )
        before = point.time


# In the words of joint_trajectory_controller.
SIZES = "Size mismatch in trajectory point position, velocity or acceleration data."
JOINTS = "Cannot create trajectory from message. It does not contain the expected joints."


class JointsError(CommandError):
    """A trajectory names other joints than its controller has."""


def join(
    current: Sequence[Course],
    command: Command,
    joints: Sequence[str],
    now: float,
    ahead: float,
    continuous: Sequence[bool],
    goal: Goal | None = None,
    tolerances: Tolerances | None = None,
) -> list[Course]:
    """Each joint's segments from now on: what it does until the command starts, then the command.

    Args:
        now: controllers' time of the next update [s].
        ahead: time from now to the command's start [s], negative for a start in the past.
        continuous: whether each joint rotates without limits, and takes the shorter direction.

    Raises:
        CommandError: all points are in the past.
    """
    start = now + ahead
    points = [point for point in command.points if start + point.time > now]
    if not points:
        late = -(ahead + command.points[-1].time)
        raise CommandError(
            f"Dropping all {len(command.points)} trajectory point(s), as they occur before the "
            f"current time.\nLast point is {late:f}s in the past."
        )
    leave = max(start, now)
    result: list[Course] = []
    for index, name in enumerate(joints):
        course = current[index]
        present = course.place(now)
        if name not in command.joints:
            left = range(present, len(course))
            result.append(Course(_for_goal(course[place], goal) for place in left))
            continue
        bounds: tuple[Any, ...] = (
            (tolerances.path[index], tolerances.arrival[index], tolerances.goal_time_tolerance)
            if tolerances is not None
            else ()
        )
        here, column = End(*course.active(leave).sample(leave)), command.joints.index(name)
        offset = _offset(here.position, points[0].end(column).position) * continuous[index]
        values = points, column, offset, start, (leave, here), goal, bounds
        remaining = [course[place] for place in range(present, course.place(leave) + 1)]
        result.append(Course(remaining, len(points), partial(_segment_to, *values)))
    return result


def _segment_to(
    points: Sequence[Point], column: int, offset: float, start: float, here: tuple[float, End],
    goal: Goal | None, bounds: tuple[Any, ...], number: int,
) -> Segment:  # fmt: skip
    """Segment of a joint to a point of a trajectory, from the one before or from `here`.

    Args:
        column: of the joint in the points, to which `offset` is added.
        start: of the trajectory [s]; here: time [s] and End where the first segment begins.
        bounds: tolerances, as Segment takes them.
    """
    time, before, since = *here, 0.0
    if number > 0:
        since = points[number - 1].time
        time, before = start + since, points[number - 1].end(column, offset)
    end = points[number].end(column, offset)
    return Segment(time, before, start + points[number].time, end, goal, since, *bounds)


HALF_TURN = 1e-9  # [rad] from pi up to which both directions count as equally long


def _offset(here: float, there: float) -> float:
    """Full rotations [rad] that bring an angle closest to another.

    Of two directions of pi each it is that in which the numbers grow or fall, as in
    joint_trajectory_segment.h.
    """
    distance = shortest_distance(here, there)
    if abs(abs(distance) - math.pi) < HALF_TURN:
        distance = math.copysign(distance, there - here)
    return here + distance - there


def _for_goal(segment: Segment, goal: Goal | None) -> Segment:
    """A segment that counts for another goal from now on, without tolerances."""
    copied = copy.copy(segment)
    copied.goal = goal
    return copied


def hold(positions: Iterable[float], now: float, goal: Goal | None = None) -> list[Course]:
    """Courses that hold positions [rad, m] from a time on."""
    return [Course([Segment(now, End(p), now, End(p), goal)]) for p in positions]


def stop(
    positions: Iterable[float],
    velocities: Iterable[float],
    now: float,
    duration: float,
    goal: Goal | None = None,
) -> list[Course]:
    """Courses that come to rest within a duration [s].

    Each is the first half of the symmetric motion that would return with the opposite velocity.
    """
    result = []
    for position, velocity in zip(positions, velocities):
        start = End(position, velocity, 0.0)
        back = Segment(now, start, now + 2.0 * duration, End(position, -velocity, 0.0))
        rest = End(*back.sample(now + duration))
        result.append(Course([Segment(now, start, now + duration, rest, goal)]))
    return result


SUCCESSFUL, PATH_VIOLATED, GOAL_VIOLATED = 0, -4, -5  # of control_msgs/FollowJointTrajectoryResult


@dataclass(eq=False)
class Goal(Stateful):
    """A goal of the action.

    Attributes:
        path, arrival: (joint name, Tolerance) pairs that differ from the configuration.
        goal_time_tolerance: of the action's goal [s], see Tolerances.updated.
        finished: called once with (outcome, code, text): "succeeded", "aborted" or "canceled".
        arrived: joints that were within their tolerance at the end.
    """

    STATE = ("arrived",)

    finished: Callable[[str, int, str], object]
    path: tuple[tuple[str, Tolerance], ...] = ()
    arrival: tuple[tuple[str, Tolerance], ...] = ()
    goal_time_tolerance: float = 0.0
    arrived: set[str] = field(default_factory=set)


@dataclass
class Motion:
    """Positions, velocities, accelerations of all joints, and the time since a segment's start."""

    positions: list[float]
    velocities: list[float]
    accelerations: Sequence[float] = ()
    from_start: float = 0.0


def motion_at(segments: Iterable[Segment], time: float) -> Motion:
    """The motion along a segment of each joint."""
    positions, velocities, accelerations = zip(*(segment.sample(time) for segment in segments))
    return Motion(list(positions), list(velocities), list(accelerations))
