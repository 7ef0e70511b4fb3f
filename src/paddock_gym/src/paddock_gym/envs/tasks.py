"""What a robot is to do: where it starts, what its reward is, when a run ends."""

from __future__ import annotations

import importlib
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from bullet_sim.models.model import Model
from bullet_sim.pose import Pose
from gymnasium import spaces

from paddock_gym.course import Motion, motion_from
from paddock_gym.errors import GymError
from paddock_gym.observations import goal_row, polar
from paddock_gym.simulation.randomize import VARIABLE, Variation
from paddock_gym.simulation.recipe import Spawn
from paddock_gym.simulation.robot_world import RobotWorld, Topic

Start = "tuple[float, float, float]"  # x, y [m], yaw [rad]
_CYLINDER = """<sdf version="1.6"><model name="o"><static>true</static><link name="link">
<collision name="c"><geometry><cylinder><radius>{r}</radius><length>{h}</length></cylinder>
</geometry></collision><visual name="v"><geometry><cylinder><radius>{r}</radius>
<length>{h}</length></cylinder></geometry><material><ambient>0.75 0.55 0.3 1</ambient>
<diffuse>0.75 0.55 0.3 1</diffuse></material></visual></link></model></sdf>"""
FAR = -100.0  # [m] height of obstacles before the first run


