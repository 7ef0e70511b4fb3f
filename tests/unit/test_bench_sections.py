"""Every section of the bench has its shape; efficiency refuses rounds that prove nothing."""

import importlib
import inspect
import sys
from pathlib import Path

import pytest

BENCH = Path(__file__).resolve().parents[2] / "bench"
sys.path.insert(0, str(BENCH))

from figures import BenchError, Spread  # noqa: E402
from sections import SECTIONS, efficiency, section  # noqa: E402


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


def test_what_limits_a_variant_is_told():
    rounds = [
        dict(free(), shares={"steps": steps, "messages": 0.3, "sockets": 0.05})
        for steps in (0.5, 0.6, 0.7)
    ]
    shares = efficiency._shares(rounds)
    assert shares == {"steps": 0.6, "messages": 0.3, "sockets": 0.05}
    ratio = Spread.of([0.4, 0.48, 0.5]).figures()
    text = efficiency._bound({"shares": shares, "ratio": ratio})
    assert text == "steps 60 %, messages 30 %, sockets 5 %; with nothing but steps it would be 0.80"
