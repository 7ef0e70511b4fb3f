"""A run along a course: motion, obstacles, progress and why it ended.

The rules are AWS DeepRacer's: a run ends when all four wheels are off the lane, after a crash,
after a full lap, and when the car makes no progress or reverses.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from track_model.referee.course import Course
from track_model.referee.referee import Car


class Motion(NamedTuple):
    """Motion of base_link in the track's frame.

    Attributes:
        x, y: [m].
        yaw: [rad].
        forward, leftward: velocity along the car's axes [m/s].
        yaw_rate: [rad/s].
    """

    x: float
    y: float
    yaw: float
    forward: float
    leftward: float
    yaw_rate: float


def motion_from(
    position: Sequence[float],
    quaternion: Sequence[float],
    linear: Sequence[float],
    angular: Sequence[float],
) -> Motion:
    """Motion of a link from its state in the world.

    Args:
        position: (3,) [m].
        quaternion: (x, y, z, w).
        linear, angular: (3,) [m/s], [rad/s], along the world's axes.

    Returns:
        Motion with velocities along the link's axes as in nav_msgs/Odometry.
    """
    x, y, z, w = quaternion
    u, v, up = linear
    return Motion(
        position[0],
        position[1],
        math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z)),
        (1.0 - 2.0 * (y * y + z * z)) * u + 2.0 * (x * y + z * w) * v + 2.0 * (x * z - y * w) * up,
        2.0 * (x * y - z * w) * u + (1.0 - 2.0 * (x * x + z * z)) * v + 2.0 * (y * z + x * w) * up,
        angular[2],
    )


RACES = {"time_trial": "", "object_avoidance": "boxes", "head_to_bot": "bots"}
OBSERVED_OBJECTS = 2  # objects ahead in the observation `state`
MAX_OBJECT_DISTANCE = 4.0  # [m] along the course to an observed object


class TrackObject(NamedTuple):
    """An object on the track.

    Attributes:
        x, y, yaw: pose [m], [rad].
        s: arc length of its projection [m].
        lateral: distance to the left of the centreline [m].
        speed: along the course [m/s].
    """

    x: float
    y: float
    yaw: float
    s: float
    lateral: float
    speed: float


def next_objects(objects: Iterable[TrackObject], s: float, course: Course) -> np.ndarray:
    """The next objects ahead.

    Args:
        s: arc length of the car [m].

    Returns:
        (2 * SEEN,) float32: distance along the course / FARTHEST (1: none), distance to the left of
        the centreline / half lane, closest first.
    """
    row = np.tile(np.array((1.0, 0.0), dtype=np.float32), OBSERVED_OBJECTS)
    ahead = sorted(((obj.s - s) % course.length, obj.lateral) for obj in objects)
    for index, (distance, lateral) in enumerate(ahead[:OBSERVED_OBJECTS]):
        if distance < MAX_OBJECT_DISTANCE:
            half = sum(course.sides(s)) / 2.0
            row[2 * index : 2 * index + 2] = distance / MAX_OBJECT_DISTANCE, lateral / half
    return np.clip(row, -1.0, 1.0)


STUCK_STEPS = 15  # actions without progress
STUCK_DISTANCE = 0.03  # progress within them below which the car is stuck [m]
MAX_REVERSE = 0.3  # distance driven backwards that ends a run [m], as the referee's
LAP, OFF_TRACK, CRASHED, STUCK, REVERSED = "lap", "off_track", "crashed", "stuck", "reversed"
RUNNING = ""


@dataclass
class RunState:
    """Where a car is, and how its run goes.

    Attributes:
        s: arc length of base_link's projection [m].
        lateral: distance to the left of the centreline [m].
        heading: direction of the centreline there [rad].
        heading_error: the car's heading against it, -pi to pi [rad].
        left, right: from the centreline to the lane's edges there [m].
        wheels_off: of front left, front right, rear left, rear right: whether off the lane.
        distance: driven along the course since the start [m].
        gain: of it, since the last action [m].
        progress: fraction of the full distance [%].
        steps: actions so far.
        end: why the run ended, "" while it runs.
    """

    __slots__ = (
        *("s", "lateral", "heading", "heading_error", "left", "right", "wheels_off"),
        *("distance", "gain", "progress", "steps", "end"),
    )

    s: float
    lateral: float
    heading: float
    heading_error: float
    left: float
    right: float
    wheels_off: tuple[bool, ...]
    distance: float
    gain: float
    progress: float
    steps: int
    end: str

    @property
    def all_wheels_on(self) -> bool:
        """Whether no wheel is off the lane."""
        return not any(self.wheels_off)

    @property
    def off_track(self) -> bool:
        """Whether all wheels are off the lane."""
        return all(self.wheels_off)


PER_METER, FAILURE = 1.0, -3.0  # of the reward `progress`


def progress(state: RunState) -> float:
    """Meters along the course since the last action, and a penalty for a run that failed."""
    failed = state.end not in (RUNNING, LAP)
    return PER_METER * state.gain + (FAILURE if failed else 0.0)


class RunEvaluator:
    """Evaluates the run of one car, action by action."""

    def __init__(self, course: Course, car: Car = Car()) -> None:
        self.course = course
        self._wheels = car.wheels  # from base_link

    def start(self, motion: Motion) -> RunState:
        """Start a run at the car's pose."""
        self._s = self.course.locate(motion.x, motion.y)[0]
        lateral = self.course.project_point(motion.x, motion.y, self._s)[1]
        self._distance = self._best = 0.0
        self._steps = 0
        length = self.course.length
        self._goal = length if self.course.closed else max(length - self._s, 1e-6)
        self._past = deque([0.0], maxlen=STUCK_STEPS + 1)
        return self._state(motion, lateral, 0.0, False)

    def update(self, motion: Motion, crashed: bool = False) -> RunState:
        """Evaluate after one more action."""
        s, lateral = self.course.project_point(motion.x, motion.y, self._s)
        gain = self.course.difference(s, self._s)
        self._s = s
        self._distance += gain
        self._best = max(self._best, self._distance)
        self._past.append(self._best)
        self._steps += 1
        return self._state(motion, lateral, gain, crashed)

    def _state(self, motion: Motion, lateral: float, gain: float, crashed: bool) -> RunState:
        heading = self.course.heading(self._s)
        error = math.remainder(motion.yaw - heading, 2.0 * math.pi)
        wheels_off = self._wheels_off(lateral, error)
        left, right = self.course.sides(self._s)
        return RunState(
            self._s,
            lateral,
            heading,
            error,
            float(left),
            float(right),
            wheels_off,
            self._distance,
            gain,
            min(100.0, max(0.0, 100.0 * self._distance / self._goal)),
            self._steps,
            self._end_reason(all(wheels_off), crashed),
        )

    def _wheels_off(self, lateral: float, error: float) -> tuple[bool, ...]:
        """Whether each wheel is off the lane, which is an arc over the length of a car."""
        curvature, course = self.course.point_curvature(self._s), self.course
        c, s = math.cos(error), math.sin(error)
        off = []
        for x, y in self._wheels:
            along, aside = c * x - s * y, lateral + s * x + c * y
            if abs(curvature) > 1e-6:
                # in radii of the lane
                radius = math.hypot(curvature * along, 1.0 - curvature * aside)
                aside = (1.0 - radius) / curvature
            left, right = course.uniform_sides or course.sides(self._s + along)
            off.append(not -right <= aside <= left)
        return tuple(off)

    def _end_reason(self, off: bool, crashed: bool) -> str:
        if crashed:
            return CRASHED
        if off:
            return OFF_TRACK
        if self._distance >= self._goal - (0.0 if self.course.closed else 0.02):
            return LAP
        if self._best - self._distance > MAX_REVERSE:
            return REVERSED
        if len(self._past) > STUCK_STEPS and self._past[-1] - self._past[0] < STUCK_DISTANCE:
            return STUCK
        return RUNNING
