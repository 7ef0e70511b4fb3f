"""Options of the environments, checked."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from paddock_gym.contract import actions
from paddock_gym.contract.reward_file import RewardFile
from paddock_gym.course import RACES
from paddock_gym.errors import GymError
from paddock_gym.simulation import randomize

OBSERVATIONS = ("state", "lidar", "camera")


@dataclass(frozen=True)
class Options:
    """Options of an environment.

    Attributes:
        observations: names of OBSERVATIONS.
        alone: whether the observation is one array, not a dict.
        colour: whether camera images have three channels.
        reward: None: progress.
        objects: "", "boxes" or "bots".
        randomize: names of randomize.RANDOMIZABLE.
    """

    observations: tuple[str, ...]
    alone: bool
    colour: bool
    actions: actions.Actions
    reward: RewardFile | None
    objects: str
    randomize: frozenset[str]


def parse(
    observation: str | Iterable[str],
    action: str | dict[str, Any] | actions.Actions,
    reward: str,
    race: str,
    randomized: bool | str | Iterable[str],
    colour: bool,
) -> Options:
    """Check the options that a user gave.

    Raises:
        GymError: one is wrong.
    """
    names = (observation,) if isinstance(observation, str) else tuple(observation)
    if not names or len(set(names)) < len(names):
        raise GymError(f"observation is {observation!r}; it must have each name once, at least one")
    for name in names:
        if name not in OBSERVATIONS:
            raise GymError(f"observation is {name!r}; there are {', '.join(OBSERVATIONS)}")
    if race not in RACES:
        raise GymError(f"race is {race!r}; there are {', '.join(RACES)}")
    if not isinstance(reward, str):
        raise GymError(f"reward is {reward!r}; it must be progress, or the path of a Python file")
    return Options(
        names,
        isinstance(observation, str),
        bool(colour),
        actions.parse(action),
        None if reward == "progress" else RewardFile(reward),
        RACES[race],
        frozenset(randomize.parse(randomized)),
    )
