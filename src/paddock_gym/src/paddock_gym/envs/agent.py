"""One robot of a world that acts, observes and is judged."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
from bullet_sim.models.model import Model
from bullet_sim.pose import Pose, multiply, quaternion_from_yaw
from gymnasium import spaces

from paddock_gym.course import motion_from
from paddock_gym.envs.tasks import State, Task
from paddock_gym.envs.topics import Actions, observed, resolved, unknown
from paddock_gym.errors import GymError, RewardError
from paddock_gym.simulation.randomize import Variation
from paddock_gym.simulation.robot_world import RobotWorld


class Agent:
    """A robot with its spaces and its task; the options are those of RobotEnv.

    Attributes:
        model: of the robot.
        observed: name -> Observed.
        actions: Actions; action_space, observation_space: Gymnasium's.
        state: State after the last action.

    Raises:
        GymError: an option is wrong.
    """

    def __init__(
        self,
        world: RobotWorld,
        task: Task,
        robot: str = "",
        action: str | Iterable[str] | None = None,
        limits: Mapping[str, Any] | None = None,
        scaled: bool = False,
        observation: str | Iterable[str] = "truth",
        vary: bool | str | Iterable[str] = (),
    ) -> None:
        self._world, self.task = world, task
        models = world.world.models
        if robot and robot not in models:
            raise GymError(f"robot is {robot!r}; models are {', '.join(models)}")
        name = robot or next(iter(world.robot_models), "") or next(iter(models), "")
        if not name:
            raise GymError("the world has no model; give urdf, sdf or a launch file with one")
        self.model: Model = models[name]
        self.variation = Variation(world.world, self.model, vary, task.variable)
        own = task.made(world, self.model, self.variation)
        self.actions = own or Actions(world, action, limits, scaled, robot)
        self.action_space = self.actions.space
        chosen = (observation,) if isinstance(observation, str) else tuple(observation)
        self.observed = {each: observed(world, each) for each in chosen}
        boxes = {each: found.space for each, found in self.observed.items()}
        boxes.update(task.spaces)
        self._alone = task.alone if task.spaces else isinstance(observation, str)
        space = next(iter(boxes.values())) if self._alone else spaces.Dict(boxes)
        self.observation_space: spaces.Space[Any] = space
        topics = [resolved(each.partition(":")[0]) for each, found in self.observed.items()
                  if found.topic is not None]  # fmt: skip
        for topic in task.topics:
            if topic not in world.topics:
                raise unknown("topic of the task", topic, world.topics)
        world.observe([*topics, *task.topics])

    def rest(self) -> None:
        """The robot stands as it starts."""
        self._rest_pose, self._at_rest = self.model.pose, self._touching()
        self.task.rested(self._world)
        self.state = State(self._world, self.model)

    def _touching(self) -> frozenset[tuple[int, str]]:
        """Links of other bodies that the robot touches."""
        body = self.model.body
        return frozenset((t.body, t.other) for t in body.touching() if t.body != body.number)

    def begin(self, rng: np.random.Generator, start: Sequence[float] | None = None) -> Any:
        """Draw what varies, put the robot to its start in the world at rest.

        Args:
            start: x, y [m], yaw [rad]; None: the task's.

        Returns:
            Where it starts; None: where it stands.
        """
        self.variation.sample(rng)
        state = self.state = State(self._world, self.model)
        place = self.task.start(state, rng)
        if start is not None:
            x, y, yaw = map(float, start)
            place = x, y, yaw
        if place is not None:
            x, y, yaw = place
            before = self._rest_pose
            turn = multiply(quaternion_from_yaw(yaw - before.rpy[2]), before.orientation)
            self.model.set_state(Pose((x, y, before.position[2]), turn))
        state.robot = state.before = self.motion()
        return place

    def touches(self) -> bool:
        """Whether it touches what it does not touch at rest."""
        return bool(self._touching() - self._at_rest)

    def motion(self) -> Any:
        """Motion of its root link."""
        return motion_from(*self.model.link_motion(self.model.description.root))

    def decide(self, action: Any) -> np.ndarray:
        """The numbers of the topics for an action.

        Raises:
            GymError: its shape or a number is wrong.
        """
        self.state.before, self.state.action = self.state.robot, self.actions.numbers(action)
        return self.state.action

    def finish(self, steps: int, time: float) -> tuple[float, str]:
        """Reward and end after the action that is number `steps`, at a time of the run [s].

        Raises:
            RewardError: the reward is no finite number, or reward or end raises an exception.
        """
        state = self.state
        self.task.acted(state)
        state.steps, state.time, state.robot = steps, time, self.motion()
        new = self._touching() - self._at_rest if self.task.feels else ()
        state.touched = self._names({number for number, _ in new}) if new else ()
        return self._judged("reward", self.task.reward), self._judged("end", self.task.end)

    def _names(self, numbers: set[int]) -> tuple[str, ...]:
        models = self._world.world.models.values()
        return tuple(m.name for m in models if m.body.number in numbers) or ("world",)

    def _judged(self, name: str, function: Any) -> Any:
        """What reward or end of the task return."""
        try:
            value = function(self.state)
            if name == "end":
                return str(value or "")
            value = float(value)
        except RewardError:
            raise
        except Exception as error:
            kind = type(error).__name__
            raise RewardError(f"{name} of the task raised {kind}: {error}") from error
        if not math.isfinite(value):
            raise RewardError(f"reward is {value}, must be a finite number; state: {self.state}")
        return value

    def observe(self) -> Any:
        """The observation now."""
        seen = {name: self._seen(name) for name in self.observed}
        seen.update(self.task.observe(self.state))
        return next(iter(seen.values())) if self._alone else seen

    def _seen(self, name: str) -> np.ndarray:
        values = self.observed[name].read()
        is_image = values.dtype == np.uint8 and values.ndim > 1
        return self.variation.change_image(values) if is_image else values

    def info(self, end: str) -> dict[str, Any]:
        """What is told of the robot after an action."""
        state = self.state
        return {
            "end": end,
            "time": state.time,
            "x": state.robot.x,
            "y": state.robot.y,
            "touched": ", ".join(state.touched),
            **self.task.info(state),
        }


def steps_of(number: int, period: float, time_step: float) -> int:
    """Physics steps of the action of a number, from 1; a period need be no multiple of a step."""
    before, after = (math.floor(n * period / time_step + 0.5) for n in (number - 1, number))
    return after - before
