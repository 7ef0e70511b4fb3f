"""Actions: continuous ones from -1 to 1, or a model_metadata.json."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, Union

import numpy as np

from paddock_gym.contract import hyperparameters
from paddock_gym.errors import GymError

MAX_STEERING = 30.0  # [degrees]
SPEEDS = (0.1, 4.0)  # [m/s]
SENSORS = (
    "FRONT_FACING_CAMERA",
    "STEREO_CAMERAS",
    "LIDAR",
    "SECTOR_LIDAR",
    "DISCRETIZED_SECTOR_LIDAR",
)


@dataclass(frozen=True)
class Continuous:
    """Two numbers from -1 to 1: steering, speed.

    Attributes:
        steering: (low, high) [degrees], positive to the left.
        speed: (low, high) [m/s].
    """

    bounds: ClassVar[tuple[float, float]] = (-1.0, 1.0)
    steering: tuple[float, float] = (-MAX_STEERING, MAX_STEERING)
    speed: tuple[float, float] = (0.5, 4.0)

    def command(self, action: Sequence[float] | np.ndarray) -> tuple[float, float]:
        """(speed [m/s], steering [rad]) of an action (2,); beyond -1 and 1 it is clipped."""
        steer, throttle = (min(1.0, max(-1.0, float(value))) for value in action)
        return _denormalize(self.speed, throttle), math.radians(_denormalize(self.steering, steer))

    def action(self, speed: float, steering: float) -> np.ndarray:
        """The action (2,) closest to a command [m/s], [rad]."""
        pair = (_normalize(self.steering, math.degrees(steering)), _normalize(self.speed, speed))
        return np.array(pair, dtype=np.float32)


@dataclass(frozen=True)
class Discrete:
    """An index of a row.

    Attributes:
        rows: ((steering [degrees], speed [m/s]), ...).
    """

    rows: tuple[tuple[float, float], ...]

    def command(self, action: int | np.integer) -> tuple[float, float]:
        """(speed [m/s], steering [rad]) of an action."""
        steering, speed = self.rows[int(action)]
        return speed, math.radians(steering)

    def action(self, speed: float, steering: float) -> int:
        """Index of the row closest to a command [m/s], [rad]: by steering, then by speed."""
        degrees = math.degrees(steering)
        distances = [
            (abs(angle - degrees), abs(row_speed - speed)) for angle, row_speed in self.rows
        ]
        return distances.index(min(distances))


Actions = Union[Continuous, Discrete]


def _normalize(interval: tuple[float, float], value: float) -> float:
    low, high = interval
    return min(1.0, max(-1.0, 2.0 * (value - low) / (high - low) - 1.0)) if high > low else 0.0


def _denormalize(interval: tuple[float, float], value: float) -> float:
    low, high = interval
    return low + (high - low) * (value + 1.0) / 2.0


def parse(action: str | dict[str, Any] | Actions) -> Actions:
    """Parse the option `action`.

    Args:
        action: "continuous", the path of a model_metadata.json, its content as a dict, or what
            parse() has returned before.

    Raises:
        GymError: it is not valid.
    """
    if isinstance(action, (Continuous, Discrete)):
        return action
    if action == "continuous":
        return Continuous()
    if isinstance(action, dict):
        return _parse("the action", action)
    if not isinstance(action, str) or not action.endswith(".json"):
        raise GymError(
            f"action is {action!r}; it must be continuous, or the path of a model_metadata.json"
        )
    return _parse(action, hyperparameters.load_json(action))


def table(actions: Actions) -> dict[str, Any]:
    """The content of a model_metadata.json with these actions."""
    if isinstance(actions, Discrete):
        rows = [{"steering_angle": angle, "speed": speed} for angle, speed in actions.rows]
        return {"action_space": rows, "action_space_type": "discrete"}
    intervals = {
        key: {"low": low, "high": high}
        for key, (low, high) in (
            ("steering_angle", actions.steering),
            ("speed", actions.speed),
        )
    }
    return {"action_space": intervals, "action_space_type": "continuous"}


def ranges(content: dict[str, Any]) -> Continuous:
    """Continuous actions of table()'s result; their ranges may exceed a DeepRacer's.

    Raises:
        KeyError, TypeError: content is not such a table.
    """
    space = content["action_space"]
    return Continuous(
        *((space[key]["low"], space[key]["high"]) for key in ("steering_angle", "speed"))
    )


def _parse(path: str, data: dict[str, Any]) -> Actions:
    if "action_space" not in data:
        raise GymError(f"{path}: action_space is missing; it must be a list, or two ranges")
    for sensor in data.get("sensor", ()):
        hyperparameters.one_of(path, "sensor", sensor, SENSORS)
    space = data["action_space"]
    space_type = data.get(
        "action_space_type", "discrete" if isinstance(space, list) else "continuous"
    )
    hyperparameters.one_of(path, "action_space_type", space_type, ("discrete", "continuous"))
    return _discrete(path, space) if space_type == "discrete" else _continuous(path, space)


def _discrete(path: str, space: Any) -> Discrete:
    if not isinstance(space, list) or not space:
        raise GymError(f"{path}: action_space is {space!r}; discrete ones are a list of actions")
    rows = []
    for index, row in enumerate(space):
        key = f"action_space[{index}]"
        if not isinstance(row, dict) or not {"steering_angle", "speed"} <= row.keys():
            raise GymError(f"{path}: {key} is {row!r}; it must have steering_angle and speed")
        rows.append(
            (
                _angle(path, f"{key}.steering_angle", row["steering_angle"]),
                hyperparameters.json_number(path, f"{key}.speed", row["speed"], *SPEEDS, "m/s"),
            )
        )
    return Discrete(tuple(rows))


def _continuous(path: str, space: Any) -> Continuous:
    intervals = {}
    for key, low, high, unit in (
        ("steering_angle", -MAX_STEERING, MAX_STEERING, "degrees"),
        ("speed", *SPEEDS, "m/s"),
    ):
        limits = space.get(key) if isinstance(space, dict) else None
        if not isinstance(limits, dict) or not {"low", "high"} <= limits.keys():
            raise GymError(
                f"{path}: action_space.{key} is {limits!r}; continuous ones have low and high"
            )
        first, last = (
            hyperparameters.json_number(
                path, f"action_space.{key}.{side}", limits[side], low, high, unit
            )
            for side in ("low", "high")
        )
        intervals[key] = first, last
        if first > last:
            raise GymError(f"{path}: action_space.{key}.low is above high: {intervals[key]}")
    return Continuous(intervals["steering_angle"], intervals["speed"])


def _angle(path: str, key: str, value: Any) -> float:
    if isinstance(value, str):  # the console's older files have numbers in quotes
        try:
            value = float(value)
        except ValueError:
            pass
    return hyperparameters.json_number(path, key, value, -MAX_STEERING, MAX_STEERING, "degrees")
