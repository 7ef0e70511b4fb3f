"""Every section of the bench has its shape; efficiency refuses rounds that prove nothing."""

import importlib
import inspect
import json
import sys
from pathlib import Path

import pytest

BENCH = Path(__file__).resolve().parents[2] / "bench"
sys.path.insert(0, str(BENCH))

from figures import BenchError  # noqa: E402
from report import table  # noqa: E402
from sections import SECTIONS, efficiency, section  # noqa: E402

import bench  # noqa: E402


@pytest.mark.parametrize("name", SECTIONS)
def test_a_section_measures_and_tells(name):
    module = section(name)
    assert list(inspect.signature(module.measure).parameters)[0] == "quick"
    assert len(inspect.signature(module.measure).parameters) == 2
    assert list(inspect.signature(module.rows).parameters) == ["figures"]
    assert module.__doc__


@pytest.mark.parametrize("path", sorted((BENCH / "observers").glob("*.py")), ids=lambda p: p.stem)
def test_an_observer_can_be_imported(path):
    importlib.import_module(f"observers.{path.stem}")


def spent(cpu, observer=1.0):
    """What usage.between gives for a round."""
    return {
        "seconds": 2.0,
        "cpu": {"bridge": cpu, "observer": observer},
        "others": 0.0,
        "stolen": 0.0,
        "threads": {
            name: {"cpu": value, "waited": 0.0, "switched_off": 0.0, "gave_up": 0.0}
            for name, value in (("simulation", cpu), ("reference", observer))
        },
    }


def bare(pace=40.0, speed=0.6, cpu=0.01):
    """A round of the reference; cpu: what the paused bridge took."""
    return {"pace": pace, "speeds": [speed], "spent": spent(cpu)}


def free(pace=20.0, speed=0.6, received=100, cpu=0.8):
    """A round of the bridge."""
    return {"pace": pace, "sim": 40.0, "speeds": [speed], "received": {"/clock": received},
            "spent": spent(cpu, 0.1)}  # fmt: skip


def test_cars_that_do_not_drive_alike_are_no_figure():
    assert efficiency._same_speeds([bare()], [free(speed=0.55)]) == [0.55]
    for its, mine in ((0.6, 0.3), (0.6, 0.9), (0.0, 0.0)):
        with pytest.raises(BenchError, match="not the same work"):
            efficiency._same_speeds([bare(speed=its)], [free(speed=mine)])


def test_a_section_that_fails_leaves_the_others(monkeypatch, tmp_path):
    class Failing:
        @staticmethod
        def measure(quick, log):
            raise BenchError("nothing came")

    class Half:
        @staticmethod
        def measure(quick, log):
            return {"quick_was": quick, "errors": {"part": "broke"}}

    modules = {"start": Failing, "camera": Half}
    monkeypatch.setattr(bench, "section", modules.__getitem__)
    with (tmp_path / "log").open("w") as log:
        result = bench.run(["start", "camera"], True, log)
    assert result["errors"] == {"start": "nothing came", "camera part": "broke"}
    assert result["camera"] == {"quick_was": True} and "start" not in result
    assert json.dumps(result)
    assert "start FAILED" in table({**result, "camera": {}})


def test_a_lap_in_the_gym_and_over_ros_is_a_row_each(tmp_path):
    found = {"state": {"gym": 10.0, "ros": [10.0, 10.1, 10.2]}, "errors": {}}
    rows = {row.label: row for row in section("gym_gap").rows(found)}
    assert rows["state, lap in the gym"].value == 10.0
    assert rows["state, lap over ROS"].value.median == 10.1
    assert rows["state, over ROS longer by"].value.greatest == pytest.approx(2.0)
    assert rows["state, over ROS longer by"].unit == "%"
    path = tmp_path / "result.json"
    path.write_text(json.dumps({"starts": [{"outcome": "lap", "lap_time": 9.5}]}))
    assert section("gym_gap").lap_time(path) == 9.5
    path.write_text(json.dumps({"starts": [{"outcome": "off track", "lap_time": 0.0}]}))
    with pytest.raises(BenchError, match="no lap came of it: off track"):
        section("gym_gap").lap_time(path)
    with pytest.raises(BenchError, match="there was no result"):
        section("gym_gap").lap_time(tmp_path / "none.json")
