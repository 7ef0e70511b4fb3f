"""Ratios from alternation: a reference and its variants in short rounds within one run.

A machine that is slower for a minute, or gives a core to somebody else, then slows down both sides
of a pair, and what it does within a pair shows as spread:

    measured = alternate(bare, {"bridge": bridge}, pairs_of(quick))
    measured["bridge"].ratio.text()     # 0.80 (0.77 to 0.83, quartiles 0.79 0.81)
"""

import time
from dataclasses import dataclass, field

from figures import BenchError, Spread, call
from usage import between, summarise

PAIRS = 9  # least number of pairs of a figure that may be quoted
QUICK_PAIRS = 5  # of --quick, which says so


def pairs_of(quick):
    """How many pairs to take."""
    return QUICK_PAIRS if quick else PAIRS


def matched(one, other):
    """Pairs of the items of two lists of equal length."""
    if len(one) != len(other):
        raise BenchError(f"{len(one)} items do not match {len(other)}")
    return list(zip(one, other))


@dataclass(frozen=True)
class Round:
    """What a round measured, with details that are kept beside it.

    Attributes:
        value: of the measured quantity, above 0; more is better (a rate).
        details: dict of anything else.
    """

    value: float
    details: dict = field(default_factory=dict)


@dataclass(frozen=True)
class Pairs:
    """Rounds of the reference and of one variant, each right after the other.

    Attributes:
        reference, variant: lists of Round, of equal length.
    """

    reference: list
    variant: list

    @property
    def ratios(self):
        """Variant over reference, pair by pair."""
        return [mine.value / its.value for its, mine in matched(self.reference, self.variant)]

    @property
    def ratio(self):
        """Spread of the ratios."""
        return Spread.of(self.ratios)

    def figures(self):
        """The dict for JSON: Spreads of ratio, reference and variant, and the verdict on 1.

        Where each round tells what was spent (its details have "spent", see usage.between), also
        spent and reference_spent, summed up.
        """
        figures = {
            "pairs": len(self.reference),
            "ratio": self.ratio.figures(),
            "against_reference": call(self.ratio, 1.0),
            "reference": Spread.of(one_round.value for one_round in self.reference).figures(),
            "variant": Spread.of(one_round.value for one_round in self.variant).figures(),
            "ratios": [round(ratio, 4) for ratio in self.ratios],
        }
        for name, rounds in (("spent", self.variant), ("reference_spent", self.reference)):
            if all("spent" in one_round.details for one_round in rounds):
                figures[name] = summarise([one_round.details["spent"] for one_round in rounds])
        return figures


def alternate(reference, variants, pairs, monitor=None):
    """Measure a reference and its variants by turns: A B A B ..., with two variants A B A C ...

    Args:
        reference: function without arguments that measures for a short while; returns a Round, or
            just its value.
        variants: dict of name -> such a function. Each runs right after a round of the reference of
            its own.
        monitor: usage.Monitor; then each round's details tell what was spent during it.

    Returns:
        dict of name -> Pairs.

    Raises:
        ValueError: pairs is below 1.
        BenchError: a round measured a value that is not above 0.
    """
    if pairs < 1:
        raise ValueError(f"pairs is {pairs}, must be at least 1")
    measured = {name: Pairs([], []) for name in variants}
    for _ in range(pairs):
        for name, variant in variants.items():
            measured[name].reference.append(_turn(reference, "the reference", monitor))
            measured[name].variant.append(_turn(variant, f"'{name}'", monitor))
    return measured


def _turn(measure, name, monitor):
    before = monitor.read() if monitor else None
    one_round = measure()
    spent = {"spent": between(before, monitor.read())} if monitor else {}
    if not isinstance(one_round, Round):
        one_round = Round(float(one_round))
    one_round = Round(one_round.value, {**one_round.details, **spent})
    if not one_round.value > 0:
        raise BenchError(f"a round of {name} measured {one_round.value}, must be above 0")
    return one_round


def rate_of_work(work, seconds, now=time.monotonic):
    """Amount of work per second, as a round measures it.

    Args:
        work: function that does a small piece and returns how much that was.
        seconds: least time to go on for, above 0.
        now: clock [s].
    """
    begin, done, passed = now(), 0.0, 0.0
    while passed < seconds:
        done += work()
        passed = now() - begin
    return done / passed
