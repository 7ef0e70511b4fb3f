"""The bench's figures: medians and ranges, workloads of a known ratio in alternation, the table."""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "bench"))

from figures import WITHIN, Spread, call  # noqa: E402
from pairs import alternate, rate_of_work  # noqa: E402


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
