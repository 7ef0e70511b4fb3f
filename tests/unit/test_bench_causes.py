"""The bench's worlds with one cause of slowness each: they load without a warning, drive, scan."""

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
        drift = 0.05 if causes.CAUSES[name].plane else 0.08  # its wheels are free on a slope
        assert pose.position[:2] == pytest.approx((0.0, 0.0), abs=drift)
        height = 0.05 if name == "omni_bumper" else 0.1  # it has no wheels
        assert abs(pose.position[2] - height) < (0.005 if causes.CAUSES[name].plane else 0.06)
        count = {"static_meshes": 300, "concave_meshes": 7, "loose_things": 50}
        loaded = len(set(world.models) - {"robot", "ground"})
        assert loaded == count.get(name, 80 if "posts" in causes.CAUSES[name].text else loaded)
    finally:
        world.close()


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
