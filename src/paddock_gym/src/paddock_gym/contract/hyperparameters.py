"""DeepRacer's JSON files: action spaces, hyperparameters."""

from __future__ import annotations

import json
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from paddock_common.settings import Choice, Number

from paddock_gym.errors import GymError


def load_json(path: str) -> dict[str, Any]:
    """Read a JSON file with a table.

    Raises:
        GymError: it cannot be read, or is not a table.
    """
    try:
        with open(path, encoding="utf-8") as stream:
            data = json.load(stream)
    except OSError as error:
        raise GymError(f"{path}: {error.strerror}; it must be a readable JSON file") from error
    except ValueError as error:
        raise GymError(f"{path} is not JSON ({error})") from error
    if not isinstance(data, dict):
        raise GymError(f"{path} contains {data!r}; it must be a table {{...}}")
    return data


def write_json(path: str, data: Any) -> None:
    """Write data as a JSON file."""
    with open(path, "w", encoding="utf-8") as stream:
        json.dump(data, stream, indent=2)
        stream.write("\n")


def json_number(path: str, key: str, value: Any, low: float, high: float, unit: str = "") -> float:
    """Return a number within a range.

    Raises:
        GymError: it is not a number, or outside the range.
    """
    rule = Number(min=low, max=high, unit=unit)
    return float(rule.check(f"{path}: {key}", value, GymError))


def one_of(path: str, key: str, value: Any, valid: Iterable[str]) -> str:
    """Return a value that is one of the valid ones.

    Raises:
        GymError: it is not.
    """
    return Choice(tuple(valid)).check(f"{path}: {key}", value, GymError)


# Key -> (minimum, maximum) of the console.
RANGES: dict[str, tuple[float, float]] = {
    "batch_size": (8, 4096),
    "num_epochs": (1, 50),
    "lr": (1e-8, 1e-1),
    "beta_entropy": (0.0, 1.0),
    "discount_factor": (0.0, 1.0),
    "num_episodes_between_training": (1, 1000),
}
LOSSES = ("huber", "mse", "mean squared error")
# Known keys that PPO has no use for.
IGNORED = (
    "e_greedy_value",
    "epsilon_steps",
    "exploration_type",
    "stack_size",
    "term_cond_avg_score",
    "term_cond_max_episodes",
    "sac_alpha",
)


@dataclass(frozen=True)
class Hyperparameters:
    """Hyperparameters of a training; None: the default.

    Attributes:
        batch_size, num_epochs, lr, beta_entropy, discount_factor: of PPO.
        num_episodes_between_training: runs between updates; their mean length makes it steps.
        loss_type: of the value function: huber or mse.
        ignored: keys of the file that have no effect.
    """

    batch_size: int | None = None
    num_epochs: int | None = None
    lr: float | None = None
    beta_entropy: float | None = None
    discount_factor: float | None = None
    num_episodes_between_training: int | None = None
    loss_type: str | None = None
    ignored: tuple[str, ...] = ()


def load(path: str) -> Hyperparameters:
    """Read a hyperparameters.json.

    Raises:
        GymError: a key or value is wrong.
    """
    return parse(path, load_json(path))


def parse(path: str, table: dict[str, Any]) -> Hyperparameters:
    """Check the content of a hyperparameters.json.

    Args:
        path: of the file, for messages.

    Raises:
        GymError: a key or value is wrong.
    """
    values: dict[str, Any] = {}
    ignored = []
    for key, value in table.items():
        if key in RANGES:
            number = json_number(path, key, value, *RANGES[key])
            is_integer = isinstance(RANGES[key][0], int)
            if is_integer and number != int(number):
                raise GymError(f"{path}: {key} is {value!r}; it must be a whole number")
            values[key] = int(number) if is_integer else number
        elif key == "loss_type":
            values[key] = "huber" if one_of(path, key, value, LOSSES) == "huber" else "mse"
        elif key in IGNORED:
            ignored.append(key)
        else:
            valid = ", ".join([*RANGES, "loss_type", *IGNORED])
            raise GymError(f"{path}: unknown key {key!r}; there are {valid}")
    return Hyperparameters(**values, ignored=tuple(ignored))
