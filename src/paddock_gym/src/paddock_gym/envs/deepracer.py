"""Paddock/DeepRacer-v1: one car on one track."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import gymnasium
import numpy as np
from track_model.referee.course import Course

from paddock_gym.contract.actions import Actions
from paddock_gym.envs import options as gym_options
from paddock_gym.envs.run import Observation, Run, action_space, advance, observation_space
from paddock_gym.envs.window import Window
from paddock_gym.errors import GymError
from paddock_gym.simulation.scene import TIME_STEP, Obstacles, Scene
from paddock_gym.simulation.sensors import ObserverCamera


class DeepRacerEnv(gymnasium.Env):
    """A DeepRacer that learns to drive.

    Args:
        track: default, easy, medium, hard, or the path of a YAML, .npy or .csv file.
        observation: state, lidar or camera, or a tuple of them (a dict of arrays).
        action: continuous, or a model_metadata.json (its path, or its content as a dict).
        reward: progress, or the path of a reward_function.py.
        race: time_trial, object_avoidance or head_to_bot.
        randomize: some of start, friction, mass, latency, camera, light, colours; True: all.
            Without start each run starts 5 % of the track further on, as in AWS DeepRacer.
        time_step: physics step [s].
        control_rate: actions per simulated second [Hz]; an action takes the steps between two
            multiples of its period.
        walls: True or False: with or without walls along the lane; None: as the track's file says.
        colour: color camera images instead of gray ones.
        render_mode: rgb_array, human, or None.

    Raises:
        GymError, TrackError: an option is wrong.
    """

    metadata: dict[str, Any] = {"render_modes": ["rgb_array", "human"], "render_fps": 15}

    def __init__(
        self,
        track: str = "default",
        observation: str | Iterable[str] = "state",
        action: str | dict[str, Any] | Actions = "continuous",
        reward: str = "progress",
        race: str = "time_trial",
        randomize: bool | str | Iterable[str] = ("start",),
        time_step: float = TIME_STEP,
        control_rate: float = 15.0,
        walls: bool | None = None,
        colour: bool = False,
        render_mode: str | None = None,
    ) -> None:
        if render_mode not in (None, *self.metadata["render_modes"]):
            raise GymError(f"render_mode is {render_mode!r}; there are rgb_array, human and None")
        self.options = gym_options.parse(observation, action, reward, race, randomize, colour)
        self.action_space = action_space(self.options)
        self.observation_space = observation_space(self.options)
        self.render_mode = render_mode
        self.metadata = dict(self.metadata, render_fps=control_rate)
        self.scene = Scene(track, time_step, control_rate, walls=walls)
        object_type = self.options.objects
        self._obstacles = Obstacles(self.scene, object_type) if object_type else None
        self.run = Run(self.scene, self.scene.car, self.options, self._obstacles)
        self._window = Window() if render_mode == "human" else None
        self._observer_camera: ObserverCamera | None = None

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Start a run.

        Args:
            seed: of everything random, from here on.
            options: start: fraction of the track, lateral [m], turn [rad]; or None.
        """
        super().reset(seed=seed)
        self.scene.restore()
        start = None
        if options:
            start = start_of(self.scene.course, options)
        observation, info = self.run.start(self.np_random, start)
        self._show()
        return observation, info

    def step(self, action: Any) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Apply an action and advance by one control period."""
        self.run.decide(action)
        advance(self.scene, self.run)
        result = self.run.finish_step()
        self._show()
        return result

    def render(self) -> np.ndarray | None:
        """(360, 480, 3) uint8 RGB from behind the car, with render_mode rgb_array."""
        if self.render_mode != "rgb_array":
            return None
        return self.observer_image()

    def observer_image(self) -> np.ndarray:
        """(360, 480, 3) uint8 RGB from behind the car."""
        if self._observer_camera is None:
            self._observer_camera = ObserverCamera(self.scene.renderer, self.scene.car.motion)
        return self._observer_camera.image()

    def close(self) -> None:
        """Free the engine and close the window."""
        if self._window:
            self._window.close()
        self.scene.close()

    def _show(self) -> None:
        if self._window:
            self._window.show(self.observer_image(), self.metadata["render_fps"])


def start_of(course: Course, options: dict[str, Any]) -> tuple[float, float, float]:
    """Return the start pose (x, y, yaw) [m], [rad] of the options of reset().

    Raises:
        GymError: unknown key.
    """
    unknown = set(options) - {"start", "lateral", "turn"}
    if unknown:
        raise GymError(f"reset has {min(unknown)!r}; there are start, lateral and turn")
    s = float(options.get("start", 0.0)) * course.length
    return course.pose(s, options.get("lateral", 0.0), options.get("turn", 0.0))
