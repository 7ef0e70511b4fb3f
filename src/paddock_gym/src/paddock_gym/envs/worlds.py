"""Environments side by side in one process, each with a world of its own, on all processors."""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import gymnasium
import numpy as np
from gymnasium.vector.utils import batch_space, concatenate, create_empty_array, iterate

from paddock_gym.envs.deepracer import DeepRacerEnv
from paddock_gym.envs.robot import RobotEnv
from paddock_gym.errors import GymError

# Of Gymnasium 1.1 and later, where each vector of environments tells it
_AUTORESET = getattr(gymnasium.vector, "AutoresetMode", None)
_making = threading.Lock()  # xacro has variables that all threads share


class Worlds:
    """Environments that threads drive.

    Steps of the solver let other threads run. A thread has the same environments from their making
    to their end, since an OpenGL context belongs to one thread.

    Args:
        makers: functions without arguments; each makes one environment.
        threads: how many; None: as many as there are processors.

    Attributes:
        envs: the environments.
    """

    def __init__(
        self, makers: Sequence[Callable[[], gymnasium.Env]], threads: int | None = None
    ) -> None:
        count = len(makers)
        threads = max(1, min(count, threads or len(os.sched_getaffinity(0))))
        self._shares = [range(first, count, threads) for first in range(threads)]
        self._threads = [ThreadPoolExecutor(1, "worlds") for _ in range(threads)]
        self.envs: list[gymnasium.Env] = []
        try:
            self.envs = self.map(lambda index: _made(makers[index]))
        except BaseException:
            self.close()
            raise

    def map(self, work: Callable[[int], Any]) -> list[Any]:
        """Results of a function of the numbers of the environments, each in its thread; what one
        raises is raised after all have ended."""

        def share(numbers: Iterable[int]) -> list[Any]:
            return [work(index) for index in numbers]

        waiting = [
            thread.submit(share, numbers) for thread, numbers in zip(self._threads, self._shares)
        ]
        results: list[Any] = [None] * sum(map(len, self._shares))
        errors = [future.exception() for future in waiting]
        for error in errors:
            if error is not None:
                raise error
        for numbers, future in zip(self._shares, waiting):
            for index, result in zip(numbers, future.result()):
                results[index] = result
        return results

    def close(self) -> None:
        """Close the environments and end the threads; at Python's end these have ended already, and
        what the environments hold goes with the process."""
        if self.envs and threading.main_thread().is_alive():
            self.map(lambda index: self.envs[index].close())
        self.envs = []
        for thread in self._threads:
            thread.shutdown()


def _made(maker: Callable[[], gymnasium.Env]) -> gymnasium.Env:
    with _making:
        return maker()


class WorldsEnv(gymnasium.vector.VectorEnv):
    """num_envs environments, each in a world of its own; of the base class DeepRacers.

    A run that has ended starts anew at the next step, whose action it ignores, as in Gymnasium
    1's SyncVectorEnv; each drives as its environment alone does, to the bit.

    Args:
        num_envs: how many.
        threads: see Worlds.
        max_episode_steps: actions after which a run is truncated; None: never.
        render_mode: rgb_array or None.
        options: the others of the environment.

    Attributes:
        kind: class of the environments.

    Raises:
        GymError, TrackError: an option is wrong.
    """

    kind: Callable[..., gymnasium.Env] = DeepRacerEnv
    closed = False  # Gymnasium 0.29's base class sets it in its __init__ alone

    def __init__(
        self,
        num_envs: int = 8,
        threads: int | None = None,
        max_episode_steps: int | None = None,
        render_mode: str | None = None,
        **options: Any,
    ) -> None:
        if render_mode not in (None, "rgb_array"):
            raise GymError(f"render_mode is {render_mode!r}; several cars have rgb_array and None")

        def make() -> gymnasium.Env:
            env: gymnasium.Env = self.kind(render_mode=render_mode, **options)
            if max_episode_steps is not None:
                env = gymnasium.wrappers.TimeLimit(env, max_episode_steps)
            return env

        self._worlds = Worlds([make] * num_envs, threads)
        first = self._worlds.envs[0]
        self.num_envs, self.render_mode, self.metadata = num_envs, render_mode, first.metadata
        if _AUTORESET is not None:
            self.metadata = {**self.metadata, "autoreset_mode": _AUTORESET.NEXT_STEP}
        self.single_action_space = first.action_space
        self.single_observation_space = first.observation_space
        self.action_space = batch_space(self.single_action_space, num_envs)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self._over = np.zeros(num_envs, bool)

    @property
    def envs(self) -> list[gymnasium.Env]:
        """The environments."""
        return self._worlds.envs

    def reset(
        self,
        *,
        seed: int | Sequence[int | None] | None = None,
        options: dict[str, Any] | None = None,
    ) -> tuple[Any, dict[str, Any]]:
        """Start all runs.

        Args:
            seed: of the first, the others have the following ones; or one for each.
            options: of each, see DeepRacerEnv.
        """
        if seed is None:
            seeds: list[int | None] = [None] * self.num_envs
        elif isinstance(seed, (int, np.integer)):
            seeds = [int(seed) + k for k in range(self.num_envs)]
        else:
            seeds = [None if number is None else int(number) for number in seed]
        if len(seeds) != self.num_envs:
            raise GymError(f"seed has {len(seeds)} numbers; it must be one, or {self.num_envs}")
        self._over[:] = False
        started = self._worlds.map(
            lambda index: self.envs[index].reset(seed=seeds[index], options=options)
        )
        return self._batched([observation for observation, _ in started]), self._infos(started)

    def step(self, actions: Any) -> tuple[Any, np.ndarray, np.ndarray, np.ndarray, dict[str, Any]]:
        """Apply one action in each world and advance by one control period."""
        rows = list(iterate(self.action_space, actions))

        def step(index: int) -> tuple[Any, ...]:
            if not self._over[index]:
                return self.envs[index].step(rows[index])
            observation, info = self.envs[index].reset()
            return observation, 0.0, False, False, info

        results = self._worlds.map(step)
        observations, rewards, terminated, truncated, _ = zip(*results)
        ends = np.array(terminated, bool), np.array(truncated, bool)
        self._over = ends[0] | ends[1]
        return self._batched(observations), np.array(rewards, float), *ends, self._infos(results)

    def render(self) -> tuple[Any, ...] | None:
        """An image of each, see DeepRacerEnv; None without render_mode rgb_array."""
        if self.render_mode is None:
            return None
        return tuple(self._worlds.map(lambda index: self.envs[index].render()))

    def _batched(self, observations: Sequence[Any]) -> Any:
        space = self.single_observation_space
        return concatenate(space, observations, create_empty_array(space, self.num_envs))

    def _infos(self, results: Iterable[Sequence[Any]]) -> dict[str, Any]:
        infos: dict[str, Any] = {}
        for index, result in enumerate(results):
            infos = self._add_info(infos, result[-1], index)
        return infos

    def close(self, **_: Any) -> None:
        """Free the engines; a second call has no effect."""
        if hasattr(self, "_worlds"):  # not if an option was wrong
            self._worlds.close()
        self.closed = True


class RobotWorldsEnv(WorldsEnv):
    """num_envs robots, each in a world of its own."""

    kind = RobotEnv
