"""The bench's section actions: rates of one environment and of several, its table."""

import io
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "bench"))

from sections import actions  # noqa: E402

KINDS = {"Robot-v0": {"state": {"observation": "odom"}}}


def test_rates_of_one_world_and_of_two(monkeypatch):
    monkeypatch.setattr(actions, "KINDS", KINDS)
    monkeypatch.setattr(actions, "WORLDS", (1, 2))
    monkeypatch.setattr(actions, "QUICK_SECONDS", 0.05)
    log = io.StringIO()
    figures = actions.measure(True, log)
    rows = {row.label: row for row in actions.rows(figures)}
    names = [f"Robot-v0, state, {worlds}" for worlds in ("1 world", "2 worlds")]
    assert list(rows) == [each + end for each in names for end in ("", ", of a core")] + [
        "versions"
    ]
    for name in names:
        assert name in log.getvalue()
        for row in (rows[name], rows[f"{name}, of a core"]):
            assert row.unit == "actions/s" and row.value.count == actions.QUICK_ROUNDS
            assert row.value.least > 10.0
    assert "numpy" in rows["versions"].text


def test_of_a_core_counts_all_threads():
    class Busy(actions.Subject):
        """Takes twice as much processor time as wall time."""

        worlds = 1

        def __init__(self, clock):
            self._clock = clock

        def act(self, count):
            self._clock.wall += 0.1 * count
            self._clock.processor += 0.2 * count

    class Clock:
        wall = processor = 0.0
        perf_counter = staticmethod(lambda: Clock.wall)
        process_time = staticmethod(lambda: Clock.processor)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(actions, "time", Clock)
        assert Busy(Clock).one_round(2.0) == pytest.approx((10.0, 5.0))
