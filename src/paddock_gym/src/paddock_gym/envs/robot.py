"""Paddock/Robot-v0: any robot, by its launch file or description."""

from __future__ import annotations

import dataclasses
import math
import warnings
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import gymnasium
import numpy as np
from bullet_sim.engine import FIXED_JOINTS
from bullet_sim.formats.lumping import MASSLESS

from paddock_gym.envs.agent import Agent, steps_of
from paddock_gym.envs.tasks import State, make_task
from paddock_gym.envs.topics import resolved
from paddock_gym.envs.window import Window
from paddock_gym.errors import GymError
from paddock_gym.simulation.recipe import Recipe, from_files
from paddock_gym.simulation.renderer import ObserverCamera
from paddock_gym.simulation.robot_world import RobotWorld

REST = 1.0  # [s] until a robot rests
TRIES = 50  # starts that may touch something


def read_recipe(launch: str | Recipe, files: Mapping[str, Any]) -> Recipe:
    """Recipe of an environment's options.

    Raises:
        GymError: neither a launch file nor a description is given, or both.
    """
    given = {name: value for name, value in files.items() if value}
    if isinstance(launch, Recipe):
        return launch
    if launch:
        if given:
            raise GymError(f"launch and {', '.join(given)} are given; a launch file says it all")
        from paddock_gym.simulation.launch_file import from_launch

        return from_launch(launch)
    if not {"urdf", "sdf", "world"} & set(given):
        raise GymError("launch, urdf, sdf or world has to be given")
    return from_files(**given)


def begin_apart(
    world: RobotWorld,
    rest: Any,
    agents: Sequence[Agent],
    rng: np.random.Generator,
    start: Sequence[float] | None = None,
) -> None:
    """Begin a run of agents from a saved rest, at starts that touch nothing.

    Args:
        start: of each; None: their tasks'.

    Raises:
        GymError: there is no such start.
    """
    for _ in range(TRIES if start is None else 1):
        world.restore(rest)
        if any(agent.variation.varies("noise") for agent in agents):
            world.reseed(rng)
        places = [agent.begin(rng, start) for agent in agents]
        if not any(places):
            return
        state = world.world.save_state()
        world.world.step(1)
        touch = any(agent.touches() for agent in agents)
        world.world.restore_state(state)
        if not touch:
            return
    raise GymError(f"starts touch something, {TRIES} of the task or the given one: {places}")


def _check_numbers(**values: float) -> None:
    """Raise a GymError for a rate [Hz] or a time [s] that is out of bounds."""
    for name, value in values.items():
        least = 0.1 if name.endswith("rate") else 0.0
        if not (math.isfinite(value) and least <= value <= 1000.0):
            raise GymError(f"{name} is {value!r}, must be from {least:g} to 1000")


def _check_choice(name: str, value: Any, known: Sequence[Any]) -> None:
    """Raise a GymError for a value that is not known."""
    if value not in known:
        raise GymError(
            f"{name} is {value!r}, must be one of {', '.join(filter(None, map(str, known)))}"
        )


