"""Values of parameters; YAML writes them in many ways."""

import math

TRUE, FALSE = ("true", "yes", "on", "1"), ("false", "no", "off", "0")


def number(name, value):
    """A finite number.

    Raises:
        ValueError: It is none; names the parameter and its value.
    """
    try:
        if isinstance(value, bool):
            raise TypeError
        result = float(value)
    except (TypeError, ValueError):
        raise ValueError(f"{name} is {value!r}, must be a number") from None
    if not math.isfinite(result):
        raise ValueError(f"{name} is {value!r}, must be finite")
    return result


def truth(name, value):
    """Whether something holds: true, 1, "true" and so on.

    Raises:
        ValueError: It is neither true nor false; names the parameter and its value.
    """
    if isinstance(value, (bool, int, float)):
        return bool(value)
    if isinstance(value, str) and value.strip().lower() in TRUE + FALSE:
        return value.strip().lower() in TRUE
    raise ValueError(f"{name} is {value!r}, must be true or false")


def frame(name, value):
    """Name of a frame, without the leading slash of tf 1.

    Raises:
        ValueError: It is no name.
    """
    if not isinstance(value, str) or not value.strip("/ "):
        raise ValueError(f"{name} is {value!r}, must be the name of a frame")
    return value.strip().lstrip("/")
