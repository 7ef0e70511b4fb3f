"""Settings of a node or file: dataclasses whose fields have rules, read with clear errors.

Settings as frozen dataclasses whose fields carry a default and a rule.

    @dataclass(frozen=True)
    class Limits:
        max_speed: float = number(3.0, above=0.0, unit="m/s")
        trailer: bool = flag(False)

        def __post_init__(self):
            check(self)

    limits = read(Limits, rospy.get_param)  # ~max_speed, ~trailer

What is wrong raises an error that names the setting, its value and what is valid.
"""

import math
import numbers
from dataclasses import dataclass, field, fields


class Rule:
    """What a value must be; subclasses give `complaint`."""

    def complaint(self, value):
        """Gives what the value must be instead, or "" if it is valid."""
        raise NotImplementedError

    def check(self, name, value, error=ValueError):
        """Gives the value back.

        Raises:
            error: It is not valid; the message names it, its value and what is valid.
        """
        valid = self.complaint(value)
        if valid:
            raise error(f"{name} is {value!r}; it must be {valid}")
        return value


@dataclass(frozen=True)
class Number(Rule):
    """A finite number within a range; True and False are none.

    Attributes:
        above, below: Ends of the range that are left out; None: there is no end.
        least, most: Ends that belong to the range.
        whole: Whether only whole numbers are valid.
        unit: For the message, e.g. "m/s".
    """

    above: float = None
    below: float = None
    least: float = None
    most: float = None
    whole: bool = False
    unit: str = ""

    def complaint(self, value):
        """As Rule.complaint."""
        valid = self._range()
        if not is_number(value) or (self.whole and not isinstance(value, numbers.Integral)):
            kind = "a whole number" if self.whole else "a number"
            return kind + (", " if valid[:1].isdigit() else " " if valid else "") + valid
        inside = (
            (self.above is None or value > self.above)
            and (self.below is None or value < self.below)
            and (self.least is None or value >= self.least)
            and (self.most is None or value <= self.most)
        )
        return "" if inside else valid

    def _range(self):
        """The range in words, e.g. "above 0 and below 0.7 [m/s]"."""
        if self.least is not None and self.most is not None:
            words = f"from {self.least:g} to {self.most:g}"
        else:
            ends = [
                self.above is not None and f"above {self.above:g}",
                self.least is not None and f"{self.least:g} or more",
                self.below is not None and f"below {self.below:.4g}",
                self.most is not None and f"at most {self.most:g}",
            ]
            words = " and ".join(filter(None, ends))
        return " ".join(filter(None, (words, self.unit and f"[{self.unit}]")))


@dataclass(frozen=True)
class Flag(Rule):
    """True or false."""

    def complaint(self, value):
        """As Rule.complaint."""
        return "" if isinstance(value, bool) else "true or false"


@dataclass(frozen=True)
class Choice(Rule):
    """One of several values.

    Attributes:
        values: The valid ones.
        words: What the message says is valid; "": the values.
    """

    values: tuple
    words: str = ""

    def complaint(self, value):
        """As Rule.complaint."""
        for valid in self.values:
            if value == valid and isinstance(value, bool) == isinstance(valid, bool):
                return ""
        return self.words or "one of " + ", ".join(map(str, self.values))


@dataclass(frozen=True)
class Text(Rule):
    """A text.

    Attributes:
        empty: Whether it may be empty.
    """

    empty: bool = False

    def complaint(self, value):
        """As Rule.complaint."""
        if isinstance(value, str) and (value or self.empty):
            return ""
        return "a text" if self.empty else "a name"


def is_number(value):
    """Says whether a value is a finite real number, of Python or numpy; booleans are none."""
    if not isinstance(value, numbers.Real) or isinstance(value, bool):
        return False
    try:
        return math.isfinite(value)
    except OverflowError:  # an integer of more than 300 digits
        return False


def converted(name, value):
    """Gives the float of a finite number or of a text that is one, as upstream's nodes take it.

    Raises:
        ValueError: It is none; the message names it and its value.
    """
    try:
        number = value if isinstance(value, bool) else float(value)
    except (TypeError, ValueError, OverflowError):
        number = value
    if not is_number(number):
        raise ValueError(f"{name} is {value!r}; it must be a number")
    return number


_RULE, _NAME = "rule", "name"


def ruled(default, rule, name=""):
    """Gives a dataclass field with a default and a Rule.

    Args:
        default: Value when none is given.
        rule: Rule.
        name: Of the parameter; "": the field's.
    """
    return field(default=default, metadata={_RULE: rule, _NAME: name})


def number(default, name="", **limits):
    """Gives a field for a finite number.

    Args:
        default: Value when none is given.
        name: Of the parameter; "": the field's.
        limits: Those of rules.Number.
    """
    return ruled(default, Number(**limits), name)


def flag(default):
    """Gives a field for true or false."""
    return ruled(default, Flag())


def choice(default, values, words=""):
    """Gives a field for one of several values; words: what the message says is valid."""
    return ruled(default, Choice(tuple(values), words))


def text(default, empty=False):
    """Gives a field for a text."""
    return ruled(default, Text(empty))


def check(settings, error=ValueError, prefix=""):
    """Checks every field that has a rule; for a dataclass's __post_init__.

    Args:
        settings: Dataclass instance.
        error: Class of the error.
        prefix: Stands before the names in messages.

    Raises:
        error: A value is not valid.
    """
    for item in fields(settings):
        if _RULE in item.metadata:
            name = prefix + _parameter(item)
            item.metadata[_RULE].check(name, getattr(settings, item.name), error)


def _parameter(item):
    """The name that a field's parameter has."""
    return item.metadata.get(_NAME) or item.name


def read(kind, get, prefix="~"):
    """Makes settings of ROS parameters, one a field.

    Args:
        kind: Dataclass that checks its values and has defaults for all.
        get: rospy.get_param or a function like it: (name, default) -> value.
        prefix: Stands before the parameters' names; "~": the node's private ones.
    """
    return kind(
        **{item.name: get(prefix + _parameter(item), item.default) for item in fields(kind)}
    )


def parameter(get, name, default, rule):
    """Gives one private ROS parameter.

    Args:
        get: rospy.get_param or a function like it: (name, default) -> value.
        name: Without the tilde.
        default: Its value when it is not set; it is checked, too.
        rule: Rule.

    Raises:
        ValueError: It is not valid.
    """
    return rule.check(name, get("~" + name, default))


def from_table(kind, data, what, error=ValueError):
    """Makes settings of a table of names and values, as YAML gives it.

    Args:
        kind: Dataclass that checks its values.
        data: Dict.
        what: Name of the table for messages.
        error: Class of the error.

    Raises:
        error: It is no table, or has a name that the class does not have.
    """
    if not isinstance(data, dict):
        raise error(f"{what} is {data!r}; it must be a table of names and values")
    names = [item.name for item in fields(kind)]
    unknown = sorted(str(key) for key in set(data) - set(names))
    if unknown:
        raise error(f"{what}: unknown {', '.join(unknown)}; there are: {', '.join(names)}")
    return kind(**data)
