"""bench/pictures_beside_gazebo.py: features beside what is recorded of Gazebo, pairs, bad input."""

import sys
from pathlib import Path

import pytest

BENCH = Path(__file__).resolve().parents[2] / "bench"
sys.path.insert(0, str(BENCH))

import pictures_beside_gazebo as command  # noqa: E402
from pictures import features, likeness  # noqa: E402


@pytest.fixture(name="seen", scope="module")
def _seen(tmp_path_factory):
    folder = tmp_path_factory.mktemp("features")
    features.write(folder)
    return features.render(folder)


@pytest.mark.parametrize("name", features.PLACES)
def test_each_feature_looks_as_in_gazebo(seen, name):
    pair = likeness.recorded_pair(likeness.recorded()[name], seen[name])
    assert command.is_alike(pair), command.figures_text(pair)
    if name in ("depth", "kinect"):
        assert pair.depth[0] > 0.99 and pair.depth[1] < 0.01
