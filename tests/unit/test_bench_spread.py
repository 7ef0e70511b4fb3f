"""Medians, quartiles and ranges of the bench, and when it calls a difference."""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "bench"))

from figures import WITHIN, Spread, call  # noqa: E402


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


def test_no_values_have_no_spread():
    with pytest.raises(ValueError, match="at least one value"):
        Spread.of([])


def test_figures_can_be_read_again():
    spread = Spread.of([0.5, 0.7, 0.6])
    assert Spread.read(spread.figures()) == spread
    with pytest.raises(ValueError, match="greatest"):
        Spread.read({key: value for key, value in spread.figures().items() if key != "greatest"})


def test_text_gives_median_range_and_quartiles():
    assert Spread.of(range(9)).text(".0f") == "4 (0 to 8, quartiles 2 6)"
    assert Spread.of([2.0]).text() == "2.00"


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
