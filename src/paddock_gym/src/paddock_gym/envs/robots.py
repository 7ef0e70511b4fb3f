"""Several robots that learn in one world, as a ParallelEnv of PettingZoo."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from gymnasium import spaces
from pettingzoo import ParallelEnv

from paddock_gym.envs.agent import Agent, steps_of
from paddock_gym.envs.robot import REST, begin_apart, read_recipe
from paddock_gym.envs.tasks import make_task
from paddock_gym.errors import GymError
from paddock_gym.simulation.recipe import Recipe
from paddock_gym.simulation.robot_world import RobotWorld

TASK = ("task", "task_options", "reward", "end", "start")


class RobotsEnv(ParallelEnv):  # type: ignore[misc]
    """Robots in one world, each with its own actions, observations and reward.

    They touch each other. A robot whose run has ended stands where it is, without commands, until
    all have ended.

    Args:
        robots: model -> its options: action, limits, scaled, observation, task, task_options,
            reward, end, start, as of RobotEnv.
        launch, files: as of RobotEnv: launch, or urdf, sdf, world, controllers, pose, arguments.
        vary: what changes from run to run, of each robot; see RobotEnv.
        control_rate: actions per simulated second [Hz].
        settle: simulated before the first start [s].
        max_steps: actions after which a run is truncated.

    Raises:
        GymError: an option is wrong.
    """

    metadata: dict[str, Any] = {"name": "paddock_robots_v0", "render_modes": []}

    def __init__(
        self,
        robots: Mapping[str, Mapping[str, Any]],
        launch: str | Recipe = "",
        vary: bool | str | Iterable[str] = ("noise",),
        control_rate: float = 10.0,
        settle: float = REST,
        max_steps: int = 1000,
        **files: Any,
    ) -> None:
        if not robots:
            raise GymError("robots is empty; it needs a model's name and its options")
        self.possible_agents = list(robots)
        self.agents: list[str] = []
        self.render_mode = None
        given = {name: dict(options) for name, options in robots.items()}
        tasks = {
            name: make_task(
                options.pop("task", "none"),
                options.pop("task_options", {}),
                *(options.pop(key, None) for key in TASK[2:]),
            )
            for name, options in given.items()
        }
        recipe = read_recipe(launch, files)
        added = [spawn for task in tasks.values() for spawn in task.models()]
        self.world = RobotWorld(dataclasses.replace(recipe, spawns=(*recipe.spawns, *added)))
        try:
            self._agents = {
                name: Agent(self.world, tasks[name], name, vary=vary, **options)
                for name, options in given.items()
            }
        except TypeError as error:
            self.world.close()
            raise GymError(f"options of a robot: {error}") from error
        except BaseException:
            self.world.close()
            raise
        self.observation_spaces = {n: a.observation_space for n, a in self._agents.items()}
        self.action_spaces = {n: a.action_space for n, a in self._agents.items()}
        self._period, self._most, self._steps = 1.0 / control_rate, max_steps, 0
        self._rng = np.random.default_rng()
        self.world.advance(round(settle / self.world.world.time_step))
        for agent in self._agents.values():
            agent.rest()
        self._saved = self.world.save()

    def observation_space(self, agent: str) -> spaces.Space[Any]:
        """Of a robot."""
        return self.observation_spaces[agent]

    def action_space(self, agent: str) -> spaces.Space[Any]:
        """Of a robot."""
        return self.action_spaces[agent]

    def reset(
        self, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, Any], dict[str, Any]]:
        """Start a run of all robots.

        Args:
            seed: of everything random, from here on.
        """
        if seed is not None:
            self._rng = np.random.default_rng(seed)
        self.agents, self._steps = list(self.possible_agents), 0
        begin_apart(self.world, self._saved, list(self._agents.values()), self._rng)
        for agent in self._agents.values():
            agent.task.begun(agent.state)
        self.world.measure()
        infos = {name: agent.info("") for name, agent in self._agents.items()}
        return {name: agent.observe() for name, agent in self._agents.items()}, infos

    def step(self, actions: Mapping[str, Any]) -> tuple[dict[str, Any], ...]:
        """Command an action of each robot whose run goes on, and advance by one control period.

        Raises:
            GymError, RewardError: as of RobotEnv.
        """
        running = {name: self._agents[name] for name in self.agents}
        missing = [name for name in running if name not in actions]
        if missing:
            raise GymError(f"actions of {', '.join(missing)} are missing; there must be each")
        numbers = {name: agent.decide(actions[name]) for name, agent in running.items()}
        for name, agent in running.items():
            agent.actions.send(numbers[name])
        self._steps += 1
        self.world.advance(steps_of(self._steps, self._period, self.world.world.time_step))
        time = self._steps * self._period
        judged = {name: agent.finish(self._steps, time) for name, agent in running.items()}
        late = {
            name: agent.task.truncates(agent.state, judged[name][1]) or self._steps >= self._most
            for name, agent in running.items()
        }
        ended = {name: bool(end) for name, (_, end) in judged.items()}
        results = (
            {name: agent.observe() for name, agent in running.items()},
            {name: reward for name, (reward, _) in judged.items()},
            {name: end and not late[name] for name, end in ended.items()},
            late,
            {name: agent.info(judged[name][1]) for name, agent in running.items()},
        )
        for name, end in ended.items():
            if end:
                self._agents[name].actions.stop()
        self.agents = [name for name in running if not (ended[name] or late[name])]
        return results

    def close(self) -> None:
        """Free the engine."""
        self.world.close()
