"""The bench's worlds with one cause of slowness each: they load without a warning, drive, scan."""

import json
import re
import sys
from pathlib import Path

import pytest

BENCH = Path(__file__).resolve().parents[2] / "bench"
sys.path.insert(0, str(BENCH))

from bullet_sim.formats.sdf.world import parse_world  # noqa: E402
from bullet_sim.world import World  # noqa: E402
from figures import BenchError, Spread  # noqa: E402
from sections import beside_gazebo  # noqa: E402
from worlds import causes  # noqa: E402


def file_of(uri):
    """Path of a file:// URI."""
    return re.sub("^file://", "", uri)


@pytest.mark.parametrize("name", causes.CAUSES)
def test_a_world_loads_and_stays(name, tmp_path):
    """Nothing is warned of; after half a second the robot stands on the ground, level."""
    path = causes.write(tmp_path, name)
    world = World()
    try:
        assert world.load(parse_world(path.read_text(), file_of, str(path))) == []
        world.step(500)
        pose = world.models["robot"].pose
        drift = 0.05 if causes.CAUSES[name].plane else 0.06  # its wheels are free on a slope
        assert pose.position[:2] == pytest.approx((0.0, 0.0), abs=drift)
        assert abs(pose.position[2] - 0.1) < (0.005 if causes.CAUSES[name].plane else 0.06)
        count = {"static_meshes": 300, "concave_meshes": 7, "loose_things": 50}
        loaded = len(set(world.models) - {"robot", "ground"})
        assert loaded == count.get(name, 80 if "posts" in causes.CAUSES[name].text else loaded)
    finally:
        world.close()


def test_a_folder_that_is_elsewhere_for_gazebo(tmp_path):
    text = causes.write(tmp_path, "static_meshes", "/elsewhere").read_text()
    assert text.count("<uri>file:///elsewhere/ring.obj</uri>") == 600 and str(tmp_path) not in text


def test_the_ring_is_closed_and_its_volume_is_that_of_a_ring(tmp_path):
    import trimesh

    causes.write_ring(tmp_path / "ring.obj")
    ring = trimesh.load(tmp_path / "ring.obj")
    assert ring.is_watertight and ring.is_winding_consistent and not ring.is_convex
    assert ring.volume == pytest.approx(2 * 3.14159**2 * 0.2 * 0.06**2, rel=0.1)


class FakeObserver:
    """Answers rounds as an observer of a world does; speed [m/s] of its robot."""

    def __init__(self, speed=0.3, count=40.0):
        self._speed, self._count = speed, count

    def answer(self):
        return {}

    def ask(self, line):
        if line.startswith("bare"):
            return {"pace": 40.0}
        return {"pace": 10.0, "received": {"/scan": self._count}, "speed": self._speed}


def test_figures_of_a_world():
    found = beside_gazebo.measure_world(FakeObserver(), 0.1, 3)
    assert Spread.read(found["ratio"]).median == 0.25
    assert found["messages_over_bare"] == {"/scan": 1.0}
    with pytest.raises(BenchError, match="0.010 m/s, commanded are 0.300"):
        beside_gazebo.measure_world(FakeObserver(speed=0.01), 0.1, 3)
    with pytest.raises(BenchError, match="nothing came on /scan"):
        beside_gazebo.measure_world(FakeObserver(count=0.0), 0.1, 3)


def test_every_world_has_gazebo_s_figure_and_a_row():
    theirs = beside_gazebo.recorded()
    assert set(theirs) == set(causes.CAUSES)
    for name, figures in theirs.items():
        assert figures["pairs"] >= 9 and figures["speed_m_s"] > 0.15
        assert set(causes.CAUSES[name].topics) <= set(figures["messages_over_bare"])
    rows = list(beside_gazebo.rows(json.loads(json.dumps(theirs))))
    assert len(rows) == len(causes.CAUSES)
    assert all(": 1.0 times its pace" in row.text for row in rows)
    pictures = [row for row in rows if "images per second" in row.text]
    assert len(pictures) == sum(bool(cause.pictures) for cause in causes.CAUSES.values())
    assert all("1.0 times its images per second" in row.text for row in pictures)
