"""The bench's worlds with one cause of slowness each: they load without a warning, drive, scan."""

import re
import sys
from pathlib import Path

import pytest

BENCH = Path(__file__).resolve().parents[2] / "bench"
sys.path.insert(0, str(BENCH))

from bullet_sim.formats.sdf.world import parse_world  # noqa: E402
from bullet_sim.world import World  # noqa: E402
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
