"""Paddock/CyberTruckBacking-v1: a truck backs its trailer along a path."""

from __future__ import annotations

import math
from typing import Any

import gymnasium
import numpy as np
from cybertruck.trailer.geometry import TrailerError, backing_limit
from cybertruck.trailer.paths import Path
from cybertruck.trailer.shapes import SHAPES, make_shape
from gymnasium import spaces

from paddock_gym.errors import GymError
from paddock_gym.simulation.truck import Truck

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


class BackingEnv(gymnasium.Env):
    """Back the trailer's axle along a path.

    Actions are two numbers from -1 to 1: steering (left positive) and speed (positive forwards,
    0.4 m/s). The observation has 11 numbers: lateral error, sine and cosine of the heading error,
    hitch angle, last steering and speed, the path's curvature at 0 to 1.5 m ahead, remaining
    distance. The reward is the distance along the path, weighted by the lateral error, -1 for a run
    that failed and up to 1 for the arrival.

    Args:
        path: line, arc, s, lane-change, park, or random: one of three with random dimensions.

    Raises:
        GymError: unknown path or render mode.
    """

    metadata = {"render_modes": [], "render_fps": 10}

    def __init__(self, path: str = RANDOM, render_mode: str | None = None) -> None:
        if path not in (*SHAPES, RANDOM):
            raise GymError(f"path is {path!r}; there are {', '.join(SHAPES)}, {RANDOM}")
        if render_mode is not None:
            raise GymError(f"render_mode is {render_mode!r}; there is only None")
        self.render_mode, self._name = None, path
        self.action_space = spaces.Box(-1.0, 1.0, (2,), np.float32)
        self.observation_space = spaces.Box(-4.0, 4.0, (7 + len(LOOKAHEADS),), np.float32)
        self.truck = Truck()
        self._limit = backing_limit(self.truck.geometry, MARGIN)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[np.ndarray, dict[str, Any]]:
        """Put the truck at the start of a path.

        Args:
            seed: of path and start.
            options: lateral [m], turn, hitch [rad] instead of random ones; or None.
        """
        super().reset(seed=seed)
        rng, start_values = self.np_random, options or {}
        self.path = self._make_path(rng).moved(*START)
        lateral, turn, hitch = (
            float(start_values.get(name, rng.uniform(-limit, limit)))
            for name, limit in (
                ("lateral", START_LATERAL),
                ("turn", START_HEADING),
                ("hitch", START_HEADING),
            )
        )
        self.truck.place(0.0, -lateral, turn, hitch)  # the left of a path to -x is -y
        self._last, self._steps = (0.0, 0.0), 0
        self.arc = self.path.first_nearest(*self.truck.trailer_axle_pose()[:2], 3.0)
        self._update_errors()
        return self._observe(), self._info("")

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

    def step(self, action: Any) -> tuple[np.ndarray, float, bool, bool, dict[str, Any]]:
        """Drive for one action."""
        steer, throttle = (min(1.0, max(-1.0, float(value))) for value in action)
        self.truck.drive(steer * self.truck.geometry.max_steering, throttle * TOP_SPEED)
        self._last, before = (steer, throttle), self.arc
        self._steps += 1
        self._update_errors()
        end = self._end_reason()
        reward = (self.arc - before) * math.exp(-((self.lateral / LATERAL_SCALE) ** 2))
        if end == ARRIVED:
            reward += math.exp(-abs(self.lateral) / 0.05 - abs(self.heading_error) / 0.1)
        elif end:
            reward -= 1.0
        slow = self._steps * self.truck.period > self.path.length / MIN_MEAN_SPEED
        return self._observe(), float(reward), bool(end), bool(slow and not end), self._info(end)

    def _update_errors(self) -> None:
        """Update position and errors of the trailer."""
        x, y, heading = self.truck.trailer_axle_pose()
        self._position = float(x), float(y)
        self.arc = float(self.path.nearest(x, y, self.arc))
        lateral, error = self.path.errors(x, y, heading + math.pi, self.arc)
        self.lateral, self.heading_error = float(lateral), float(error)
        self.hitch = float(self.truck.hitch_angle())

    def _end_reason(self) -> str:
        if abs(self.hitch) > self._limit:
            return JACKKNIFED
        if abs(self.lateral) > MAX_LATERAL or abs(self.heading_error) > MAX_HEADING_ERROR:
            return OFF_PATH
        return ARRIVED if self.arc > self.path.length - END_TOLERANCE else ""

    def _observe(self) -> np.ndarray:
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
        return np.clip(row, -4.0, 4.0).astype(np.float32)

    def _info(self, end: str) -> dict[str, Any]:
        return {
            "end": end,
            "lateral": self.lateral,
            "heading": self.heading_error,
            "hitch": self.hitch,
            "x": self._position[0],
            "y": self._position[1],
            "time": self._steps * self.truck.period,
            "progress": 100.0 * min(1.0, max(0.0, self.arc / self.path.length)),
        }

    def close(self) -> None:
        """Free the engine."""
        self.truck.close()
