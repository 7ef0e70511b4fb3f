"""Spaces of any robot: actions on topics that take commands, observations of topics."""

from __future__ import annotations

import difflib
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Callable

import numpy as np
from bullet_sim.controllers.drive import Drive as DriveController
from bullet_sim.parts.outputs import ImageOutput, NumbersOutput, ScanOutput
from bullet_sim.plugins.bases import TricyclePlugin
from bullet_sim.plugins.drives import DrivenBase
from gymnasium import spaces

from paddock_gym.errors import GymError
from paddock_gym.observations import over
from paddock_gym.simulation.robot_world import Command, RobotWorld, Topic

TWIST, NUMBER, NUMBERS = "geometry_msgs/Twist", "std_msgs/Float64", "std_msgs/Float64MultiArray"
SPEED, YAW_RATE = 1.0, 2.0  # [m/s], [rad/s] of a base whose description gives no limit
WHEEL_SPEED, EFFORT = 10.0, 1.0  # [rad/s], [N m] of a joint without limits
TRUTH = "truth"  # observation: pose and velocity of a model or link, 13 numbers


@dataclass
class Vector:
    """geometry_msgs/Vector3."""

    x: float = 0.0
    y: float = 0.0
    z: float = 0.0


@dataclass
class Twist:
    """geometry_msgs/Twist [m/s, rad/s]."""

    linear: Vector = field(default_factory=Vector)
    angular: Vector = field(default_factory=Vector)


@dataclass
class Data:
    """std_msgs/Float64 or Float64MultiArray."""

    data: Any


def unknown(kind: str, name: str, there: Iterable[str]) -> GymError:
    """The error of a name that is not there, with the nearest one first."""
    names = list(there)
    near = difflib.get_close_matches(name, names, 1)
    hint = f"; did you mean {near[0]!r}?" if near else ""
    return GymError(f"{kind} is {name!r}, must be one of {', '.join(names) or '(none)'}{hint}")


def resolved(name: str) -> str:
    """A topic's name with its leading slash."""
    return name if name.startswith("/") else f"/{name}"


# actions ----------------------------------------------------------------------------------------
class CommandedTopic:
    """Numbers of an action that become messages of one topic.

    Attributes:
        message: type of the messages.
        names: of the numbers, with their units.
        low, high: (n,) their bounds.
    """

    def __init__(self, topic: str, command: Command, limits: Any = None) -> None:
        self.topic, self._command, self.message = topic, command, command.message
        owner = command.owner
        if command.message == TWIST:
            self.names, low, high = _twist_numbers(command)
        elif command.message in (NUMBER, NUMBERS):
            self.names, low, high = _joint_numbers(owner)
        else:
            raise GymError(
                f"action is {topic!r}, which takes {command.message}; an action can be "
                f"{TWIST}, {NUMBER} or {NUMBERS}"
            )
        if limits is not None:
            low, high = limits
        shape = (len(self.names),)
        try:
            self.low, self.high = (
                np.broadcast_to(np.asarray(bound, np.float64), shape) for bound in (low, high)
            )
        except ValueError as error:
            raise GymError(f"limits of {topic} are {limits!r}, must be {shape[0]} each") from error
        if not (self.low < self.high).all() or not np.isfinite((self.low, self.high)).all():
            raise GymError(f"limits of {topic} are {low} and {high}, must be finite and ascending")

    def send(self, values: Sequence[float]) -> None:
        """Send a message with these numbers."""
        message: Any
        if self._command.message == TWIST:
            message = Twist()
            message.linear.x, message.angular.z = values[0], values[-1]
            if len(values) == 3:
                message.linear.y = values[1]
        else:
            is_one = self._command.message == NUMBER
            message = Data(values[0] if is_one else list(values))
        self._command.take(message)


def _wheel_limit(model: Any, names: Iterable[str]) -> float:
    """Lowest velocity limit of joints [rad/s]; infinite: none has one."""
    limits = [model.description.joints[name].velocity for name in names]
    return min((limit for limit in limits if limit > 0.0), default=math.inf)


