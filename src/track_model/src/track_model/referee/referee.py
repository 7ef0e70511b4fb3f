"""The referee: rules, laps, penalties."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt
from paddock_common.settings import Checked, choice, flag, number
from shapely.geometry import Polygon, box
from shapely.ops import unary_union
from shapely.prepared import prep

from track_model.referee.course import Course


@dataclass(frozen=True)
class Rules(Checked):
    """Rules of the referee.

    Attributes:
        off_track: 'all': the car is off when all four wheels are outside the lane (the DeepRacer
            league's rule), 'one': when one is.
        off_track_penalty, collision_penalty: added per excursion and per crash [s]; 5 s each, as in
            the DeepRacer community's evaluation template.
        stuck_time: time without progress during a lap after which the car is stuck [s].
        stuck_distance: progress after which it is no longer stuck [m].
        wrong_way_distance: distance driven backwards beyond which the direction is wrong [m].
        standing_start: a car that is first up to this far behind the line [m] starts its first lap
            when it first moves; any other one when it crosses the line.
        auto_reset: put the car back on the track when it is off the track, crashed or stuck.
    """

    off_track: str = choice("all", ("all", "one"))
    off_track_penalty: float = number(5.0, min=0.0, unit="s")
    collision_penalty: float = number(5.0, min=0.0, unit="s")
    stuck_time: float = number(5.0, min=0.0, unit="s")
    stuck_distance: float = number(0.05, min=0.0, unit="m")
    wrong_way_distance: float = number(0.3, min=0.0, unit="m")
    standing_start: float = number(0.2, min=0.0, unit="m")
    auto_reset: bool = flag(False)


@dataclass(frozen=True)
class Car(Checked):
    """Wheel and corner positions, from the reference point (base_link) [m].

    Attributes:
        front, rear: x of the axles.
        front_half_track, rear_half_track: y of the wheels' centers.
        nose, tail: x of the outline's ends.
        half_width: half the width of the outline.
    """

    front: float = number(0.082311, unit="m")
    rear: float = number(-0.081663, unit="m")
    front_half_track: float = number(0.079601, unit="m")
    rear_half_track: float = number(0.08105, unit="m")
    nose: float = number(0.16, unit="m")
    tail: float = number(-0.13, unit="m")
    half_width: float = number(0.0945, unit="m")

    @property
    def wheels(self) -> tuple[tuple[float, float], ...]:
        """((x, y), ...) of front left, front right, rear left, rear right."""
        axles = (self.front, self.front_half_track), (self.rear, self.rear_half_track)
        return tuple((x, side * y) for x, y in axles for side in (1, -1))

    @property
    def corners(self) -> tuple[tuple[float, float], ...]:
        """((x, y), ...) of the outline, counter-clockwise."""
        return (
            (self.nose, self.half_width),
            (self.tail, self.half_width),
            (self.tail, -self.half_width),
            (self.nose, -self.half_width),
        )


MOVING = 0.02  # speed that counts as moving [m/s]
JUMP = 0.25  # distance between two poses beyond which a service has moved the car [m]


@dataclass(frozen=True)
class Status:
    """Status of a run; see LapStatus.msg for units."""

    time: float = 0.0
    progress: float = 0.0
    distance: float = 0.0
    arc_length: float = 0.0
    lateral_error: float = 0.0
    speed: float = 0.0
    laps: int = 0
    lap_time: float = 0.0
    last_lap_time: float = 0.0
    best_lap_time: float = 0.0
    penalty: float = 0.0
    running: bool = False
    wheels_off: tuple[bool, ...] = (False,) * 4
    off_track: bool = False
    wrong_way: bool = False
    stuck: bool = False
    crashed: bool = False


def wall_polygons(
    boxes: Iterable[tuple[float, float, float, float]], thickness: float
) -> list[Polygon]:
    """Return shapely polygons of wall boxes (x, y, yaw, length) [m], [rad]."""
    half = thickness / 2.0
    return [
        Polygon(placed(tuple(box(-length / 2.0, -half, length / 2.0, half).exterior.coords), *pose))
        for *pose, length in boxes
    ]


def placed(
    points: tuple[tuple[float, float], ...], x: float, y: float, yaw: float
) -> npt.NDArray[Any]:
    """Points (n, 2) of a car, where its reference point is at a pose."""
    rotation = np.array(((math.cos(yaw), -math.sin(yaw)), (math.sin(yaw), math.cos(yaw))))
    return np.array(points) @ rotation.T + (x, y)


class Referee:
    """Evaluates one car on one course."""

    def __init__(
        self,
        course: Course,
        walls: Iterable[Polygon] = (),
        rules: Rules = Rules(),
        car: Car = Car(),
    ) -> None:
        self.course, self.rules, self.car = course, rules, car
        obstacles = list(walls)
        self._walls = prep(unary_union(obstacles)) if obstacles else None
        self.restart()

    def restart(self) -> None:
        """Restart the run, as after a reset of the simulation."""
        self.status = Status()
        self._previous: tuple[float, float, float, float] | None = None  # time, x, y, arc length
        self._waiting_at_start = False
        self._lap_start: float | None = None  # time [s]
        self._distance = self._max_distance = 0.0  # along the course since the first start [m]
        self._lap_offset = 0.0  # part of it before this lap
        self._stuck_since: float | None = None
        self._stuck_distance = 0.0

    def update(
        self, time: float, x: float, y: float, yaw: float, speed: float
    ) -> tuple[Status, list[str]]:
        """Update with the car's ground truth.

        Args:
            time: [s], increasing.
            x, y, yaw: reference point in the track's frame [m], [rad].
            speed: forward [m/s].

        Returns:
            (Status, list of events: 'start', 'lap', 'off_track', 'crash', 'wrong_way', 'stuck').
        """
        events: list[str] = []
        s, lateral = self._locate(time, x, y, speed, events)
        old, rules = self.status, self.rules
        wheels = ~self.course.contains(placed(self.car.wheels, x, y, yaw))
        off = bool(wheels.all() if rules.off_track == "all" else wheels.any())
        off &= self.course.closed or not old.laps  # behind the finish of an open course none is
        crashed = self._touches(placed(self.car.corners, x, y, yaw))
        wrong, stuck = self._check_progress(time)
        penalty = old.penalty
        for name, now, before, cost in (
            ("off_track", off, old.off_track, rules.off_track_penalty),
            ("crash", crashed, old.crashed, rules.collision_penalty),
            ("wrong_way", wrong, old.wrong_way, 0.0),
            ("stuck", stuck, old.stuck, 0.0),
        ):
            if now and not before:
                events.append(name)
                penalty += cost
        running = self._lap_start is not None
        self.status = replace(
            old,
            time=time,
            arc_length=s,
            lateral_error=lateral,
            speed=speed,
            distance=self._distance,
            progress=self._progress() if running else 0.0,
            running=running,
            lap_time=0.0 if self._lap_start is None else time - self._lap_start,
            penalty=penalty,
            wheels_off=tuple(map(bool, wheels)),
            off_track=off,
            wrong_way=wrong,
            stuck=stuck,
            crashed=crashed,
        )
        return self.status, events

    def _locate(
        self, time: float, x: float, y: float, speed: float, events: list[str]
    ) -> tuple[float, float]:
        """Project the car onto the course and update its distance; starts and finishes laps.

        Returns:
            (arc length, distance to the left of the centreline) [m].
        """
        if self._previous is not None and time < self._previous[0]:
            self.restart()
        s, lateral = self.course.locate(x, y, None if self._previous is None else self._previous[3])
        if self._previous is not None and math.dist((x, y), self._previous[1:3]) > JUMP:
            s, lateral = self.course.locate(x, y)  # a service has moved it
            self._previous = None
        if self._previous is None:
            self._waiting_at_start = (
                not self.status.running and 0.0 <= s < self.rules.standing_start
            )
        else:
            self._move(time, x, y, s, speed, events)
        self._previous = (time, x, y, s)
        return s, lateral

    def _progress(self) -> float:
        return max(
            0.0, min(100.0, 100.0 * (self._distance - self._lap_offset) / self.course.length)
        )

    def _move(
        self, time: float, x: float, y: float, s: float, speed: float, events: list[str]
    ) -> None:
        """Update the progress since the last pose; starts and finishes laps."""
        assert self._previous is not None
        before_time, _, _, before = self._previous
        step = self.course.difference(s, before)
        self._waiting_at_start &= 0.0 <= s < self.rules.standing_start
        if self._waiting_at_start and speed > MOVING:
            self._start(before_time, events)
            self._lap_offset = -before
        crossing = self._crossing(0.0, time, x, y, step)
        if crossing is not None and self.course.closed:
            self._cross(crossing, events)
        elif crossing is not None and self._lap_start is None and not self.status.laps:
            self._start(crossing, events)
        if not self.course.closed and self._lap_start is not None:
            finish = self._crossing(self.course.length, time, x, y, step)
            if finish is not None:
                self._finish(finish, events)
                self._lap_start = None
        if self._lap_start is not None:
            self._distance += step

    def _cross(self, time: float, events: list[str]) -> None:
        if self._lap_start is None:
            self._start(time, events)
        # reversing over the line and crossing it again does not count
        elif self._distance > self.course.length * (self.status.laps + 0.5):
            self._finish(time, events)
            self._lap_start, self._lap_offset = time, self._distance

    def _crossing(self, s: float, time: float, x: float, y: float, step: float) -> float | None:
        """Return the time [s] at which the line at arc length s was crossed forwards, or None."""
        if self._previous is None or not 0.0 < step < 0.5:
            return None
        before_time, before_x, before_y, _ = self._previous
        line_x, line_y, yaw = self.course.pose(s)
        ahead = np.array((math.cos(yaw), math.sin(yaw)))
        old = float(np.dot((before_x - line_x, before_y - line_y), ahead))
        new = float(np.dot((x - line_x, y - line_y), ahead))
        if not old < 0.0 <= new or math.dist((x, y), (line_x, line_y)) > 1.5:
            return None
        return before_time + (time - before_time) * old / (old - new)

    def _start(self, time: float, events: list[str]) -> None:
        self._lap_start = time
        self._distance = self._max_distance = self._lap_offset = 0.0
        self._waiting_at_start = False
        events.append("start")

    def _finish(self, time: float, events: list[str]) -> None:
        assert self._lap_start is not None
        lap = time - self._lap_start
        best = self.status.best_lap_time
        self.status = replace(
            self.status,
            laps=self.status.laps + 1,
            last_lap_time=lap,
            best_lap_time=min(best, lap) if best else lap,
        )
        events.append("lap")

    def _touches(self, corners: npt.NDArray[Any]) -> bool:
        return self._walls is not None and self._walls.intersects(Polygon(corners))

    def _check_progress(self, time: float) -> tuple[bool, bool]:
        """Return (wrong way, stuck) from the progress along the course."""
        if self._lap_start is None:
            self._stuck_since = None
            return False, False
        self._max_distance = max(self._max_distance, self._distance)
        wrong = self._max_distance - self._distance > self.rules.wrong_way_distance
        if (
            self._stuck_since is None
            or abs(self._distance - self._stuck_distance) > self.rules.stuck_distance
        ):
            self._stuck_since, self._stuck_distance = time, self._distance
        return bool(wrong), bool(time - self._stuck_since >= self.rules.stuck_time)

    def put_back_pose(self) -> tuple[float, float, float]:
        """Return (x, y, yaw) on the centreline at the car's current arc length."""
        return self.course.pose(self.status.arc_length)
