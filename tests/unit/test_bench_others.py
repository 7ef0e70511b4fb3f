"""bench/others.py: what it tells of subjects it measured, and of those that are not installed."""

import stat
import sys
from pathlib import Path
from xml.etree import ElementTree

import pytest
from paddock_gym.simulation.car import recipe
from track_model.track import load_track

BENCH = Path(__file__).resolve().parents[2] / "bench"
sys.path[:0] = [str(BENCH), str(BENCH.parent / "docs" / "tools")]

import others  # noqa: E402
import results_page  # noqa: E402
from observers.others import mujoco_car  # noqa: E402
from sections import section  # noqa: E402

WORKER = """#!{python}
import json, sys
name = sys.argv[-1]
print(json.dumps({{"period": 0.01 if "f1" in name else 0.05, "time_step": 0.005,
                   "cars": 16 if name.endswith("16") else 1}}), flush=True)
for line in sys.stdin:
    rate = 500.0 if "f1" in name else 200.0
    print(json.dumps({{"rate": rate, "own": 2.0 * rate}}), flush=True)
"""


def program(path, text):
    path.write_text(text)
    path.chmod(path.stat().st_mode | stat.S_IXUSR)
    return str(path)


@pytest.fixture
def python(tmp_path):
    """What answers in a Python's place."""
    return program(tmp_path / "python", WORKER.format(python=sys.executable))


def test_what_is_measured_is_told(python):
    found = others.measure({"paddock": python, "f1tenth": python}, quick=True)
    ours = {name for name, (kind, _) in others.SUBJECTS.items() if kind in ("paddock", "f1tenth")}
    assert set(found) == ours - {others.REFERENCE}
    assert found["f1tenth_16"]["variant"]["median"] == 500.0
    assert found["f1tenth_16"]["real_time"] == pytest.approx(5.0)
    table = {line.split()[0]: line for line in list(others.lines(found))[1:-2]}
    assert set(table) == ours
    assert table["paddock_state_1"].split()[1] == "200"
    assert "0.0500    0.0050       10.0     20.0" in table["paddock_state_1"]  # 200 of 0.05 s
    assert "0.0100    0.0050       80.0    160.0" in table["f1tenth_16"]  # 500 of 0.01 s, 16 cars
    assert "1080 rays" in table["f1tenth_1"]
    figures = {"subjects": found, "errors": {}}
    rows = {row.label: row for row in section("peers").rows(figures)}
    assert set(rows) > ours
    assert rows["f1tenth_16"].value.median == pytest.approx(160.0)
    assert rows["f1tenth_16, all cores"].value == pytest.approx(80.0)
    assert rows["paddock_lidar_1 over f1tenth_1"].value.median == pytest.approx(2.0)
    assert "16 cars" in results_page.row({"name": "mujoco_16", "value": 1.0, "unit": "",
                                          "spread": None, "runs": 1}, "x")  # fmt: skip


def test_the_car_for_mujoco_has_the_joints_and_masses_of_ours():
    car = ElementTree.fromstring(mujoco_car(0.001))
    urdf = ElementTree.fromstring(recipe(load_track("default"), 0.001).spawns[0].text)
    driven = [
        joint for joint in urdf.iter("joint") if joint.get("type") in ("continuous", "revolute")
    ]
    assert len(car.findall(".//joint[@axis]")) == len(driven) == len(car.find("actuator")) == 6
    masses = {link.get("name"): link.find("inertial/mass") for link in urdf.iter("link")}
    kinds = ("chassis", "wheel", "hinge")
    ours = sorted(
        float(mass.get("value"))
        for name, mass in masses.items()
        if mass is not None and any(kind in name for kind in kinds)
    )
    assert sorted(float(each.get("mass")) for each in car.iter("inertial")) == ours