def _twist_numbers(command: Command) -> tuple[list[str], Any, Any]:
    owner, model = command.owner, command.model
    speed, yaw_rate = SPEED, YAW_RATE
    names = ["linear.x [m/s]", "angular.z [rad/s]"]
    if isinstance(owner, DrivenBase):
        if isinstance(owner, TricyclePlugin):
            return ["speed [m/s]", "steering angle [rad]"], (-speed, -0.8), (speed, 0.8)
        spec = owner.spec
        if hasattr(spec, "left"):
            limit = _wheel_limit(model, (*spec.left, *spec.right)) * spec.diameter / 2.0
            speed = min(speed, limit)
            yaw_rate = min(yaw_rate, 2.0 * limit / (spec.separation or 1.0))
        if len(owner.standing) == 3:
            names.insert(1, "linear.y [m/s]")
            return names, (-speed, -speed, -yaw_rate), (speed, speed, yaw_rate)
        return names, (-speed, -yaw_rate), (speed, yaw_rate)
    if isinstance(owner.controller, DriveController):
        config = owner.config
        bounds = [
            (-default, default) if limiter.velocity is None else limiter.velocity
            for limiter, default in ((config.linear, speed), (config.angular, yaw_rate))
        ]
        low, high = zip(*bounds)
        return names, low, high
    return names, (-speed, -yaw_rate), (speed, yaw_rate)


def _joint_numbers(topics: Any) -> tuple[list[str], Any, Any]:
    """Of a controller of joints: its interface's limits of each."""
    rows: list[tuple[str, float, float]] = []
    interface, kind = topics.controller.interface, topics.config.type
    for name in topics.config.joints:
        joint = topics.controller.hardware.joints.limits[name]
        unit = "m" if joint.kind == "prismatic" else "rad"
        if interface == "velocity" or "Velocity" in kind:
            bound = joint.velocity or WHEEL_SPEED
            rows.append((f"{name} [{unit}/s]", -bound, bound))
        elif interface == "position" or "Position" in kind:
            half = 1.0 if unit == "m" else math.pi
            bounds = (-half, half)
            if joint.lower is not None and joint.upper is not None and joint.lower < joint.upper:
                bounds = joint.lower, joint.upper
            rows.append((f"{name} [{unit}]", *bounds))
        else:
            bound = joint.effort or EFFORT
            rows.append((f"{name} [{'N' if unit == 'm' else 'N m'}]", -bound, bound))
    names, low, high = zip(*rows)
    return list(names), low, high


class Actions:
    """Actions on topics.

    Args:
        names: topics; None: the only one that takes a Twist, else all that take numbers.
        limits: topic -> (low, high) instead of those of the description.
        scaled: actions are from -1 to 1, which are low and high.
        robot: whose topics count where none are named; empty: all.

    Attributes:
        space: Box.
        names: of its numbers; low, high: their bounds in units of the topics.
    """

    def __init__(
        self,
        world: RobotWorld,
        names: str | Iterable[str] | None = None,
        limits: Mapping[str, Any] | None = None,
        scaled: bool = False,
        robot: str = "",
    ) -> None:
        there, limits = world.commands, {resolved(k): v for k, v in (limits or {}).items()}
        own = {k: v for k, v in there.items() if not robot or v.model.name == robot}
        given = _default(own) if names is None else names
        chosen = [resolved(name) for name in ((given,) if isinstance(given, str) else given)]
        for name in (*chosen, *limits):
            if name not in there:
                raise unknown("action", name, there)
        self.topics = [CommandedTopic(name, there[name], limits.get(name)) for name in chosen]
        self.scaled = scaled
        rows = [(f"{topic.topic}: {name}") for topic in self.topics for name in topic.names]
        self.names = rows
        self.low, self.high = (
            np.concatenate([getattr(topic, bound) for topic in self.topics] or [np.zeros(0)])
            for bound in ("low", "high")
        )
        low, high = (-np.ones(len(rows)), np.ones(len(rows))) if scaled else (self.low, self.high)
        self.space = spaces.Box(low.astype(np.float32), high.astype(np.float32), dtype=np.float32)

    def numbers(self, action: Any) -> np.ndarray:
        """The numbers of the topics, within their bounds, for an action.

        Raises:
            GymError: wrong shape, or no finite numbers.
        """
        values = np.asarray(action, np.float64)
        if values.shape != self.space.shape:
            raise GymError(
                f"action has the shape {values.shape}, must be {self.space.shape}: "
                f"{', '.join(self.names)}"
            )
        if not np.isfinite(values).all():
            raise GymError(f"action is {values.tolist()}, must be finite numbers")
        if self.scaled:
            values = self.low + (values + 1.0) * 0.5 * (self.high - self.low)
        return np.clip(values, self.low, self.high)

    def stop(self) -> None:
        """Send zeros, which are at rest for what is commanded by velocities or efforts."""
        self.send(np.zeros(len(self.names)))

    def send(self, numbers: np.ndarray) -> None:
        """Send the messages of numbers()."""
        values, begin = numbers.tolist(), 0
        for topic in self.topics:
            end = begin + len(topic.names)
            topic.send(values[begin:end])
            begin = end


