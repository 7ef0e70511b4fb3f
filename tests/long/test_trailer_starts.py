"""Fifty random starts of the trailer in the physics, where the default run has twelve others."""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "physics"))

from test_trailer_physics import check_start, coarse_rig, random_starts  # noqa: E402, F401


@pytest.mark.parametrize("start", random_starts(50, 22), ids="{0[0]:.2f}, {0[1]:.2f}".format)
def test_random_starts_converge(coarse_rig, start):  # noqa: F811
    check_start(coarse_rig, start)
