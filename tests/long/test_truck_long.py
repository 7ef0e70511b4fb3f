"""The truck and its trailer for a minute at rest and over 32 m of each figure."""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "unit"))

from test_cybertruck_physics import (  # noqa: E402, F401
    alone,
    check_rest,
    train,
    truck,
    trucks,
)
from test_truck_dead_reckoning import FIGURES, FORWARD, check_figure  # noqa: E402


def test_at_rest_for_a_minute(truck):  # noqa: F811
    check_rest(truck, 60.0)


@pytest.mark.parametrize("name", FIGURES)
def test_figures(alone, name):  # noqa: F811
    check_figure(alone, name)


@pytest.mark.parametrize("name", FORWARD)
def test_figures_with_the_trailer(train, name):  # noqa: F811
    check_figure(train, name)