@dataclass
class State:
    """A run as rewards and ends see it, after an action.

    Attributes:
        time: of the run [s].
        steps: actions of the run.
        robot: its motion in the world.
        action: the numbers that were commanded, in units of the topics.
        touched: names of models that the robot touches and did not touch at rest.
        world: all of it: models, topics.
        before: the robot's motion before the action.
        memory: what a task keeps during a run, by its own names.
    """

    world: RobotWorld
    model: Model
    time: float = 0.0
    steps: int = 0
    robot: Motion = Motion(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    before: Motion = Motion(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    action: np.ndarray = field(default_factory=lambda: np.zeros(0))
    touched: tuple[str, ...] = ()
    memory: dict[str, Any] = field(default_factory=dict)

    @property
    def crashed(self) -> bool:
        """Whether the robot touches what it did not touch at rest."""
        return bool(self.touched)

    def motion(self, model: str) -> Motion:
        """Motion of a model's root link."""
        found = self.world.world.model(model)
        return motion_from(*found.link_motion(found.description.root))

    def sensor(self, topic: str) -> Mapping[str, np.ndarray]:
        """Arrays of the last message of an observed topic, by the message's names."""
        found: Topic = self.world.topics[topic]
        return found.fields


class Task:
    """A task that ends with a crash and rewards nothing; the base of all.

    Attributes:
        spaces: observations of its own, by their names.
        topics: that reward and end use, beside those observed.
        alone: its only observation is the environment's, not an entry of a dict.
        feels: whether it asks what the robot touches.
        variable: what `vary` may name.
    """

    spaces: Mapping[str, spaces.Box] = {}
    topics: Sequence[str] = ()
    alone, feels = False, True
    variable: tuple[str, ...] = VARIABLE

    def models(self) -> Sequence[Spawn]:
        """Models that the task adds to the world."""
        return ()

    def made(self, world: RobotWorld, model: Model, variation: Variation) -> Any:
        """The world has been made.

        Returns:
            What takes the actions: space, numbers() and send() as of topics.Actions; None: topics.
        """

    def rested(self, world: RobotWorld) -> None:
        """The robot stands as each run begins."""

    def start(self, state: State, rng: np.random.Generator) -> tuple[float, float, float] | None:
        """Begin a run.

        Returns:
            Where the robot starts: x, y [m], yaw [rad]; None: where it stands at rest, or where
            this has put it.
        """
        return None

    def begun(self, state: State) -> None:
        """The robot has been put to its start."""

    def drive(self, world: RobotWorld, actions: Any, numbers: Any, steps: int) -> None:
        """Command an action's numbers, make physics steps."""
        actions.send(numbers)
        world.advance(steps)

    def acted(self, state: State) -> None:
        """The time of an action has passed."""

    def observe(self, state: State) -> Mapping[str, np.ndarray]:
        """Values of `spaces`."""
        return {}

    def info(self, state: State) -> Mapping[str, Any]:
        """What is told of the run, beside end, time, place and what is touched."""
        return {}

    def truncates(self, state: State, end: str) -> bool:
        """Whether the run, which may have ended, is truncated and not terminated."""
        return False

    def reward(self, state: State) -> float:
        """Of the last action."""
        return 0.0

    def end(self, state: State) -> str:
        """Why the run ends after the last action, or ''."""
        return "crashed" if state.crashed else ""


class Goal(Task):
    """Reach a goal among cylinders.

    The observation "goal" is the distance [m] over `area`, sine and cosine of the bearing in the
    robot's frame. The reward is the way gained towards the goal [m], less 0.01 an action, 5 more
    at the goal and 5 less for a crash.

    Args:
        area: half the side of the square [m] in which starts, goals and obstacles are.
        obstacles: how many.
        radius: of an obstacle [m]; clear: free room around starts and goals [m].
        reached: distance at which the goal is reached [m].
    """

    spaces = {"goal": spaces.Box(-1.0, 4.0, (3,), np.float32)}

    def __init__(
        self,
        area: float = 3.0,
        obstacles: int = 6,
        radius: float = 0.2,
        clear: float = 0.6,
        reached: float = 0.3,
    ) -> None:
        self.area, self.count, self.radius = area, obstacles, radius
        self.clear, self.reached = clear, reached

    def models(self) -> Sequence[Spawn]:
        text = _CYLINDER.format(r=self.radius, h=1.0)
        return [
            Spawn(f"obstacle_{number}", text, Pose((3.0 * number, 0.0, FAR)))
            for number in range(self.count)
        ]

    def start(self, state: State, rng: np.random.Generator) -> tuple[float, float, float] | None:
        room = self.radius + self.clear
        x, y = rng.uniform(-self.area, self.area, 2)
        goal = self._apart(rng, [(x, y)], self.area)
        places: list[tuple[float, float]] = []
        for number in range(self.count):
            place = self._apart(rng, [(x, y), goal, *places], room)
            places.append(place)
            obstacle = state.world.world.model(f"obstacle_{number}")
            obstacle.set_state(Pose((*place, 0.5)))
        state.memory.update(goal=goal, obstacles=places)
        return float(x), float(y), float(rng.uniform(-math.pi, math.pi))

    def _apart(
        self, rng: np.random.Generator, others: Sequence[tuple[float, float]], room: float
    ) -> tuple[float, float]:
        """A place at least `room` [m] from others; after many tries the last one counts."""
        for _ in range(100):
            x, y = map(float, rng.uniform(-self.area, self.area, 2))
            if all(math.hypot(x - u, y - v) >= room for u, v in others):
                break
        return x, y

    def begun(self, state: State) -> None:
        state.memory["distance"] = self._polar(state)[0]

    def _polar(self, state: State) -> tuple[float, float]:
        """Distance [m] and bearing [rad] of the goal from the robot."""
        return polar(state.memory["goal"], *state.robot[:3])

    def observe(self, state: State) -> Mapping[str, np.ndarray]:
        return {"goal": goal_row(*self._polar(state), self.area)}

    def reward(self, state: State) -> float:
        distance, end = self._polar(state)[0], self.end(state)
        gained, state.memory["distance"] = state.memory["distance"] - distance, distance
        return gained - 0.01 + {"reached": 5.0, "": 0.0}.get(end, -5.0)

    def end(self, state: State) -> str:
        if state.crashed:
            return "crashed"
        distance = self._polar(state)[0]
        if distance < self.reached:
            return "reached"
        return "left" if max(abs(state.robot.x), abs(state.robot.y)) > 2.0 * self.area else ""


class Lane(Task):
    """Follow a line of points, within a lane's width.

    The observation "lane" is the lateral offset over half the width (left positive), sine and
    cosine of the heading error, and the line's direction `ahead` metres further on, as sine and
    cosine in the robot's frame. The reward is the way along the line [m] times
    exp(-(offset / (width / 4))^2), less 1 when the run ends off the lane.

    Args:
        points: (x, y) [m]; two or more.
        closed: the last is joined to the first.
        width: of the lane [m].
        ahead: [m].
    """

    spaces = {"lane": spaces.Box(-4.0, 4.0, (5,), np.float32)}

    def __init__(
        self,
        points: Sequence[Sequence[float]],
        closed: bool = True,
        width: float = 1.0,
        ahead: float = 0.5,
    ) -> None:
        line = np.asarray(points, float)
        if line.ndim != 2 or line.shape[1] != 2 or len(line) < 2:
            raise GymError(f"points have the shape {line.shape}, must be (n, 2) with n from 2 on")
        self._line = np.vstack([line, line[:1]]) if closed else line
        steps = np.diff(self._line, axis=0)
        self._lengths = np.hypot(*steps.T)
        self._at = np.concatenate([[0.0], np.cumsum(self._lengths)])
        self.closed, self.width, self.ahead = closed, width, ahead

    @property
    def length(self) -> float:
        """Of the line [m]."""
        return float(self._at[-1])

    def place(self, s: float) -> tuple[float, float, float]:
        """x, y [m] and heading [rad] of the line at an arc length [m]."""
        s = s % self.length if self.closed else min(max(s, 0.0), self.length - 1e-9)
        k = int(np.searchsorted(self._at, s, side="right")) - 1
        k = min(k, len(self._lengths) - 1)
        (x, y), (u, v) = self._line[k], self._line[k + 1]
        part = (s - self._at[k]) / self._lengths[k]
        return x + part * (u - x), y + part * (v - y), math.atan2(v - y, u - x)

    def nearest(self, x: float, y: float) -> tuple[float, float]:
        """Arc length of the nearest point [m], and the offset to the left [m]."""
        first, steps = self._line[:-1], np.diff(self._line, axis=0)
        along = ((x, y) - first) * steps
        part = np.clip(along.sum(axis=1) / self._lengths**2, 0.0, 1.0)
        gaps = (x, y) - (first + part[:, None] * steps)
        k = int(np.argmin((gaps**2).sum(axis=1)))
        cross = steps[k, 0] * gaps[k, 1] - steps[k, 1] * gaps[k, 0]
        offset = math.copysign(math.hypot(*gaps[k]), cross)
        return float(self._at[k] + part[k] * self._lengths[k]), offset

    def start(self, state: State, rng: np.random.Generator) -> tuple[float, float, float] | None:
        x, y, yaw = self.place(rng.uniform(0.0, self.length if self.closed else 0.5 * self.length))
        side = rng.uniform(-0.15, 0.15) * self.width
        return x - side * math.sin(yaw), y + side * math.cos(yaw), yaw + rng.uniform(-0.2, 0.2)

    def begun(self, state: State) -> None:
        self._locate(state)
        state.memory["gained"] = 0.0

    def _locate(self, state: State) -> None:
        s, offset = self.nearest(state.robot.x, state.robot.y)
        gained = s - state.memory.get("s", s)
        if self.closed:
            gained = math.remainder(gained, self.length)
        state.memory.update(s=s, offset=offset, gained=gained, located=state.steps)

    def _updated(self, state: State) -> dict[str, Any]:
        if state.memory.get("located") != state.steps:
            self._locate(state)
        return state.memory

    def observe(self, state: State) -> Mapping[str, np.ndarray]:
        memory, yaw = self._updated(state), state.robot.yaw
        error = yaw - self.place(memory["s"])[2]
        x, y, _ = self.place(memory["s"] + self.ahead)
        bearing = math.atan2(y - state.robot.y, x - state.robot.x) - yaw
        row = (
            2.0 * memory["offset"] / self.width,
            *(math.sin(error), math.cos(error)),
            *(math.sin(bearing), math.cos(bearing)),
        )
        return {"lane": np.clip(row, -4.0, 4.0).astype(np.float32)}

    def reward(self, state: State) -> float:
        memory = self._updated(state)
        weight = math.exp(-((memory["offset"] / (self.width / 4.0)) ** 2))
        return float(memory["gained"] * weight - bool(self.end(state)))

    def end(self, state: State) -> str:
        if state.crashed:
            return "crashed"
        memory = self._updated(state)
        if abs(memory["offset"]) > self.width / 2.0:
            return "off_lane"
        return "" if self.closed or memory["s"] < self.length - 1e-6 else "arrived"


class Wall(Task):
    """Follow the wall on the right at a distance, by a scan.

    The reward is the way ahead [m] times exp(-((range - distance) / 0.2)^2) of the nearest range
    on the right, less 1 for a crash.

    Args:
        scan: topic of a lidar.
        distance: [m].
    """

    def __init__(self, scan: str, distance: float = 0.5) -> None:
        self.topics, self.distance = (scan,), distance

    def reward(self, state: State) -> float:
        (topic,) = self.topics
        spec: Any = vars(state.world.topics[topic].output)["spec"]
        ranges = state.sensor(topic)["ranges"]
        angles = np.linspace(spec.min_angle, spec.max_angle, len(ranges))
        right = np.cos(angles + math.pi / 2.0) > math.cos(0.5)
        near = float(np.min(ranges[right], initial=math.inf))
        way = math.hypot(state.robot.x - state.before.x, state.robot.y - state.before.y)
        way = math.copysign(way, state.robot.forward)
        weight = math.exp(-(((near - self.distance) / 0.2) ** 2)) if math.isfinite(near) else 0.0
        return way * weight - state.crashed


class Explore(Task):
    """Come to where it has not been: 1 for each new cell of a grid, 5 less for a crash.

    Args:
        cell: side of a cell [m].
    """

    def __init__(self, cell: float = 0.5) -> None:
        self.cell = cell

    def begun(self, state: State) -> None:
        state.memory["cells"] = {self._cell(state)}

    def _cell(self, state: State) -> tuple[int, int]:
        return math.floor(state.robot.x / self.cell), math.floor(state.robot.y / self.cell)

    def reward(self, state: State) -> float:
        cells, cell = state.memory["cells"], self._cell(state)
        is_new = cell not in cells
        cells.add(cell)
        return float(is_new) - 5.0 * state.crashed


TASKS: dict[str, Callable[..., Task]] = {
    "none": Task,
    "goal": Goal,
    "line": Lane,
    "lane": Lane,
    "wall": Wall,
    "explore": Explore,
}


def load(option: str, given: Any) -> Any:
    """An object, or that of a text "module:name".

    Raises:
        GymError: it cannot be imported.
    """
    if not isinstance(given, str):
        return given
    module, colon, name = given.partition(":")
    if not colon:
        raise GymError(f"{option} is {given!r}, must be an object or 'module:function'")
    try:
        return getattr(importlib.import_module(module), name)
    except (ImportError, AttributeError) as error:
        raise GymError(f"{option} is {given!r}: {error}") from error


def make_task(
    task: Any,
    options: Mapping[str, Any],
    reward: Any = None,
    end: Any = None,
    start: Any = None,
) -> Task:
    """The Task of an environment's options.

    Args:
        task: a name of TASKS, a Task, a class of one, or "module:name".
        options: arguments of the class.
        reward, end, start: functions that take the place of its methods of that name.

    Raises:
        GymError: there is no such task, or an option is wrong.
    """
    if isinstance(task, str) and ":" not in task:
        if task not in TASKS:
            raise GymError(f"task is {task!r}, must be one of {', '.join(TASKS)}, or module:name")
        made: Any = TASKS[task]
    else:
        made = load("task", task)
    if callable(made):
        try:
            made = made(**options)
        except TypeError as error:
            raise GymError(f"task_options are {dict(options)!r}: {error}") from error
    if not isinstance(made, Task):
        raise GymError(f"task is {task!r}, must be a paddock_gym.envs.tasks.Task")
    for name, given in (("reward", reward), ("end", end), ("start", start)):
        if given is not None:
            function = load(name, given)
            if not callable(function):
                raise GymError(f"{name} is {given!r}, must be a function of a State")
            setattr(made, name, function)
    return made
