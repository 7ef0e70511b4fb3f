"""Paddock/Robot-v0: any robot, by its launch file or description."""

from __future__ import annotations

import dataclasses
import math
import warnings
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import gymnasium
import numpy as np
from bullet_sim.formats.lumping import MASSLESS
from bullet_sim.models.model import Model
from bullet_sim.pose import Pose, multiply, quaternion_from_yaw
from gymnasium import spaces

from paddock_gym.course import motion_from
from paddock_gym.envs.tasks import State, make_task
from paddock_gym.envs.topics import Actions, observed, resolved, unknown
from paddock_gym.envs.window import Window
from paddock_gym.errors import GymError, RewardError
from paddock_gym.simulation.randomize import Variation
from paddock_gym.simulation.recipe import Recipe, from_files
from paddock_gym.simulation.robot_world import RobotWorld
from paddock_gym.simulation.sensors import ObserverCamera

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
        render_mode: rgb_array, human, or None.

    Attributes:
        world: RobotWorld.
        actions: Actions.
        state: State after the last action.

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
        render_mode: str | None = None,
    ) -> None:
        if render_mode not in (None, *self.metadata["render_modes"]):
            raise GymError(f"render_mode is {render_mode!r}; there are rgb_array, human and None")
        for name, value, least in (("control_rate", control_rate, 0.1), ("delay", delay, 0.0),
                                   ("settle", settle, 0.0)):  # fmt: skip
            if not (math.isfinite(value) and least <= value <= 1000.0):
                raise GymError(f"{name} is {value!r}, must be from {least:g} to 1000")
        if massless_links not in ("", *MASSLESS):
            known = ", ".join(MASSLESS)
            raise GymError(f"massless_links is {massless_links!r}, must be one of {known}")
        files = {"urdf": urdf, "sdf": sdf, "world": world, "controllers": controllers,
                 "pose": pose, "arguments": arguments}  # fmt: skip
        self.task = make_task(task, task_options or {}, reward, end, start)
        recipe = read_recipe(launch, files)
        spawns = (*recipe.spawns, *self.task.models())
        massless = massless_links or recipe.massless_links
        recipe = dataclasses.replace(recipe, spawns=spawns, massless_links=massless)
        self.world = RobotWorld(recipe)
        try:
            self._make_spaces(action, limits, scaled, observation, robot)
            variation = Variation(self.world.world, self._model, vary)
        except BaseException:
            self.world.close()
            raise
        self._variation, self._delay = variation, delay
        self.render_mode, self._period = render_mode, 1.0 / control_rate
        self.metadata = dict(self.metadata, render_fps=control_rate)
        self._window = Window() if render_mode == "human" else None
        self._camera: Any = None
        self._settle(settle)
        if recipe.left_out:
            warnings.warn(
                f"nodes of the launch file that do not run: {', '.join(recipe.left_out)}",
                stacklevel=2,
            )

    def _make_spaces(self, action: Any, limits: Any, scaled: bool, names: Any, robot: str) -> None:
        world = self.world
        self.actions = Actions(world, action, limits, scaled)
        self.action_space = self.actions.space
        robots = world.robot_models
        if robot and robot not in world.world.models:
            raise GymError(f"robot is {robot!r}; models are {', '.join(world.world.models)}")
        name = robot or next(iter(robots), "") or next(iter(world.world.models), "")
        if not name:
            raise GymError("the world has no model; give urdf, sdf or a launch file with one")
        self._model: Model = world.world.models[name]
        chosen = (names,) if isinstance(names, str) else tuple(names)
        self._observed = {each: observed(world, each) for each in chosen}
        boxes = {each: found.space for each, found in self._observed.items()}
        boxes.update(self.task.spaces)
        self._alone = isinstance(names, str) and not self.task.spaces
        self.observation_space = boxes[chosen[0]] if self._alone else spaces.Dict(boxes)
        topics = [resolved(each.partition(":")[0]) for each, found in self._observed.items()
                  if found.topic is not None]  # fmt: skip
        for topic in self.task.topics:
            if topic not in world.topics:
                raise unknown("topic of the task", topic, world.topics)
        world.observe([*topics, *self.task.topics])

    def _settle(self, time: float) -> None:
        """Simulate until the robot rests; runs start from that."""
        world = self.world.world
        self.world.advance(round(time / world.time_step))
        self._rest_pose = self._model.pose
        self._at_rest = self._touching()
        self._saved = self.world.save()
        self._start_step = world.step_count
        self.state = State(self.world, self._model)

    def _touching(self) -> frozenset[tuple[int, str]]:
        """Links of other bodies that the robot touches."""
        body = self._model.body
        return frozenset((t.body, t.other) for t in body.touching() if t.body != body.number)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        """Start a run.

        Args:
            seed: of everything random, from here on.
            options: start: (x, y, yaw) [m], [rad]; None: the task's.
        """
        super().reset(seed=seed)
        unknown = set(options or {}) - {"start"}
        if unknown:
            raise GymError(f"reset has {min(unknown)!r}; there is start")
        for _ in range(TRIES):
            place = self._begin(None if options is None else options.get("start"))
            if place is None or not self._starts_in_contact():
                break
            self._put(place)
        else:
            raise GymError(f"{TRIES} starts touch something, the last at {place}; give more room")
        self._steps = 0
        self.task.begun(self.state)
        self.world.measure()
        return self._observe(), self._info("")

    def _begin(self, start: Sequence[float] | None) -> tuple[float, float, float] | None:
        """Restore the rest, draw what varies, put the robot to its start."""
        self.world.restore(self._saved)
        self._variation.sample(self.np_random)
        if self._variation.varies("noise"):
            self.world.reseed(self.np_random)
        state = self.state = State(self.world, self._model)
        place = self.task.start(state, self.np_random)
        if start is not None:
            place = tuple(map(float, start))  # type: ignore[assignment]
        if place is not None:
            self._put(place)
        state.robot = state.before = self._motion()
        return place

    def _put(self, place: Sequence[float]) -> None:
        """Put the robot at x, y [m], yaw [rad], at rest as it stood."""
        x, y, yaw = place
        before = self._rest_pose
        turn = multiply(quaternion_from_yaw(yaw - before.rpy[2]), before.orientation)
        self._model.set_state(Pose((x, y, before.position[2]), turn))

    def _starts_in_contact(self) -> bool:
        """Whether the robot touches something at its start."""
        world = self.world.world
        state = world.save_state()
        world.step(1)
        touches = bool(self._touching() - self._at_rest)
        world.restore_state(state)
        return touches

    def _motion(self) -> Any:
        return motion_from(*self._model.link_motion(self._model.description.root))

    def step(self, action: Any) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        """Command an action and advance by one control period.

        Raises:
            GymError: the action's shape or a number is wrong.
            RewardError: the reward is no finite number, or reward or end raises an exception.
        """
        numbers, state = self.actions.numbers(action), self.state
        state.before, state.action = state.robot, numbers
        steps = self._next_steps()
        wait = min(steps, round(self._delay / self.world.world.time_step) + self._variation.delay)
        if wait:
            self.world.advance(wait)
        self.actions.send(numbers)
        if wait < steps:
            self.world.advance(steps - wait)
        state.steps, state.time = self._steps, self._steps * self._period
        state.robot = self._motion()
        new = self._touching() - self._at_rest
        state.touched = self._names({number for number, _ in new}) if new else ()
        reward = self._judged("reward", self.task.reward)
        end = self._judged("end", self.task.end)
        self._show()
        return self._observe(), reward, bool(end), False, self._info(str(end or ""))

    def _next_steps(self) -> int:
        """Physics steps of the next action; a period need not be a multiple of a step."""
        self._steps += 1
        ratio = self._period / self.world.world.time_step
        before, after = (math.floor(n * ratio + 0.5) for n in (self._steps - 1, self._steps))
        return after - before

    def _names(self, numbers: set[int]) -> tuple[str, ...]:
        models = self.world.world.models.values()
        return tuple(m.name for m in models if m.body.number in numbers) or ("world",)

    def _judged(self, name: str, function: Any) -> Any:
        """What reward or end of the task return."""
        try:
            value = function(self.state)
            if name == "end":
                return value
            value = float(value)
        except Exception as error:
            kind = type(error).__name__
            raise RewardError(f"{name} of the task raised {kind}: {error}") from error
        if not math.isfinite(value):
            raise RewardError(f"reward is {value}, must be a finite number; state: {self.state}")
        return value

    def _observe(self) -> Any:
        if self._alone:
            return self._seen(next(iter(self._observed)))
        seen = {name: self._seen(name) for name in self._observed}
        return {**seen, **self.task.observe(self.state)}

    def _seen(self, name: str) -> np.ndarray:
        values = self._observed[name].read()
        is_image = values.dtype == np.uint8 and values.ndim > 1
        return self._variation.change_image(values) if is_image else values

    def _info(self, end: str) -> dict[str, Any]:
        robot = self.state.robot
        return {
            "end": end,
            "time": self._steps * self._period,
            "x": robot.x,
            "y": robot.y,
            "touched": ", ".join(self.state.touched),
        }

    def stamp(self, topic: str) -> float:
        """Simulated time [s] of the last message of an observed topic; NaN: none yet."""
        return self.world.topics[resolved(topic)].time

    def render(self) -> np.ndarray | None:
        """(360, 480, 3) uint8 RGB from behind the robot, with render_mode rgb_array."""
        return self.observer_image() if self.render_mode == "rgb_array" else None

    def observer_image(self) -> np.ndarray:
        """(360, 480, 3) uint8 RGB from behind the robot."""
        if self._camera is None:
            self._camera = ObserverCamera(self.world.cameras.renderer, self._motion)
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
