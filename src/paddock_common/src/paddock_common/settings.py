"""Settings of a node or file: frozen dataclasses whose fields have a default and a rule.

    @dataclass(frozen=True)
    class Limits(Checked):
        max_speed: float = number(3.0, above=0.0, unit="m/s")
        trailer: bool = flag(False)

    limits = read(Limits, rospy.get_param)  # ~max_speed, ~trailer

An invalid value raises an error that names the setting, its value and what is valid.
"""

from __future__ import annotations

import math
import numbers
from collections.abc import Callable, Iterable
from dataclasses import Field, dataclass, field, fields
from typing import Any, TypeVar

T = TypeVar("T", bound=Any)


class Rule:
    """What a value must be; subclasses define `complaint`."""

    def complaint(self, value: Any) -> str:
        """Returns what the value must be instead, or "" if it is valid."""
        raise NotImplementedError

    def check(self, name: str, value: Any, error: type[Exception] = ValueError) -> Any:
        """Returns the value unchanged.

        Raises:
            error: The value is not valid; the message has its name, the value and what is valid.
        """
        valid = self.complaint(value)
        if valid:
            raise error(f"{name} is {value!r}; it must be {valid}")
        return value


@dataclass(frozen=True)
class Number(Rule):
    """A finite number within a range; True and False are not numbers.

    Attributes:
        above, below: Exclusive limits of the range; None: no limit.
        min, max: Inclusive limits of the range; None: no limit.
        integer: Whether only whole numbers are valid.
        unit: For the message, e.g. "m/s".
    """

    above: float | None = None
    below: float | None = None
    min: float | None = None
    max: float | None = None
    integer: bool = False
    unit: str = ""

    def complaint(self, value: Any) -> str:
        valid = self._range()
        if not is_number(value) or (self.integer and not isinstance(value, numbers.Integral)):
            kind = "whole " if self.integer else "finite " if isinstance(value, float) else ""
            noun = f"a {kind}number"
            return noun + (", " if valid[:1].isdigit() else " " if valid else "") + valid
        inside = (
            (self.above is None or value > self.above)
            and (self.below is None or value < self.below)
            and (self.min is None or value >= self.min)
            and (self.max is None or value <= self.max)
        )
        return "" if inside else valid

    def _range(self) -> str:
        """Returns the range as text, e.g. "above 0 and below 0.7 [m/s]"."""
        if self.min is not None and self.max is not None:
            limits = f"from {self.min:g} to {self.max:g}"
        else:
            parts = [
                "" if self.above is None else f"above {self.above:g}",
                "" if self.min is None else f"{self.min:g} or more",
                "" if self.below is None else f"below {self.below:.4g}",
                "" if self.max is None else f"at most {self.max:g}",
            ]
            limits = " and ".join(filter(None, parts))
        return " ".join(filter(None, (limits, self.unit and f"[{self.unit}]")))


@dataclass(frozen=True)
class Flag(Rule):
    """True or false."""

    def complaint(self, value: Any) -> str:
        return "" if isinstance(value, bool) else "true or false"


@dataclass(frozen=True)
class Choice(Rule):
    """One of several values.

    Attributes:
        values: The valid ones.
        text: Text of the valid values in messages; "": the values.
    """

    values: tuple[Any, ...]
    text: str = ""

    def complaint(self, value: Any) -> str:
        for valid in self.values:
            if value == valid and isinstance(value, bool) == isinstance(valid, bool):
                return ""
        return self.text or "one of " + ", ".join(map(str, self.values))


@dataclass(frozen=True)
class Text(Rule):
    """A text.

    Attributes:
        empty: Whether it may be empty.
    """

    empty: bool = False

    def complaint(self, value: Any) -> str:
        if isinstance(value, str) and (value or self.empty):
            return ""
        return "a text" if self.empty else "a name"


def is_number(value: Any) -> bool:
    """Returns whether a value is a finite real number, of Python or numpy; booleans are not."""
    if not isinstance(value, numbers.Real) or isinstance(value, bool):
        return False
    try:
        return math.isfinite(value)
    except OverflowError:  # an integer of more than 300 digits
        return False


