"""Rules for single values: what is valid, and the sentence that says so."""

import math
import numbers
from dataclasses import dataclass


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
