"""bench/others.py: what it tells of subjects it measured, and of those that are not installed."""

import stat
import sys
from pathlib import Path

import pytest

BENCH = Path(__file__).resolve().parents[2] / "bench"
sys.path.insert(0, str(BENCH))

import others  # noqa: E402
from figures import BenchError  # noqa: E402
from observers.others import KINDS  # noqa: E402
from pairs import alternate  # noqa: E402

WORKER = """#!{python}
import json, sys
name = sys.argv[-1]
print(json.dumps({{"period": 0.01 if "f1" in name else 0.05, "time_step": 0.005,
                   "cars": 16 if name.endswith("16") else 1}}), flush=True)
for line in sys.stdin:
    print(json.dumps({{"rate": 500.0 if "f1" in name else 200.0}}), flush=True)
"""


def program(path, text):
    path.write_text(text)
    path.chmod(path.stat().st_mode | stat.S_IXUSR)
    return str(path)


@pytest.fixture
def python(tmp_path):
    """What answers in a Python's place."""
    return program(tmp_path / "python", WORKER.format(python=sys.executable))


def test_every_subject_has_its_process():
    assert set(KINDS) == set(others.SUBJECTS)
    assert {kind for kind, _ in others.SUBJECTS.values()} == {"paddock", *others.INSTALL}
    assert set(others.NEEDED) == set(others.INSTALL)


def test_what_is_measured_is_told(python):
    found = others.measure({"paddock": python, "f1tenth": python}, quick=True)
    assert set(found) == set(others.SUBJECTS) - {others.REFERENCE, "car_racing"}
    assert found["f1tenth_16"]["variant"]["median"] == 500.0
    assert found["f1tenth_16"]["real_time"] == pytest.approx(5.0)
    table = {line.split()[0]: line for line in list(others.lines(found))[1:-2]}
    assert set(table) == set(others.SUBJECTS) - {"car_racing"}
    assert table["paddock_state_1"].split()[1] == "200"
    assert "0.0500    0.0050       10.0" in table["paddock_state_1"]  # 200 steps of 0.05 s
    assert "0.0100    0.0050       80.0" in table["f1tenth_16"]  # 500 of 0.01 s with 16 cars
    assert "1080 rays" in table["f1tenth_1"]


def test_simulated_time_is_compared_turn_by_turn():
    rates = {"paddock_lidar_1": iter((30.0, 60.0)), "f1tenth_1": iter((100.0, 100.0))}
    measured = alternate(
        lambda: 10.0, {name: lambda own=own: next(own) for name, own in rates.items()}, 2
    )
    found = {name: pairs.figures() for name, pairs in measured.items()}
    found["paddock_lidar_1"]["period"], found["f1tenth_1"]["period"] = 0.05, 0.01
    spread = others.over(found, "paddock_lidar_1", "f1tenth_1")
    assert (spread.least, spread.greatest) == (pytest.approx(1.5), pytest.approx(3.0))


@pytest.mark.parametrize("kind", others.INSTALL)
def test_what_is_not_installed_says_how(kind, tmp_path):
    how = f"{kind} is not measured: install it with: python3 -m venv"
    assert others.missing(kind, None).startswith(how)
    reason = others.missing(kind, str(tmp_path / "absent"))
    assert "absent', which is no Python that can be run; " + how in reason
    failing = program(tmp_path / "failing", "#!/bin/sh\nexit 1\n")
    assert others.missing(kind, failing).startswith(f"{failing} cannot import ")
    assert others.missing(kind, program(tmp_path / "good", "#!/bin/sh\n")) == ""


def test_a_process_that_ends_is_an_error(tmp_path):
    broken = program(tmp_path / "broken", "#!/bin/sh\nexit 3\n")
    with pytest.raises(BenchError, match="f1tenth_1: its process ended or answered ''"):
        others.Subject(broken, "f1tenth_1")