def converted(name: str, value: Any) -> float:
    """Returns the float of a finite number or of a text that is one, as upstream's nodes accept it.

    Raises:
        ValueError: It is not a number; the message has its name and value.
    """
    try:
        number = value if isinstance(value, bool) else float(value)
    except (TypeError, ValueError, OverflowError):
        number = value
    if not is_number(number):
        raise ValueError(f"{name} is {value!r}; it must be a number")
    return number


_RULE, _NAME = "rule", "name"


def ruled(default: Any, rule: Rule, name: str = "") -> Any:
    """Returns a dataclass field with a default and a Rule.

    Args:
        name: Name of the parameter; "": the field's.
    """
    return field(default=default, metadata={_RULE: rule, _NAME: name})


def number(default: float, name: str = "", **limits: Any) -> Any:
    """Returns a field for a finite number.

    Args:
        limits: Arguments of Number.
    """
    return ruled(default, Number(**limits), name)


def flag(default: bool) -> Any:
    """Returns a field for true or false."""
    return ruled(default, Flag())


def choice(default: Any, values: Iterable[Any], valid: str = "") -> Any:
    """Returns a field for one of several values; valid: text of them in messages."""
    return ruled(default, Choice(tuple(values), valid))


def text(default: str, empty: bool = False) -> Any:
    """Returns a field for a text."""
    return ruled(default, Text(empty))


def check(settings: Any, error: type[Exception] = ValueError, prefix: str = "") -> None:
    """Checks every field that has a rule; for a dataclass's __post_init__.

    Args:
        prefix: Prefix of the names in messages.

    Raises:
        error: A value is not valid.
    """
    for item in fields(settings):
        if _RULE in item.metadata:
            name = prefix + _parameter(item)
            item.metadata[_RULE].check(name, getattr(settings, item.name), error)


class Checked:
    """Base of dataclasses whose fields are checked when one is made, see check().

    Args:
        error, prefix: of check(), behind the base in the definition of a class.
    """

    def __init_subclass__(
        cls, error: type[Exception] = ValueError, prefix: str = "", **options: Any
    ) -> None:
        super().__init_subclass__(**options)
        cls._error, cls._prefix = error, prefix

    _error: type[Exception]
    _prefix: str

    def __post_init__(self) -> None:
        check(self, self._error, self._prefix)


def _parameter(item: Field[Any]) -> str:
    """Returns the name of a field's parameter."""
    return item.metadata.get(_NAME) or item.name


def read(cls: type[T], get: Callable[[str, Any], Any], prefix: str = "~") -> T:
    """Returns settings from ROS parameters, one per field.

    Args:
        cls: Dataclass that checks its values and has defaults for all fields.
        get: rospy.get_param or a function like it: (name, default) -> value.
        prefix: Prefix of the parameters' names; "~": the node's private ones.
    """
    return cls(**{item.name: get(prefix + _parameter(item), item.default) for item in fields(cls)})


def parameter(get: Callable[[str, Any], Any], name: str, default: Any, rule: Rule) -> Any:
    """Returns one private ROS parameter.

    Args:
        get: rospy.get_param or a function like it: (name, default) -> value.
        name: Without the tilde.
        default: Value if it is not set; it is checked, too.

    Raises:
        ValueError: It is not valid.
    """
    return rule.check(name, get("~" + name, default))


def from_table(cls: type[T], data: Any, label: str, error: type[Exception] = ValueError) -> T:
    """Returns settings from a table of names and values, as read from YAML.

    Args:
        cls: Dataclass that checks its values.
        label: Name of the table in messages.

    Raises:
        error: It is not a table, or has a name that is not a field.
    """
    if not isinstance(data, dict):
        raise error(f"{label} is {data!r}; it must be a table of names and values")
    names = [item.name for item in fields(cls)]
    unknown = sorted(str(key) for key in set(data) - set(names))
    if unknown:
        raise error(f"{label}: unknown {', '.join(unknown)}; there are: {', '.join(names)}")
    return cls(**data)
