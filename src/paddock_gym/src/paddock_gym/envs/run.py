"""The task of the DeepRacer: a run along a track, its observations, actions and rewards."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np
from bullet_sim.models.model import Model
from gymnasium import spaces
from track_model.referee.course import Course
from track_model.track import Track

from paddock_gym import observations
from paddock_gym.contract.actions import Continuous
from paddock_gym.contract.params import Waypoints, params
from paddock_gym.course import (
    LAP,
    OBSERVED_OBJECTS,
    RunEvaluator,
    TrackObject,
    next_objects,
    progress,
)
from paddock_gym.envs.options import Options
from paddock_gym.envs.tasks import State, Task
from paddock_gym.simulation.car import Car
from paddock_gym.simulation.obstacles import Obstacles
from paddock_gym.simulation.randomize import RANDOMIZABLE, Variation
from paddock_gym.simulation.recipe import Spawn
from paddock_gym.simulation.robot_world import RobotWorld

START_SIDE = 0.25  # of the lane's width to each edge: largest offset at the start
START_HEADING = math.radians(15.0)
FIRST_STARTS = 0.05  # fraction of the track between starts that are not random
WINDOW = 0.5  # searched around the last arc length; one action moves a car less [m]


def observation_spaces(options: Options) -> dict[str, spaces.Box]:
    """Gymnasium spaces of the observations."""
    count = observations.STATE_SHAPE[0] + (2 * OBSERVED_OBJECTS if options.objects else 0)
    shape = observations.COLOR_SHAPE if options.colour else observations.GRAY_SHAPE
    boxes = {
        "state": spaces.Box(-observations.LIMIT, observations.LIMIT, (count,), np.float32),
        "lidar": spaces.Box(0.0, 1.0, observations.RANGES_SHAPE, np.float32),
        "camera": spaces.Box(0, 255, shape, np.uint8),
    }
    return {name: boxes[name] for name in options.observations}


class Run(Task):
    """One car's runs along the lane of a track; it takes the actions itself.

    Args:
        period: of an action [s].

    Attributes:
        track, course: Track, and the Course of its lane.
        car: Car.
        state: RunState after the last action; motion: the car's Motion then.
        camera: see Car.camera(); None: it is not observed.
        place: of the next start: x, y [m], yaw [rad]; None: by the options.
        space: Gymnasium space of the actions.
    """

    variable = RANDOMIZABLE

    def __init__(self, track: Track, options: Options, period: float) -> None:
        self.track, self._options = track, options
        self.course = Course(track.lane, WINDOW)
        self.spaces, self.alone = observation_spaces(options), options.alone
        chosen = options.actions
        self.space: spaces.Space[Any] = (
            spaces.Box(-1.0, 1.0, (2,), np.float32)
            if isinstance(chosen, Continuous)
            else spaces.Discrete(len(chosen.rows))
        )
        self._obstacles = options.objects and Obstacles(self.course, period, options.objects)
        self._evaluator = RunEvaluator(self.course)
        self._observer = observations.StateObserver(self.course)
        self._waypoints = options.reward and Waypoints(track, self.course)
        self.feels = bool(self._obstacles) or track.spec.walls.enabled
        self.place: tuple[float, float, float] | None = None
        self._rounds = 0

    def models(self) -> Sequence[Spawn]:
        return self._obstacles.models() if self._obstacles else ()

    def made(self, world: RobotWorld, model: Model, variation: Variation) -> Run:
        self.car, self._variation = Car(world, model), variation
        self.camera: Callable[..., np.ndarray] | None = None
        self._observers: dict[str, Callable[[], np.ndarray]] = {"state": self._state}
        if "lidar" in self.spaces:
            self._observers["lidar"] = partial(self._ranges, self.car.lidar())
        if "camera" in self.spaces:
            self.camera = self.car.camera()
            self._observers["camera"] = partial(self._image, self.camera)
        return self

    def rested(self, world: RobotWorld) -> None:
        self.car.settled()
        world.world.step_count = 0

    # actions ----------------------------------------------------------------------------------
    def numbers(self, action: Any) -> tuple[float, float]:
        """Speed [m/s] and steering [rad] of an action."""
        self._command = self._options.actions.command(action)
        return self._command

    def send(self, command: tuple[float, float]) -> None:
        """Command the car."""
        self.car.drive(*command)

    def stop(self) -> None:
        """Have the car stand."""
        self.car.drive(0.0, 0.0)

    # a run ------------------------------------------------------------------------------------
    def start(self, state: State, rng: np.random.Generator) -> None:
        """Put the car to `place`, to a random place, or 5 % further with each run."""
        course, self._rng = self.course, rng
        room = course.length if course.closed else 0.8 * course.length
        if self._variation.varies("start"):
            s = rng.uniform(0.0, room)
            side = rng.uniform(-START_SIDE, START_SIDE) * sum(course.sides(s)) / 2.0
            found = course.pose(s, side, rng.uniform(-START_HEADING, START_HEADING))
        else:
            found = course.pose(room * (self._rounds * FIRST_STARTS % 1.0))
            self._rounds += 1
        self.car.place(*(self.place or found))
        self._command = 0.0, 0.0

    def begun(self, state: State) -> None:
        self.motion = state.robot
        self.state = self._evaluator.start(self.motion)
        if self._obstacles:
            self._obstacles.start(state.world.world, self._rng, self.state.s)

    def acted(self, state: State) -> None:
        if self._obstacles:
            self._obstacles.advance()

    def reward(self, state: State) -> float:
        self.motion = state.robot
        self.state = self._evaluator.update(self.motion, state.crashed)
        given = self._options.reward
        return progress(self.state) if given is None else given.reward(self.params())

    def end(self, state: State) -> str:
        return self.state.end

    def truncates(self, state: State, end: str) -> bool:
        return end == LAP  # more reward would follow

    def info(self, state: State) -> Mapping[str, Any]:
        return {"progress": self.state.progress, "lateral": self.state.lateral}

    def params(self) -> dict[str, Any]:
        """Parameters of a reward function after the last action."""
        self._waypoints = self._waypoints or Waypoints(self.track, self.course)
        state = self.state
        width = state.left + state.right
        return params(state, self.motion, self._command, self._waypoints, width, self.objects)

    @property
    def objects(self) -> Sequence[TrackObject]:
        """Objects on the track now."""
        return self._obstacles.objects if self._obstacles else ()

    def observe(self, state: State) -> Mapping[str, np.ndarray]:
        return {name: self._observers[name]() for name in self.spaces}

    def _state(self) -> np.ndarray:
        row = self._observer.observe(self.motion, self.state, self._command)
        if not self._obstacles:
            return row
        return np.concatenate((row, next_objects(self.objects, self.state.s, self.course)))

    def _ranges(self, scan: Callable[[Any], np.ndarray]) -> np.ndarray:
        return observations.ranges(scan(self._rng))

    def _image(self, camera: Callable[..., np.ndarray]) -> np.ndarray:
        rgb = self._variation.change_image(camera(self._variation.jitter))
        return observations.image(rgb, self._options.colour)
