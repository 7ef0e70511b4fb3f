"""A step with ten times the triangles outside the car's neighborhood; no ROS."""

import os
import pathlib
import tempfile

from pairs import alternate, pairs_of, rate_of_work
from report import ratio_row
from usage import Monitor
from worlds.core import world_with

CELLS = (32, 100)  # of the hills: 2 cells^2 triangles
SECONDS = 0.5  # of a round
STEPS = 100  # a call


def measure(quick, _log):
    """Steps per second with 20,000 far triangles over those with 2,000."""
    with tempfile.TemporaryDirectory() as folder:
        worlds = [world_with(pathlib.Path(folder), cells) for cells in CELLS]
        try:

            def one_round(world):
                def work():
                    world.step(STEPS)
                    return STEPS

                return rate_of_work(work, SECONDS)

            measured = alternate(
                lambda: one_round(worlds[0]),
                {"many": lambda: one_round(worlds[1])},
                pairs_of(quick),
                Monitor({"bench": [os.getpid()]}),
            )
        finally:
            for world in worlds:
                world.close()
    return dict(measured["many"].figures(), triangles=[2 * cells**2 for cells in CELLS])


def rows(figures):
    """The ratio."""
    few, many = figures["triangles"]
    yield ratio_row(f"steps, {many} far triangles", figures, f"those with {few}", "steps per s")
