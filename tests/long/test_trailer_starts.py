"""Random starts of the trailer in the physics, where the default run has four others."""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "physics"))

from test_trailer_physics import check_start, coarse_rig, random_starts  # noqa: E402, F401

STARTS = [*random_starts(12, 21)[4:], *random_starts(50, 22)]


@pytest.mark.parametrize("start", STARTS, ids="{0[0]:.2f}, {0[1]:.2f}".format)
def test_random_starts_converge(coarse_rig, start):  # noqa: F811
    check_start(coarse_rig, start)
