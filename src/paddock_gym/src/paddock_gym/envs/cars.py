"""Several cars in one world, each as if it were alone: a vectorised environment."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Any

import gymnasium
import numpy as np
from gymnasium.vector.utils import batch_space, concatenate, create_empty_array, iterate

from paddock_gym.contract.actions import Actions
from paddock_gym.envs import options as gym_options
from paddock_gym.envs.run import Observation, Run, action_space, advance, observation_space
from paddock_gym.errors import GymError
from paddock_gym.simulation.scene import TIME_STEP, Scene


class CarsEnv(gymnasium.vector.VectorEnv):
    """num_envs cars that pass through each other, on one track.

    A car whose run has ended restarts at the next step, whose action it ignores, as in
    Gymnasium's SyncVectorEnv.

    Args:
        num_envs: how many cars.
        max_episode_steps: actions after which a run is truncated; None: never.
        others: those of DeepRacerEnv; no camera, in which the other cars would be visible, and
            no objects.

    Raises:
        GymError, TrackError: an option is wrong.
    """

    def __init__(
        self,
        num_envs: int = 8,
        track: str = "default",
        observation: str | Iterable[str] = "state",
        action: str | dict[str, Any] | Actions = "continuous",
        reward: str = "progress",
        randomize: bool | str | Iterable[str] = ("start",),
        time_step: float = TIME_STEP,
        control_rate: float = 15.0,
        walls: bool | None = None,
        render_mode: str | None = None,
        max_episode_steps: int | None = None,
    ) -> None:
        if render_mode is not None:
            raise GymError(f"render_mode is {render_mode!r}; several cars render no image")
        self.options = gym_options.parse(
            observation, action, reward, "time_trial", randomize, False
        )
        if "camera" in self.options.observations:
            raise GymError(
                "observation is camera, in which the other cars would be visible; several cars in "
                "one world have state and lidar"
            )
        self.num_envs, self._longest = num_envs, max_episode_steps or math.inf
        self.render_mode = None
        self.metadata = {"render_fps": control_rate}
        self.single_action_space = action_space(self.options)
        self.single_observation_space = observation_space(self.options)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.scene = Scene(track, time_step, control_rate, num_envs, walls)
        self.runs = [Run(self.scene, car, self.options) for car in self.scene.cars]
        self._generators = [np.random.default_rng() for _ in self.runs]
        self._over = np.zeros(num_envs, bool)

    def reset(
        self,
        *,
        seed: int | Sequence[int | None] | None = None,
        options: dict[str, Any] | None = None,
    ) -> tuple[Observation, dict[str, Any]]:
        """Start all runs.

        Args:
            seed: of the first car, the others have the following ones; or one for each.
            options: none are known.
        """
        if options:
            raise GymError(f"reset has {min(options)!r}; several cars have no options")
        self._seed(seed)
        self.scene.restore()
        started = [run.start(rng) for run, rng in zip(self.runs, self._generators)]
        self._over[:] = False
        infos: dict[str, Any] = {}
        for index, (_, info) in enumerate(started):
            infos = self._add_info(infos, info, index)
        return self._batched([observation for observation, _ in started]), infos

    def _seed(self, seed: Any) -> None:
        if seed is None:
            return
        seeds = [seed + k for k in range(self.num_envs)] if np.ndim(seed) == 0 else list(seed)
        if len(seeds) != self.num_envs:
            raise GymError(f"seed has {len(seeds)} numbers; it must be one, or {self.num_envs}")
        for index, car_seed in enumerate(seeds):
            if car_seed is not None:
                self._generators[index], _ = gymnasium.utils.seeding.np_random(int(car_seed))

    def step(
        self, actions: Any
    ) -> tuple[Observation, np.ndarray, np.ndarray, np.ndarray, dict[str, Any]]:
        """Apply one action per car and advance by one control period."""
        over = self._over.copy()
        for run, action, is_over in zip(self.runs, iterate(self.action_space, actions), over):
            if not is_over:
                run.decide(action)
        advance(self.scene, self.runs)
        observations: list[Observation] = []
        infos: dict[str, Any] = {}
        rewards = np.zeros(self.num_envs)
        terminated, truncated = np.zeros((2, self.num_envs), bool)
        for index, run in enumerate(self.runs):
            if over[index]:
                observation, info = run.start(self._generators[index])
            else:
                observation, rewards[index], terminated[index], truncated[index], info = (
                    run.finish_step()
                )
            observations.append(observation)
            infos = self._add_info(infos, info, index)
            truncated[index] |= run.state.steps >= self._longest and not terminated[index]
        self._over = terminated | truncated
        return self._batched(observations), rewards, terminated, truncated, infos

    def _batched(self, observations: list[Observation]) -> Observation:
        space = self.single_observation_space
        return concatenate(space, observations, create_empty_array(space, self.num_envs))

    def close_extras(self, **_: Any) -> None:
        """Free the engine."""
        if hasattr(self, "scene"):  # not if an option was wrong
            self.scene.close()
