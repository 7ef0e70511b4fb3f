"""The soak's own parts: the order of faults, growth, the log, the page, limits of a shutdown."""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "bench"))

from soaking import report  # noqa: E402
from soaking.monitor import WARM_UP, Sample, growth  # noqa: E402


def samples(memory, threads=10, period=2.0, count=200):
    """Samples of a bridge whose memory [B] and threads are values or functions of time [s]."""

    def at(value, time):
        return value(time) if callable(value) else value

    return [
        Sample(
            wall=t,
            simulated=0.5 * t,
            counts={topic: int(10 * t) for topic in report.PLOTTED},
            processes={"bridge": (7, at(memory, t), at(threads, t), 70)},
            shared=0,
            calm=True,
        )
        for t in (period * number for number in range(count))
    ]


@pytest.mark.parametrize(
    "memory, threads, words",
    [
        (100e6, 10, []),
        (lambda t: 100e6 + (80e6 if t < WARM_UP else 0.0), 10, []),  # while it comes up
        (lambda t: 100e6 + (500e6 if t % 60 < 10 else 0.0), 10, []),  # peaks
        (lambda t: 100e6 + 0.5e6 * t, 10, ["memory of bridge"]),
        (100e6, lambda t: 10 + t // 10, ["threads of bridge"]),
    ],
)
def test_growth(memory, threads, words):
    found = growth(samples(memory, threads))
    assert len(found) == len(words)
    assert all(word in text for word, text in zip(words, found))
