"""The bench's figures: medians and ranges, workloads of a known ratio in alternation, the table."""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "bench"))

from figures import WITHIN, BenchError, Spread, call  # noqa: E402
from pairs import Round, alternate, rate_of_work  # noqa: E402


@pytest.mark.parametrize(
    "values, median, quartiles",
    [
        ([3.0], 3.0, (3.0, 3.0)),
        ([1.0, 2.0], 1.5, (1.25, 1.75)),
        ([5.0, 1.0, 4.0, 2.0, 3.0], 3.0, (2.0, 4.0)),
        (range(9), 4.0, (2.0, 6.0)),
    ],
)
def test_spread_of_known_values(values, median, quartiles):
    spread = Spread.of(values)
    assert (spread.median, spread.quartiles) == (median, quartiles)
    assert (spread.least, spread.greatest) == (min(values), max(values))
    assert spread.count == len(values)


@pytest.mark.parametrize(
    "values, other, verdict",
    [
        ([0.7, 0.8, 0.9], 1.0, "lower"),
        ([1.1, 1.2, 1.3], 1.0, "higher"),
        ([0.9, 1.2, 1.3], 1.0, WITHIN),
        ([0.8, 0.9, 1.0], 1.0, WITHIN),  # the bound belongs to the range
        ([0.5, 0.6, 0.7], [0.65, 0.8, 0.9], "lower"),  # ranges overlap, medians lie outside
        ([0.65, 0.8, 0.9], [0.5, 0.6, 0.7], "higher"),
        ([0.5, 0.6, 0.85], [0.65, 0.8, 0.9], WITHIN),  # one median in the other's range
        ([0.65, 0.8, 0.9], [0.5, 0.6, 0.85], WITHIN),
        ([0.1, 0.6, 5.0], [0.55, 0.58, 0.61], WITHIN),
    ],
)
def test_a_difference_within_the_spread_is_not_called(values, other, verdict):
    other = Spread.of(other) if isinstance(other, list) else other
    assert call(Spread.of(values), other) == verdict


class Machine:
    """A processor on which time passes only by work, and whose speed may change.

    Attributes:
        now: [s].
        slowness: by what factor work takes longer.
    """

    def __init__(self):
        self.now, self.slowness = 0.0, 1.0

    def workload(self, cost):
        """Give a round: pieces of work of so many seconds each, for 10 s."""

        def piece():
            self.now += cost * self.slowness
            return 1

        return lambda: rate_of_work(piece, 10.0, now=lambda: self.now)


def test_the_ratio_is_that_of_the_costs():
    machine = Machine()
    measured = alternate(machine.workload(0.25), {"twice": machine.workload(0.5)}, 9)["twice"]
    assert measured.ratios == [0.5] * 9
    figures = measured.figures()
    assert (figures["ratio"]["median"], figures["pairs"]) == (0.5, 9)
    assert (figures["reference"]["median"], figures["variant"]["median"]) == (4.0, 2.0)
    assert figures["against_reference"] == "lower"


def test_each_variant_follows_a_reference_of_its_own():
    order = []

    def one_round(name, value):
        def measure():
            order.append(name)
            return Round(value, {"name": name, "number": len(order)})

        return measure

    measured = alternate(
        one_round("A", 1.0), {"b": one_round("B", 2.0), "c": one_round("C", 3.0)}, 2
    )
    assert "".join(order) == "ABACABAC"
    assert measured["b"].ratios == [2.0, 2.0] and measured["c"].ratios == [3.0, 3.0]
    assert [item.details["number"] for item in measured["c"].reference] == [3, 7]
    assert [item.details["number"] for item in measured["c"].variant] == [4, 8]


@pytest.mark.parametrize("value", [0.0, -1.0, float("nan")])
def test_a_turn_without_a_rate_is_no_figure(value):
    with pytest.raises(BenchError, match="'stalled' measured"):
        alternate(lambda: 1.0, {"stalled": lambda: value}, 3)
    with pytest.raises(BenchError, match="the reference measured"):
        alternate(lambda: value, {"good": lambda: 1.0}, 3)