class RobotEnv(gymnasium.Env):
    """A robot that acts by topics and observes topics.

    Args:
        launch: "PACKAGE FILE.launch arg:=value ...", as for roslaunch; or a Recipe.
        urdf, sdf, world, controllers, pose, arguments: plain files, see recipe.from_files().
        action: topics that take commands; None: the only one that takes a Twist, else all that take
            numbers.
        limits: topic -> (low, high) instead of the description's.
        scaled: actions are from -1 to 1.
        observation: topics as policies take them (ranges over their maximum, images, else numbers
            in a row), "TOPIC:FIELD" as the message has it, "truth", "truth:MODEL::LINK"; a text: an
            array, several: a dict. What the task observes comes with them.
        task: none, goal, line, lane, wall, explore, a Task, or "module:name"; see tasks.
        task_options: arguments of the task.
        reward, end, start: functions in place of the task's, or "module:function".
        vary: what changes from run to run: some of friction, mass, delay, light, colours, noise.
        control_rate: actions per simulated second [Hz].
        delay: from an action to its commands [s].
        settle: simulated before the first start [s].
        robot: name of the robot's model; empty: the first that takes commands.
        massless_links: of URDFs: leave_out, as in Gazebo, or keep; empty: what the launch file
            says, else leave_out.
        fixed_joints: of SDFs and to the world: keep, as in Gazebo, or merge; empty: as before.
        render_mode: rgb_array, human, or None.

    Attributes:
        world: RobotWorld.
        agent: Agent.
        actions: Actions, or what the task has in place of them.
        saved: state of the world in which runs begin, see RobotWorld.save().
        period: of an action [s].

    Raises:
        GymError: an option is wrong.
    """

    metadata: dict[str, Any] = {"render_modes": ["rgb_array", "human"], "render_fps": 10}

    def __init__(
        self,
        launch: str | Recipe = "",
        urdf: str = "",
        sdf: str = "",
        world: str = "",
        controllers: str = "",
        pose: Sequence[float] = (),
        arguments: Mapping[str, str] | None = None,
        action: str | Iterable[str] | None = None,
        limits: Mapping[str, Any] | None = None,
        scaled: bool = False,
        observation: str | Iterable[str] = "truth",
        task: Any = "none",
        task_options: Mapping[str, Any] | None = None,
        reward: Any = None,
        end: Any = None,
        start: Any = None,
        vary: bool | str | Iterable[str] = ("noise",),
        control_rate: float = 10.0,
        delay: float = 0.0,
        settle: float = REST,
        robot: str = "",
        massless_links: str = "",
        fixed_joints: str = "",
        render_mode: str | None = None,
    ) -> None:
        _check_numbers(control_rate=control_rate, delay=delay, settle=settle)
        _check_choice("render_mode", render_mode, (None, *self.metadata["render_modes"]))
        _check_choice("massless_links", massless_links, ("", *MASSLESS))
        _check_choice("fixed_joints", fixed_joints, ("", *FIXED_JOINTS))
        files = {"urdf": urdf, "sdf": sdf, "world": world, "controllers": controllers,
                 "pose": pose, "arguments": arguments}  # fmt: skip
        self.task = make_task(task, task_options or {}, reward, end, start)
        recipe = read_recipe(launch, files)
        spawns = (*recipe.spawns, *self.task.models())
        recipe = dataclasses.replace(
            recipe,
            spawns=spawns,
            massless_links=massless_links or recipe.massless_links,
            fixed_joints=fixed_joints or recipe.fixed_joints,
        )
        self.world = RobotWorld(recipe)
        try:
            options = robot, action, limits, scaled, observation, vary
            self.agent = Agent(self.world, self.task, *options)
        except BaseException:
            self.world.close()
            raise
        self.actions, self._delay = self.agent.actions, delay
        self.action_space = self.agent.action_space
        self.observation_space = self.agent.observation_space
        self.render_mode, self.period = render_mode, 1.0 / control_rate
        self.metadata = dict(self.metadata, render_fps=control_rate)
        self._window = Window() if render_mode == "human" else None
        self._camera: Any = None
        self._settle(settle)
        if recipe.left_out:
            warnings.warn(
                f"nodes of the launch file that do not run: {', '.join(recipe.left_out)}",
                stacklevel=2,
            )

    def _settle(self, time: float) -> None:
        """Simulate until the robot rests; runs start from that."""
        self.world.advance(round(time / self.world.world.time_step))
        self.agent.rest()
        self.saved = self.world.save()

    @property
    def state(self) -> State:
        """The run after the last action."""
        return self.agent.state

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        """Start a run.

        Args:
            seed: of everything random, from here on.
            options: start: (x, y, yaw) [m], [rad]; None: the task's.
        """
        super().reset(seed=seed)
        start = self._place(options or {})
        begin_apart(self.world, self.saved, [self.agent], self.np_random, start)
        self._steps = 0
        self.task.begun(self.state)
        self.world.measure()
        return self.agent.observe(), self.agent.info("")

    def _place(self, options: dict[str, Any]) -> Any:
        """x, y [m] and yaw [rad] of the start that options of reset() choose; None: the task's.

        Raises:
            GymError: there is no such option.
        """
        unknown = set(options) - {"start"}
        if unknown:
            raise GymError(f"reset has {min(unknown)!r}; there is start")
        return options.get("start")

    def step(self, action: Any) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        """Command an action and advance by one control period.

        Raises:
            GymError: the action's shape or a number is wrong.
            RewardError: the reward is no finite number, or reward or end raises an exception.
        """
        agent, time_step = self.agent, self.world.world.time_step
        numbers = agent.decide(action)
        self._steps += 1
        steps = steps_of(self._steps, self.period, time_step)
        wait = min(steps, round(self._delay / time_step) + agent.variation.delay)
        if wait:
            self.world.advance(wait)
        self.task.drive(self.world, agent.actions, numbers, steps - wait)
        reward, end = agent.finish(self._steps, self._steps * self.period)
        self._show()
        late = self.task.truncates(agent.state, end)
        return agent.observe(), reward, bool(end) and not late, late, agent.info(end)

    def stamp(self, topic: str) -> float:
        """Simulated time [s] of the last message of an observed topic; NaN: none yet."""
        return self.world.topics[resolved(topic)].time

    def render(self) -> np.ndarray | None:
        """(360, 480, 3) uint8 RGB from behind the robot, with render_mode rgb_array."""
        return self.observer_image() if self.render_mode == "rgb_array" else None

    def observer_image(self) -> np.ndarray:
        """(360, 480, 3) uint8 RGB from behind the robot."""
        if self._camera is None:
            self._camera = ObserverCamera(self.world.cameras.renderer, self.agent.motion)
        image: np.ndarray = self._camera.image()
        return image

    def _show(self) -> None:
        if self._window:
            self._window.show(self.observer_image(), self.metadata["render_fps"])

    def close(self) -> None:
        """Free the engine and close the window."""
        if self._window:
            self._window.close()
        self.world.close()
