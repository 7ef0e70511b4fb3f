"""The bench's figures: medians and ranges, workloads of a known ratio in alternation, the table."""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "bench"))

from figures import WITHIN, Spread, call  # noqa: E402
from sections import efficiency  # noqa: E402


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


def test_what_limits_a_variant_is_told():
    rounds = [
        {"shares": {"steps": steps, "messages": 0.3, "sockets": 0.05}} for steps in (0.5, 0.6, 0.7)
    ]
    shares = efficiency._shares(rounds)
    assert shares == {"steps": 0.6, "messages": 0.3, "sockets": 0.05}
    ratio = Spread.of([0.4, 0.48, 0.5]).figures()
    text = efficiency._bound({"shares": shares, "ratio": ratio})
    assert text == "steps 60 %, messages 30 %, sockets 5 %; with nothing but steps it would be 0.80"
