"""The bench's figures: medians and ranges, workloads of a known ratio in alternation, the table."""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "bench"))

from figures import WITHIN, Spread, call  # noqa: E402


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
