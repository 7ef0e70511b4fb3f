"""One car's runs: observations, actions and rewards."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any, Dict, Union

import numpy as np
from gymnasium import spaces

from paddock_gym import observations
from paddock_gym.contract.actions import Continuous
from paddock_gym.contract.params import Waypoints, params
from paddock_gym.course import (
    LAP,
    OBSERVED_OBJECTS,
    RUNNING,
    RunEvaluator,
    RunState,
    TrackObject,
    next_objects,
)
from paddock_gym.envs.options import Options
from paddock_gym.envs.rewards import progress
from paddock_gym.simulation.car import Car
from paddock_gym.simulation.randomize import Randomizer
from paddock_gym.simulation.scene import Obstacles, Scene
from paddock_gym.simulation.sensors import CarCamera, CarLidar

if TYPE_CHECKING:
    from typing_extensions import TypeAlias

AT_REST = (0.0, 0.0)  # speed, steering
Observation: TypeAlias = Union[np.ndarray, Dict[str, np.ndarray]]


def action_space(options: Options) -> spaces.Space:
    """Gymnasium space of the actions."""
    if isinstance(options.actions, Continuous):
        return spaces.Box(-1.0, 1.0, (2,), np.float32)
    return spaces.Discrete(len(options.actions.rows))


def observation_space(options: Options) -> spaces.Space:
    """Gymnasium space of the observations."""
    count = observations.STATE_SHAPE[0] + (2 * OBSERVED_OBJECTS if options.objects else 0)
    shape = observations.COLOR_SHAPE if options.colour else observations.GRAY_SHAPE
    boxes = {
        "state": spaces.Box(-observations.LIMIT, observations.LIMIT, (count,), np.float32),
        "lidar": spaces.Box(0.0, 1.0, observations.RANGES_SHAPE, np.float32),
        "camera": spaces.Box(0, 255, shape, np.uint8),
    }
    if options.alone:
        return boxes[options.observations[0]]
    return spaces.Dict({name: boxes[name] for name in options.observations})


class Run:
    """One car's runs.

    Args:
        car: the scene's.

    Attributes:
        state: after the last action.
        motion: after the last action.
        delay: physics steps after which apply() is due.
        camera: None: it is not observed.
    """

    def __init__(
        self, scene: Scene, car: Car, options: Options, obstacles: Obstacles | None = None
    ) -> None:
        self._scene, self._car, self._options = scene, car, options
        self._obstacles = obstacles
        self._course = scene.course
        self._evaluator = RunEvaluator(scene.course)
        self._observer = observations.StateObserver(scene.course)
        self._waypoints = options.reward and Waypoints(scene.track, scene.course)
        self._randomizer = Randomizer(scene, car, options.randomize)
        self._may_crash = scene.has_walls or obstacles is not None
        names = options.observations
        self.camera = CarCamera(scene.renderer, car) if "camera" in names else None
        self._observers: dict[str, Callable[[], np.ndarray]] = {"state": self._state}
        if "lidar" in names:
            self._observers["lidar"] = partial(self._ranges, CarLidar(scene.world, car))
        if self.camera is not None:
            self._observers["camera"] = partial(self._image, self.camera)

    def start(
        self, rng: np.random.Generator, start_pose: tuple[float, float, float] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Start a run.

        Args:
            rng: also of the noise until the next start.
            start_pose: (x, y, yaw) [m], [rad]; None: by the options.

        Returns:
            observation, info.
        """
        self._rng = rng
        random_pose = self._randomizer.sample(rng)
        self.delay = self._randomizer.delay
        self._car.place(*(random_pose if start_pose is None else start_pose))
        self.motion = self._car.motion()
        self.state = self._evaluator.start(self.motion)
        if self._obstacles:
            self._obstacles.start(rng, self.state.s)
        self._command = AT_REST
        return self._observe(), self._info()

    def decide(self, action: Any) -> None:
        """Set the action that apply() commands."""
        self._command = self._options.actions.command(action)

    def apply(self) -> None:
        """Command the car."""
        self._car.drive(*self._command)

    def finish_step(self) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Observe the result of the last action.

        Returns:
            observation, reward, terminated, truncated, info.
        """
        if self._obstacles:
            self._obstacles.advance()
        self.motion = self._car.motion()
        crashed = self._may_crash and self._car.touched(self._scene.ground)
        state = self.state = self._evaluator.update(self.motion, crashed)
        reward = self._reward(state)
        # After a full lap more reward would follow: it truncates the run.
        lap = state.end == LAP
        return self._observe(), reward, state.end != RUNNING and not lap, lap, self._info()

    def params(self) -> dict[str, Any]:
        """Parameters of a reward function after the last action."""
        self._waypoints = self._waypoints or Waypoints(self._scene.track, self._course)
        state = self.state
        width = state.left + state.right
        return params(state, self.motion, self._command, self._waypoints, width, self.objects)

    @property
    def objects(self) -> Sequence[TrackObject]:
        """Objects on the track now."""
        return self._obstacles.objects if self._obstacles else ()

    def _reward(self, state: RunState) -> float:
        if self._options.reward is None:
            return progress(state)
        return self._options.reward.reward(self.params())

    def _info(self) -> dict[str, Any]:
        state = self.state
        return {
            "end": state.end,
            "progress": state.progress,
            "time": state.steps * self._scene.period,
            "lateral": state.lateral,
            "x": self.motion.x,
            "y": self.motion.y,
        }

    def _observe(self) -> Observation:
        names = self._options.observations
        if self._options.alone:
            return self._observers[names[0]]()
        return {name: self._observers[name]() for name in names}

    def _state(self) -> np.ndarray:
        state = self.state
        row = self._observer.observe(self.motion, state, self._command)
        if self._obstacles is None:
            return row
        return np.concatenate((row, next_objects(self._obstacles.objects, state.s, self._course)))

    def _ranges(self, lidar: CarLidar) -> np.ndarray:
        return observations.ranges(lidar.scan(self._rng))

    def _image(self, camera: CarCamera) -> np.ndarray:
        rgb = self._randomizer.change_image(camera.image(self._randomizer.jitter))
        return observations.image(rgb, self._options.colour)


def advance(scene: Scene, run: Run) -> None:
    """Advance by one action; the run's command takes effect after its delay."""
    steps = scene.begin_action()
    delay = min(run.delay, steps)
    if delay > 0:
        scene.advance(delay)
    run.apply()
    if delay < steps:
        scene.advance(steps - delay)
