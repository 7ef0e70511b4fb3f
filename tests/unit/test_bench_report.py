"""The table of the bench, and the table of several sessions."""

import json
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "bench"))

from figures import WITHIN  # noqa: E402
from pairs import alternate  # noqa: E402
from report import compared, merged, ratio_row, read_sessions, table  # noqa: E402

import bench  # noqa: E402


def figures_of(*values):
    """Figures of the meshes section, the reference always 100."""
    values = iter(values)
    count = 3
    measured = alternate(lambda: 100.0, {"many": lambda: next(values)}, count)
    return dict(measured["many"].figures(), triangles=[2048, 20000])


def result(date, *values, quick=False, cpu="x", **more):
    """What a run of the bench leaves."""
    return {
        "format": bench.FORMAT,
        "quick": quick,
        "date": date,
        "machine": {"cpu": cpu, "cpus": 2},
        "load_average": [0.0, 0.0, 0.0],
        "errors": {},
        "meshes": figures_of(*values),
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
    text = table(result("a", 1.0, 1.0, 1.0, quick=True, errors={"growth": "no bridge"}))
    assert "growth FAILED" in text and "no bridge" in text
    assert "not to be quoted" in text
    assert "not to be quoted" not in table(result("a", 1.0, 1.0, 1.0))


def test_a_machine_that_was_not_idle_is_told():
    spent = {
        "spent": {"others": 1.2, "others_most": 2.0, "stolen": 0.05},
        "rows": [{"spent": {"others": 0.02, "stolen": 0.0}}],
    }
    busy = result("a", 1.0, 1.0, 1.0, other_section=spent)
    assert "others had up to 1.25 processors" in table(busy)
    assert "Not an idle machine in a: others had up to 1.25" in merged([busy])
    spent["spent"]["others"] = 0.04
    assert "idle" not in table(busy) and "idle" not in merged([busy])


def test_sessions_become_one_table_of_ranges(tmp_path):
    paths = []
    for name, values in (("second", (60.0, 62.0, 63.0)), ("first", (78.0, 80.0, 84.0))):
        paths.append(tmp_path / f"{name}.json")
        date = "2026-01-02" if name == "second" else "2026-01-01"
        paths[-1].write_text(json.dumps(result(date, *values)))
    lines = merged(read_sessions(paths, bench.FORMAT)).splitlines()
    assert lines[0] == "| what | 2026-01-01 | 2026-01-02 | medians |"
    assert lines[1] == "| --- | --- | --- | --- |"
    assert lines[2] == (
        "| steps, 20000 far triangles | 0.80 (0.78 to 0.84) | 0.62 (0.60 to 0.63) | 0.62 to 0.80 |"
    )
    assert len(lines) == 3


def test_one_run_is_one_session(tmp_path):
    paths = [tmp_path / "one.json", tmp_path / "two.json"]
    for path in paths:
        path.write_text(json.dumps(result("a", 1.0, 1.0, 1.0)))
    with pytest.raises(ValueError, match="two.json holds the same run as .*one.json"):
        read_sessions(paths, bench.FORMAT)


def test_a_session_may_lack_a_section_and_doubts_are_told():
    lacking = result("b", 1.0, 1.0, 1.0, cpu="y", quick=True, errors={"growth": "no bridge"})
    del lacking["meshes"]
    text = merged([result("a", 50.0, 60.0, 70.0), lacking])
    assert "| 0.60 (0.50 to 0.70) |  | 0.60 |" in text
    for doubt in ("different machines", "Quick runs, not to be quoted: b", "Failed in b: growth"):
        assert doubt in text


@pytest.mark.parametrize(
    "content, reason",
    [
        (None, "cannot be read"),
        ("{", "cannot be read"),
        ("[]", "format None"),
        ('{"efficiency": {}}', "format None"),
        ('{"format": 1}', "format 1, it must be"),
    ],
)
def test_a_file_that_is_no_session_is_refused_by_name(tmp_path, content, reason):
    path = tmp_path / "old.json"
    if content is not None:
        path.write_text(content)
    with pytest.raises(ValueError, match=reason) as caught:
        read_sessions([path], bench.FORMAT)
    assert "old.json" in str(caught.value)
