"""Paddock/CyberTruckBacking-v0: a truck backs its trailer along a path."""

import math

import gymnasium
import numpy as np
from cybertruck.trailer.geometry import TrailerError, backing_limit
from cybertruck.trailer.shapes import SHAPES, make_shape
from gymnasium import spaces

from paddock_gym.errors import GymError
from paddock_gym.simulation.rig import Rig

TOP_SPEED = 0.4  # [m/s] backwards and forwards
AHEAD = np.array((0.0, 0.5, 1.0, 1.5))  # where the path's curvature is told [m]
START = (0.0, 0.0, math.pi)  # paths lead to -x, so that the trailer heads to +x
LATERAL, TURN = 0.2, math.radians(10.0)  # largest errors at the start [m], [rad]
LOST, LOST_TURN = 1.0, math.radians(80.0)  # [m], [rad] from the path: the run ends
MARGIN = math.radians(3.0)  # before the angle from which backing cannot undo it: the run ends
END = 0.02  # [m] before the path's end
NEAR = 0.15  # lateral error at which a metre along the path counts 1/e of one [m]
SLOWEST = 0.1  # [m/s]: mean speed below which a run is cut off
ARRIVED, JACKKNIFED, LOST_PATH = "arrived", "jackknifed", "lost"
RANDOM = "random"


class BackingEnv(gymnasium.Env):
    """Back the trailer's axle along a path.

    Actions are two numbers from -1 to 1: steering (left positive) and speed (positive forwards,
    0.4 m/s). The observation has 11 numbers: lateral error, sine and cosine of the heading error,
    hitch angle, last steering and speed, the path's curvature at 0 to 1.5 m ahead, way left. The
    reward is the way along the path, the more the nearer it is driven, -1 for a run that failed and
    up to 1 for the end.

    Args:
        path: line, arc, s, lane-change, park, or random: one of them with numbers of its own.
        render_mode: None.

    Raises:
        GymError: unknown path or render mode.
    """

    metadata = {"render_modes": [], "render_fps": 10}

    def __init__(self, path=RANDOM, render_mode=None):
        if path not in (*SHAPES, RANDOM):
            raise GymError(f"path is {path!r}; there are {', '.join(SHAPES)}, {RANDOM}")
        if render_mode is not None:
            raise GymError(f"render_mode is {render_mode!r}; there is only None")
        self.render_mode, self._name = None, path
        self.action_space = spaces.Box(-1.0, 1.0, (2,), np.float32)
        self.observation_space = spaces.Box(-4.0, 4.0, (7 + len(AHEAD),), np.float32)
        self.rig = Rig()
        self._limit = backing_limit(self.rig.geometry, MARGIN)

    def reset(self, *, seed=None, options=None):
        """Put the rig beside the start of a path.

        Args:
            seed: of path and start.
            options: dict of lateral [m], turn, hitch [rad] in place of random ones; or None.
        """
        super().reset(seed=seed)
        rng, given = self.np_random, options or {}
        self.path = self._make_path(rng).moved(*START)
        lateral, turn, hitch = (
            float(given.get(name, rng.uniform(-most, most)))
            for name, most in (("lateral", LATERAL), ("turn", TURN), ("hitch", TURN))
        )
        self.rig.place(0.0, -lateral, turn, hitch)  # the left of a path to -x is -y
        self._last, self._steps = (0.0, 0.0), 0
        self.arc = self.path.first_nearest(*self.rig.trailer()[:2], 3.0)
        self._look()
        return self._observe(), self._info("")

    def _make_path(self, rng):
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

    def step(self, action):
        """Drive for one action."""
        steer, fast = (min(1.0, max(-1.0, float(value))) for value in action)
        self.rig.drive(steer * self.rig.geometry.max_steering, fast * TOP_SPEED)
        self._last, before = (steer, fast), self.arc
        self._steps += 1
        self._look()
        end = self._end()
        reward = (self.arc - before) * math.exp(-((self.lateral / NEAR) ** 2))
        if end == ARRIVED:
            reward += math.exp(-abs(self.lateral) / 0.05 - abs(self.heading_error) / 0.1)
        elif end:
            reward -= 1.0
        slow = self._steps * self.rig.period > self.path.length / SLOWEST
        return self._observe(), float(reward), bool(end), bool(slow and not end), self._info(end)

    def _look(self):
        """Where the trailer is now."""
        x, y, heading = self.rig.trailer()
        self._place = float(x), float(y)
        self.arc = float(self.path.nearest(x, y, self.arc))
        lateral, error = self.path.errors(x, y, heading + math.pi, self.arc)
        self.lateral, self.heading_error = float(lateral), float(error)
        self.hitch = float(self.rig.hitch_angle())

    def _end(self):
        if abs(self.hitch) > self._limit:
            return JACKKNIFED
        if abs(self.lateral) > LOST or abs(self.heading_error) > LOST_TURN:
            return LOST_PATH
        return ARRIVED if self.arc > self.path.length - END else ""

    def _observe(self):
        row = np.array(
            (
                self.lateral / 0.5,
                math.sin(self.heading_error),
                math.cos(self.heading_error),
                self.hitch,
                *self._last,
                min(1.0, (self.path.length - self.arc) / 3.0),
                *self.path.place(self.arc + AHEAD)[3],
            )
        )
        return np.clip(row, -4.0, 4.0).astype(np.float32)

    def _info(self, end):
        return {
            "end": end,
            "lateral": self.lateral,
            "heading": self.heading_error,
            "hitch": self.hitch,
            "x": self._place[0],
            "y": self._place[1],
            "time": self._steps * self.rig.period,
            "progress": 100.0 * min(1.0, max(0.0, self.arc / self.path.length)),
        }

    def close(self):
        """Free the engine."""
        self.rig.close()
