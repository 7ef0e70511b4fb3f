"""Settings as frozen dataclasses whose fields carry a default and a rule.

    @dataclass(frozen=True)
    class Limits:
        max_speed: float = number(3.0, above=0.0, unit="m/s")
        trailer: bool = flag(False)

        def __post_init__(self):
            check(self)

    limits = read(Limits, rospy.get_param)  # ~max_speed, ~trailer

What is wrong raises an error that names the setting, its value and what is valid.
"""

from dataclasses import field, fields

from paddock_common.rules import Choice, Flag, Number, Text

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
