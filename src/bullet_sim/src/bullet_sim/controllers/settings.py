"""Settings of controllers: a mapping of a YAML file, read and checked, and what comes of it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any, NoReturn

from bullet_sim.errors import ControllerError


def as_number(value: Any) -> float | None:
    """The value as a finite float, or None.

    YAML 1.1 reads 1e6 and 1.0e6 as strings (it requires 1.0e+6), so a numeric string counts.
    """
    if isinstance(value, str):
        try:
            value = float(value)
        except ValueError:
            return None
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return None
    try:
        value = float(value)
    except OverflowError:  # an integer of 400 digits
        return None
    return value if math.isfinite(value) else None


class Settings:
    """One mapping of a YAML file.

    Args:
        label: name for messages, e.g. "controller 'drive'".

    Attributes:
        name: of the controller whose settings these are.

    Raises:
        ControllerError: it is no mapping.
    """

    def __init__(self, values: Any, label: str, name: str = "") -> None:
        if not isinstance(values, dict):
            raise ControllerError(f"{label} is {values!r}, must be a mapping")
        self.label, self.name = label, name
        self._values: dict[Any, Any] = values
        self._asked: set[str] = set()
        self._blocks: list[Settings] = []

    def get(self, key: str, default: Any = None) -> Any:
        """A value as it is."""
        self._asked.add(key)
        return self._values.get(key, default)

    def __contains__(self, key: str) -> bool:
        return key in self._values

    def number(self, key: str, default: Any, above: float | None = None) -> Any:
        """A finite number; the default, unchecked, if it is missing.

        Args:
            above: exclusive minimum.
        """
        self._asked.add(key)
        if key not in self._values:
            return default
        value = as_number(self._values[key])
        if value is None or (above is not None and value <= above):
            expected = "a finite number" if above is None else f"a number above {above:g}"
            raise ControllerError(
                f"{self.label} has {key} {self._values[key]!r}, must be {expected}"
            )
        return value

    def flag(self, key: str, default: bool) -> bool:
        """True or false."""
        value = self.get(key, default)
        if not isinstance(value, bool):
            raise ControllerError(f"{self.label} has {key} {value!r}, must be true or false")
        return value

    def text(self, key: str, default: str | None) -> str:
        """A string that is not empty."""
        value = self.get(key, default)
        if not isinstance(value, str) or not value:
            raise ControllerError(f"{self.label} has {key} {value!r}, must be a name")
        return value

    def rate(self) -> float:
        """The publish_rate [Hz]."""
        value: float = self.number("publish_rate", 50.0, above=0.0)
        return value

    def joint(self, key: str, known: Sequence[str]) -> str:
        """The name of one of the robot's movable joints; `known` are all of them."""
        name: str = self.get(key)
        if name is None:
            raise ControllerError(f"{self.label} has {key} {name!r}, must be a joint name")
        check_joints([name], self.label, known)
        return name

    def joints(self, key: str, known: Sequence[str]) -> tuple[str, ...]:
        """As joint(), of a list of at least one."""
        names = self.get(key)
        if not isinstance(names, list) or not names:
            raise ControllerError(
                f"{self.label} has {key} {names!r}, must be a list of joint names"
            )
        check_joints(names, self.label, known)
        return tuple(names)

    def block(self, *keys: str) -> Settings:
        """Settings of a mapping within this one; a missing one is empty."""
        inner = self
        for key in keys:
            block = Settings(inner.get(key, {}), f"{inner.label} {key}")
            inner._blocks.append(block)
            inner = block
        return inner

    def ignore(self, *keys: str) -> list[str]:
        """Mark keys as known; returns those that are present."""
        self._asked.update(keys)
        return [key for key in keys if key in self._values]

    def unknown(self) -> list[str]:
        """A message for each key that was not read, also in nested blocks."""
        unread = [
            f"{self.label} has key '{key}', which means nothing here and is ignored"
            for key in sorted(set(self._values) - self._asked, key=str)
        ]
        return unread + [text for block in self._blocks for text in block.unknown()]


def check_joints(joints: Sequence[Any], label: str, known: Sequence[str]) -> None:
    """Check joints' names.

    Raises:
        ControllerError: one does not exist or is there twice.
    """
    for number, joint in enumerate(joints):
        if joint not in known:
            raise ControllerError(
                f"{label} names joint '{joint}', which does not exist; joints "
                f"are {', '.join(known) or '(none)'}"
            )
        if joint in joints[:number]:
            raise ControllerError(f"{label} names joint '{joint}' twice, must be once")


REQUIRED: Any = object()  # for type checkers, in the place of a default that a field does not have


def _missing(owner: str, name: str) -> NoReturn:
    """Raise TypeError: a field without a default was not given."""
    raise TypeError(f"{owner}() needs {name}=")


@dataclass(frozen=True)
class ControllerConfig:
    """One checked entry of the controllers' YAML; types of controllers add their own fields.

    Attributes:
        name: the entry's key.
        type: its ros_control name.
        joints: joint names; empty for a state controller that reports all.
        claims: (interface, joint names) pairs; empty for a controller that commands nothing.
        publish_rate: of what it reports [Hz].
        notes: messages about keys that are accepted without effect.
        warnings: messages about keys that are ignored.

    Fields are given by name, so those of a subclass need no defaults although these have some.
    """

    name: str
    type: str = ""
    joints: tuple[str, ...] = ()
    claims: tuple[tuple[str, tuple[str, ...]], ...] = ()
    publish_rate: float = 50.0
    notes: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()

    def __init_subclass__(cls) -> None:
        # What dataclass(kw_only=True) is for, which came with Python 3.10.
        for name, kind in vars(cls).get("__annotations__", {}).items():
            if vars(cls).get(name, REQUIRED) is REQUIRED and "ClassVar" not in str(kind):
                setattr(cls, name, field(default_factory=partial(_missing, cls.__name__, name)))