def _default(commands: Mapping[str, Command]) -> list[str]:
    twists = [name for name, command in commands.items() if command.message == TWIST]
    if len(twists) > 1:
        raise GymError(f"action has to be given: Twist is taken by {', '.join(twists)}")
    numbers = [name for name, command in commands.items() if command.message in (NUMBER, NUMBERS)]
    return twists or numbers


# observations -----------------------------------------------------------------------------------
@dataclass
class Observed:
    """One observation.

    Attributes:
        read: without arguments: its array.
        topic: that it is of, or None.
        most: what ranges are over [m], or 0.
        link: MODEL::LINK whose truth it is.
    """

    space: spaces.Box
    read: Callable[[], np.ndarray]
    topic: Topic | None = None
    most: float = 0.0
    link: str = ""


def observed(world: RobotWorld, name: str) -> Observed:
    """The observation of a name: a topic as policies take it, "TOPIC:FIELD" as the message has it,
    or "truth", "truth:MODEL", "truth:MODEL::LINK".

    Raises:
        GymError: there is no such topic, field, model or link.
    """
    if name == TRUTH or name.startswith(f"{TRUTH}:"):
        return _truth(world, name)
    text, _, part = name.partition(":")
    text = resolved(text)
    if text not in world.topics:
        raise unknown("observation", text, (*world.topics, TRUTH))
    topic = world.topics[text]
    shapes = topic.output.shapes()
    if not shapes:
        raise GymError(
            f"observation is {text!r}: a {topic.output.MESSAGE} has no fixed size; others are "
            f"{', '.join(world.topics)}"
        )
    if part:
        if part not in shapes:
            raise unknown(f"field of {text}", part, shapes)
        shape = shapes[part]
        space = spaces.Box(shape.low, shape.high, shape.shape, shape.dtype)  # type: ignore[arg-type]
        return Observed(space, lambda: topic.fields[part], topic)
    return _learned(topic)


def _learned(topic: Topic) -> Observed:
    """A topic as policies take it: ranges over their maximum, images, else all numbers in a row."""
    output = topic.output
    if isinstance(output, ScanOutput):
        most = output.spec.range_max or 1.0
        space = spaces.Box(0.0, 1.0, (output.count,), np.float32)
        return Observed(space, lambda: over(topic.fields["ranges"], most), topic, most)
    if isinstance(output, NumbersOutput) and "max_range" in output.constant:
        most = output.constant["max_range"] or 1.0
        space = spaces.Box(0.0, 1.0, (1,), np.float32)
        return Observed(space, lambda: over(topic.fields["range"], most), topic, most)
    if isinstance(output, ImageOutput):
        shape = output.shapes()["data"]
        space = spaces.Box(shape.low, shape.high, shape.shape, shape.dtype)  # type: ignore[arg-type]
        if shape.dtype != np.float32:
            return Observed(space, lambda: topic.fields["data"], topic)
        return Observed(space, lambda: np.nan_to_num(topic.fields["data"], posinf=0.0), topic)
    shapes = output.shapes()
    if set(shapes) == {"points"}:
        bounds = spaces.Box(-np.inf, np.inf, shapes["points"].shape, np.float32)
        return Observed(bounds, lambda: topic.fields["points"], topic)
    low, high = (
        np.concatenate([np.full(s.shape, getattr(s, bound), np.float32) for s in shapes.values()])
        for bound in ("low", "high")
    )

    def row() -> np.ndarray:
        fields = topic.fields
        return np.concatenate([fields[name] for name in shapes]).astype(np.float32)

    # rounding to float32 may leave a bound of a quaternion
    space = spaces.Box(np.where(low > -np.inf, low - 1e-3, low), high + 1e-3, dtype=np.float32)
    return Observed(space, row, topic)


def _truth(world: RobotWorld, name: str) -> Observed:
    _, _, place = name.partition(":")
    model_name, _, link = place.partition("::")
    robots = world.robot_models
    if not model_name:
        if not robots:
            raise GymError(f"observation is {name!r}: no model takes commands; name one")
        model_name = next(iter(robots))
    if model_name not in world.world.models:
        raise unknown("model of an observation", model_name, world.world.models)
    model = world.world.models[model_name]
    if link and link not in model.link_names:
        raise unknown(f"link of '{model_name}'", link, model.link_names)
    link = link or model.description.root

    def read() -> np.ndarray:
        return np.concatenate(model.link_motion(link))

    space = spaces.Box(-np.inf, np.inf, (13,), np.float64)
    return Observed(space, read, link=f"{model_name}::{link}")
