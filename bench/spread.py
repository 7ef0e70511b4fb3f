"""A measured quantity with its spread, and when two of them differ.

The rule, everywhere in the bench: a difference is called only if neither median lies within the
other's range (least to greatest value). Where there is no difference and the values scatter
normally, the rule calls one all the same in 3 of 1000 cases with nine values each, in 48 of 1000
with five; against a number that is known exactly in 4 and in 62.
"""

import statistics
from dataclasses import asdict, dataclass

WITHIN = "within the spread"


@dataclass(frozen=True)
class Spread:
    """What several values of one quantity are like.

    Attributes:
        count: how many values.
        median: the middle one (of an even number: the mean of the middle two).
        quartiles: the values below which a quarter and three quarters lie, interpolated.
        least, greatest: the range.
    """

    count: int
    median: float
    quartiles: tuple
    least: float
    greatest: float

    @classmethod
    def of(cls, values):
        """Describe values.

        Raises:
            ValueError: there are none.
        """
        values = sorted(float(value) for value in values)
        if not values:
            raise ValueError("a spread needs at least one value")
        low, _, high = (
            statistics.quantiles(values, n=4, method="inclusive") if len(values) > 1 else values * 3
        )
        return cls(len(values), statistics.median(values), (low, high), values[0], values[-1])

    @classmethod
    def read(cls, figures):
        """The Spread that figures() gave.

        Raises:
            ValueError: something is missing.
        """
        try:
            return cls(
                figures["count"],
                figures["median"],
                tuple(figures["quartiles"]),
                figures["least"],
                figures["greatest"],
            )
        except (KeyError, TypeError) as error:
            raise ValueError(f"{figures!r} is no spread: {error!r}") from error

    def figures(self):
        """As a dict for JSON."""
        return asdict(self)

    def text(self, form=".2f"):
        """Median, range and quartiles: "0.80 (0.77 to 0.83, quartiles 0.79 0.81)"."""
        if self.count == 1:
            return f"{self.median:{form}}"
        low, high = self.quartiles
        return (
            f"{self.median:{form}} ({self.least:{form}} to {self.greatest:{form}}, quartiles "
            f"{low:{form}} {high:{form}})"
        )


def holds(spread, value):
    """Whether a value lies within a spread's range."""
    return spread.least <= value <= spread.greatest


def call(spread, other):
    """Say whether a quantity differs from another one.

    Args:
        spread: Spread.
        other: Spread, or a number that is known exactly (1 for a ratio).

    Returns:
        "higher", "lower" or WITHIN.
    """
    if not isinstance(other, Spread):
        other = Spread.of([other])
    if holds(spread, other.median) or holds(other, spread.median):
        return WITHIN
    return "higher" if spread.median > other.median else "lower"
