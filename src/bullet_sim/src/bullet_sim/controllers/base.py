"""What all controllers share: checks of their commands and of their configuration."""

import math

from bullet_sim.errors import CommandError, ControllerError

MAX_COMMAND = 1e9  # larger commands [rad/s, m/s, rad, m, N m, N] are refused


def check_command(name, values, counts):
    """Check a command.

    Args:
        name: controller name.
        values: sequence of numbers [rad/s, m/s, rad, m, N m, N].
        counts: how many there may be, a tuple.

    Returns:
        The values as a tuple of floats.

    Raises:
        CommandError: wrong count, NaN or beyond MAX_COMMAND.
    """
    values = tuple(float(value) for value in values)
    if len(values) not in counts:
        wanted = " or ".join(map(str, counts))
        raise CommandError(f"command of '{name}' has {len(values)} values, must have {wanted}")
    for value in values:
        if not abs(value) <= MAX_COMMAND:
            raise CommandError(
                f"command of '{name}' is {value}, must be a finite number, at most "
                f"{MAX_COMMAND:g} either way; the last good command stays"
            )
    return values


def as_number(value):
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
        values: the mapping.
        what: name for messages, e.g. "controller 'drive'".

    Raises:
        ControllerError: it is no mapping.
    """

    def __init__(self, values, what):
        if not isinstance(values, dict):
            raise ControllerError(f"{what} is {values!r}, must be a mapping")
        self.what = what
        self._values, self._asked, self._blocks = values, set(), []

    def get(self, key, default=None):
        """A value as it is."""
        self._asked.add(key)
        return self._values.get(key, default)

    def __contains__(self, key):
        return key in self._values

    def number(self, key, default, above=None):
        """A finite number; a missing one gives `default` unchecked.

        Args:
            above: what it must be greater than.
        """
        self._asked.add(key)
        if key not in self._values:
            return default
        value = as_number(self._values[key])
        if value is None or (above is not None and value <= above):
            wanted = "a finite number" if above is None else f"a number above {above:g}"
            raise ControllerError(f"{self.what} has {key} {self._values[key]!r}, must be {wanted}")
        return value

    def flag(self, key, default):
        """True or false."""
        value = self.get(key, default)
        if not isinstance(value, bool):
            raise ControllerError(f"{self.what} has {key} {value!r}, must be true or false")
        return value

    def text(self, key, default):
        """A string that is not empty."""
        value = self.get(key, default)
        if not isinstance(value, str) or not value:
            raise ControllerError(f"{self.what} has {key} {value!r}, must be a name")
        return value

    def block(self, *keys):
        """Settings of a mapping within this one; a missing one is empty."""
        inner = self
        for key in keys:
            found = Settings(inner.get(key, {}), f"{inner.what} {key}")
            inner._blocks.append(found)
            inner = found
        return inner

    def ignore(self, *keys):
        """Mark keys as known; returns those that are present."""
        self._asked.update(keys)
        return [key for key in keys if key in self._values]

    def unknown(self):
        """A sentence for each key that was not read, also in nested blocks."""
        own = [
            f"{self.what} has key '{key}', which means nothing here and is ignored"
            for key in sorted(set(self._values) - self._asked, key=str)
        ]
        return own + [text for block in self._blocks for text in block.unknown()]
