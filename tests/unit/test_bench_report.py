"""The table of the bench."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "bench"))

from figures import WITHIN  # noqa: E402
from pairs import alternate  # noqa: E402
from report import compared, ratio_row, table  # noqa: E402


def figures_of(*values):
    """Figures of three pairs, the reference always 100."""
    measured = alternate(lambda: 100.0, {"x": iter(values).__next__}, 3)
    return measured["x"].figures()


def result(date, *values, quick=False, **more):
    """What a run of the bench leaves."""
    return {
        "quick": quick,
        "date": date,
        "machine": {"processor": "x", "cores": 2},
        "load_average": [0.0, 0.0, 0.0],
        "errors": {},
        "solver": {"rows": {"steps, a car": figures_of(*values)}},
        **more,
    }


def test_a_ratio_is_told_with_its_spread():
    row = ratio_row("name", figures_of(70.0, 90.0, 80.0), "bare", "Hz")
    assert row.text == (
        "0.80 (0.70 to 0.90, quartiles 0.75 0.85) of bare, 3 pairs, 80.0 / 100.0 Hz"
    )
    assert row.value.median == 0.8


def test_a_ratio_around_one_is_no_difference():
    assert WITHIN in ratio_row("name", figures_of(90.0, 101.0, 105.0), "bare", "Hz").text


def test_two_ratios_are_compared_or_not():
    low, high = figures_of(70.0, 71.0, 72.0), figures_of(80.0, 81.0, 82.0)
    assert compared(low, high, "high") == "lower than high"
    assert compared(high, low, "low") == "higher than low"
    assert compared(low, figures_of(60.0, 71.5, 90.0), "wide") == "within the spread of wide"


def test_the_table_tells_what_failed_and_that_it_was_quick():
    text = table(result("a", 1.0, 1.0, 1.0, quick=True, errors={"scale": "no bridge"}))
    assert "scale FAILED" in text and "no bridge" in text
    assert "not to be quoted" in text
    assert "not to be quoted" not in table(result("a", 1.0, 1.0, 1.0))


def test_a_machine_that_was_not_idle_is_told():
    spent = {
        "spent": {"others": 1.2, "others_most": 2.0, "stolen": 0.05},
        "rows": [{"spent": {"others": 0.02, "stolen": 0.0}}],
    }
    busy = result("a", 1.0, 1.0, 1.0, other_section=spent)
    assert "others had up to 1.25 processors" in table(busy)
    spent["spent"]["others"] = 0.04
    assert "idle" not in table(busy)
