"""Results as data: what is in bench/results/, and what a file of results must hold."""

import sys
from pathlib import Path

BENCH = Path(__file__).resolve().parents[2] / "bench"
sys.path.insert(0, str(BENCH))

import results  # noqa: E402
from figures import Spread  # noqa: E402
from pairs import alternate  # noqa: E402
from sections import SECTIONS, efficiency  # noqa: E402


def test_what_is_kept_is_of_the_schema_and_of_a_section():
    for path in (BENCH / "results").glob("*"):
        assert path.suffix == ".json", path
        found = results.check(path.read_text())
        assert found["name"] == path.stem in SECTIONS, path
        assert found["commit"] and not found["commit"].endswith("+"), f"{path}: uncommitted files"


def figures(*values):
    """What the section solver gives of one scene, the reference always 100."""
    measured = alternate(lambda: 100.0, {"x": iter(values).__next__}, len(values))
    return {"rows": {"steps, a car": measured["x"].figures()}}


def test_what_is_saved_can_be_read(tmp_path, monkeypatch):
    monkeypatch.setattr(results, "FOLDER", tmp_path / "results")
    path = results.save("solver", figures(80.0, 70.0, 90.0))
    assert path == tmp_path / "results" / "solver.json"
    found = results.check(path.read_text())
    (figure,) = found["figures"]
    assert (figure["value"], figure["spread"], figure["runs"]) == (0.8, [0.7, 0.9], 3)
    assert (figure["name"], figure["unit"]) == ("ode, steps, a car", "")
    assert (found["name"], found["others"]) == ("solver", 0.0)
    assert found["machine"]["cores"] >= 1 and found["machine"]["processor"]


def test_what_limits_a_variant_is_told():
    rounds = [
        {"shares": {"steps": steps, "messages": 0.3, "sockets": 0.05}} for steps in (0.5, 0.6, 0.7)
    ]
    shares = efficiency._shares(rounds)
    assert shares == {"steps": 0.6, "messages": 0.3, "sockets": 0.05}
    ratio = Spread.of([0.4, 0.48, 0.5]).figures()
    text = efficiency._bound({"shares": shares, "ratio": ratio})
    assert text == "steps 60 %, messages 30 %, sockets 5 %; with nothing but steps it would be 0.80"
