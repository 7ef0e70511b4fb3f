"""From samples to figures: percentiles, gaps, spreads, and when two of them differ.

The rule, everywhere in the bench: a difference is called only if neither median lies within the
other's range (minimum to maximum). Where there is no difference and the values scatter normally,
the rule calls one all the same in 3 of 1000 cases with nine values each, in 48 of 1000 with five;
against a number that is known exactly in 4 and in 62.
"""

import math
import statistics
from dataclasses import asdict, dataclass

WITHIN = "within the spread"


class BenchError(ValueError):
    """A run that gave no figures."""


def percentile(values, part):
    """The value below which a part of them lies (nearest rank)."""
    ordered = sorted(values)
    if not ordered:
        raise BenchError("no samples")
    return ordered[min(len(ordered) - 1, max(0, math.ceil(part * len(ordered)) - 1))]


def median(values):
    """The middle value."""
    return percentile(values, 0.5)


def rate_of(pairs):
    """Simulated seconds per wall second of [(receipt, stamp)]."""
    return (pairs[-1][1] - pairs[0][1]) / (pairs[-1][0] - pairs[0][0])


def gap_figures(images, seconds):
    """Rate and gaps [ms] of received images [(receipt, stamp)]."""
    if len(images) < 3:
        raise BenchError(f"{len(images)} images in {seconds:g} s")
    gaps = [(b[0] - a[0]) * 1e3 for a, b in zip(images, images[1:])]
    return {
        "window_s": seconds,
        "received": len(images),
        "rate_hz": (len(images) - 1) / (images[-1][0] - images[0][0]),
        "gap_ms_p50": percentile(gaps, 0.5),
        "gap_ms_p99": percentile(gaps, 0.99),
        "gap_ms_max": max(gaps),
    }


def lateness_figures(ticks):
    """How late /clock arrives against the earliest offset between wall and stamp."""
    if len(ticks) < 3:
        raise BenchError(f"{len(ticks)} messages on /clock")
    offsets = [receipt - stamp for receipt, stamp in ticks]
    late = [(offset - min(offsets)) * 1e3 for offset in offsets]
    return {
        "kind": "proxy: /clock as received by a subscriber in another process, "
        "transport and scheduling of both sides included",
        "samples": len(late),
        "late_ms_p50": percentile(late, 0.5),
        "late_ms_p99": percentile(late, 0.99),
        "late_ms_p999": percentile(late, 0.999),
        "late_ms_max": max(late),
    }


@dataclass(frozen=True)
class Spread:
    """What several values of one quantity are like.

    Attributes:
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
        other: Spread, or a number that is known exactly (1 for a ratio).

    Returns:
        "higher", "lower" or WITHIN.
    """
    if not isinstance(other, Spread):
        other = Spread.of([other])
    if holds(spread, other.median) or holds(other, spread.median):
        return WITHIN
    return "higher" if spread.median > other.median else "lower"
