"""The truck and its trailer for a minute at rest and over 50 m of arcs."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "unit"))

from test_cybertruck_physics import check_odometry, check_rest, truck, trucks  # noqa: E402, F401


def test_at_rest_for_a_minute(truck):  # noqa: F811
    check_rest(truck, 60.0)


def test_odometry_over_50_m(truck):  # noqa: F811
    check_odometry(truck, 50.0)
