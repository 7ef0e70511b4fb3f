"""Paddock/CyberTruckBacking-v1: a truck backs its trailer along a path; of Paddock/Robot-v0."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from cybertruck.trailer.geometry import TrailerError, backing_limit
from cybertruck.trailer.paths import Path
from cybertruck.trailer.shapes import SHAPES, make_shape
from gymnasium import spaces

from paddock_gym.envs.robot import RobotEnv
from paddock_gym.envs.tasks import State, Task
from paddock_gym.errors import GymError
from paddock_gym.simulation.truck import DRIVE_PERIOD, NAME, PERIODS, SETTLING, Truck, recipe

TOP_SPEED = 0.4  # [m/s] backwards and forwards
LOOKAHEADS = np.array((0.0, 0.5, 1.0, 1.5))  # where the path's curvature is observed [m]
START = (0.0, 0.0, math.pi)  # paths lead to -x, so that the trailer heads to +x
START_LATERAL, START_HEADING = 0.2, math.radians(10.0)  # largest errors at the start [m], [rad]
MAX_LATERAL, MAX_HEADING_ERROR = 1.0, math.radians(80.0)  # [m], [rad] from the path: the run ends
MARGIN = math.radians(3.0)  # of the hitch angle to the one that backing cannot undo: the run ends
END_TOLERANCE = 0.02  # [m] before the path's end
LATERAL_SCALE = 0.15  # lateral error at which a meter along the path counts 1/e of one [m]
MIN_MEAN_SPEED = 0.1  # [m/s]: a run with a lower mean speed is truncated
ARRIVED, JACKKNIFED, OFF_PATH = "arrived", "jackknifed", "lost"
RANDOM = "random"
PERIOD = PERIODS * DRIVE_PERIOD  # of an action [s]


class Backing(Task):
    """Back the trailer's axle along a path; takes the actions itself.

    Args:
        path: as of BackingEnv.

    Attributes:
        truck: Truck.
        path: of the run; arc: the trailer's arc length on it [m].
        lateral, heading_error, hitch: errors and angle of the trailer [m], [rad].
        given: lateral [m], turn, hitch [rad] of the next start, instead of random ones.
    """

    space = spaces.Box(-1.0, 1.0, (2,), np.float32)
    spaces = {"state": spaces.Box(-4.0, 4.0, (7 + len(LOOKAHEADS),), np.float32)}
    alone, feels = True, False

    def __init__(self, path: str) -> None:
        self._name, self.given = path, {}  # type: ignore[var-annotated]

    def made(self, world: Any, model: Any, variation: Any) -> Backing:
        self.truck = Truck(world)
        self._limit = backing_limit(self.truck.geometry, MARGIN)
        return self

    def rested(self, world: Any) -> None:
        self.truck.rested()

    def numbers(self, action: Any) -> tuple[float, float]:
        """Steering [rad] and speed [m/s] of an action."""
        steer, throttle = (min(1.0, max(-1.0, float(value))) for value in action)
        self._last = steer, throttle
        return steer * self.truck.geometry.max_steering, throttle * TOP_SPEED

    def drive(self, world: Any, actions: Any, numbers: Any, steps: int) -> None:
        self.truck.drive(*numbers)

    def start(self, state: State, rng: np.random.Generator) -> None:
        self.path = self._make_path(rng).moved(*START)
        lateral, turn, hitch = (
            float(self.given.get(name, rng.uniform(-limit, limit)))
            for name, limit in (
                ("lateral", START_LATERAL),
                ("turn", START_HEADING),
                ("hitch", START_HEADING),
            )
        )
        self.truck.place(0.0, -lateral, turn, hitch)  # the left of a path to -x is -y
        self._last = 0.0, 0.0
        self.arc = self.path.first_nearest(*self.truck.trailer_axle_pose()[:2], 3.0)
        self._update_errors()

    def _make_path(self, rng: np.random.Generator) -> Path:
        if self._name != RANDOM:
            return make_shape(self._name)
        side = rng.choice((-1.0, 1.0))
        choices = {
            "line": (rng.uniform(4.0, 8.0),),
            "arc": (side * rng.uniform(2.5, 5.0), rng.uniform(0.8, 2.5)),
            "lane-change": (side * rng.uniform(0.5, 1.5), rng.uniform(5.0, 7.0), 2.0),
        }
        name = rng.choice(list(choices))
        try:
            return make_shape(str(name), choices[name])
        except TrailerError:
            return make_shape("line")

    def reward(self, state: State) -> float:
        before = self.arc
        self._update_errors()
        end = self.end(state)
        reward = (self.arc - before) * math.exp(-((self.lateral / LATERAL_SCALE) ** 2))
        if end == ARRIVED:
            return reward + math.exp(-abs(self.lateral) / 0.05 - abs(self.heading_error) / 0.1)
        return reward - 1.0 if end else reward

    def _update_errors(self) -> None:
        """Update position and errors of the trailer."""
        x, y, heading = self.truck.trailer_axle_pose()
        self._position = float(x), float(y)
        self.arc = float(self.path.nearest(x, y, self.arc))
        lateral, error = self.path.errors(x, y, heading + math.pi, self.arc)
        self.lateral, self.heading_error = float(lateral), float(error)
        self.hitch = float(self.truck.hitch_angle())

    def end(self, state: State) -> str:
        if abs(self.hitch) > self._limit:
            return JACKKNIFED
        if abs(self.lateral) > MAX_LATERAL or abs(self.heading_error) > MAX_HEADING_ERROR:
            return OFF_PATH
        return ARRIVED if self.arc > self.path.length - END_TOLERANCE else ""

    def observe(self, state: State) -> Mapping[str, np.ndarray]:
        row = np.array(
            (
                self.lateral / 0.5,
                math.sin(self.heading_error),
                math.cos(self.heading_error),
                self.hitch,
                *self._last,
                min(1.0, (self.path.length - self.arc) / 3.0),
                *self.path.sample(self.arc + LOOKAHEADS)[3],
            )
        )
        return {"state": np.clip(row, -4.0, 4.0).astype(np.float32)}

    def truncates(self, state: State, end: str) -> bool:
        return not end and state.steps * PERIOD > self.path.length / MIN_MEAN_SPEED

    def info(self, state: State) -> Mapping[str, Any]:
        return {
            "lateral": self.lateral,
            "heading": self.heading_error,
            "hitch": self.hitch,
            "x": self._position[0],
            "y": self._position[1],
            "progress": 100.0 * min(1.0, max(0.0, self.arc / self.path.length)),
        }


class BackingEnv(RobotEnv):
    """Back the trailer's axle along a path.

    Actions are two numbers from -1 to 1: steering (left positive) and speed (positive forwards,
    0.4 m/s). The observation has 11 numbers: lateral error, sine and cosine of the heading error,
    hitch angle, last steering and speed, the path's curvature at 0 to 1.5 m ahead, remaining
    distance. The reward is the distance along the path, weighted by the lateral error, -1 for a run
    that failed and up to 1 for the arrival.

    Args:
        path: line, arc, s, lane-change, park, or random: one of three with random dimensions.
        render_mode: rgb_array, human, or None.

    Attributes:
        task: Backing.

    Raises:
        GymError: unknown path or render mode.
    """

    task: Backing

    def __init__(self, path: str = RANDOM, render_mode: str | None = None) -> None:
        if path not in (*SHAPES, RANDOM):
            raise GymError(f"path is {path!r}; there are {', '.join(SHAPES)}, {RANDOM}")
        super().__init__(
            recipe(),
            observation=(),
            task=Backing(path),
            vary=(),
            control_rate=1.0 / PERIOD,
            settle=SETTLING,
            robot=NAME,
            render_mode=render_mode,
        )
        self.period = PERIOD  # not rounded

    def _place(self, options: dict[str, Any]) -> None:
        """Have the next run start with lateral [m], turn, hitch [rad] instead of random ones."""
        self.task.given = options
