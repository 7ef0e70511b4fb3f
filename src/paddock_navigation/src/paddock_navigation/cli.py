"""Write the map of a world or launch file, or the world of a map: what ./run map runs."""

from __future__ import annotations

import argparse
import os
import sys
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from bullet_sim.errors import SimError
from paddock_gym.errors import GymError
from paddock_gym.simulation.launch_file import from_launch
from paddock_gym.simulation.recipe import from_files
from paddock_gym.simulation.robot_world import RobotWorld

from paddock_navigation import walls
from paddock_navigation.grid import OCCUPIED, Grid, MapError, load
from paddock_navigation.survey import survey

MARGIN = 1.0  # of the map around what stands in the world [m]
EMPTY = 5.0  # of the map around the start where nothing stands [m]


class Settings(NamedTuple):
    """What make_map() is asked for.

    Attributes:
        height: of the lidar [m].
        resolution: side of a cell [m].
        start: (x, y) [m], None: where the launch file spawns its first robot, else the origin.
        size: largest side of the map, with the start in its middle [m].
    """

    height: float
    resolution: float
    start: tuple[float, float] | None = None
    size: float = 60.0


def make_map(words: list[str], settings: Settings, base: str) -> str:
    """Write the map of a world; returns what there is now, for the user.

    Args:
        words: a world file, or a launch file as for roslaunch.
        base: path of the files without .pgm and .yaml.

    Raises:
        GymError, SimError, MapError: the world cannot be made, or the start is no free place.
    """
    is_world = len(words) == 1 and words[0].endswith((".world", ".sdf"))
    recipe = from_files(world=words[0]) if is_world else from_launch(" ".join(words))
    robots = RobotWorld(recipe)
    try:
        start = settings.start
        for name in [spawn.name for spawn in recipe.spawns]:
            model = robots.world.models.get(name)
            if model is not None and not model.description.static:
                start = start or (float(model.pose.position[0]), float(model.pose.position[1]))
                robots.world.delete(name)
        start = start or (0.0, 0.0)
        half = 0.5 * settings.size
        bounds = (start[0] - half, start[1] - half, start[0] + half, start[1] + half)
        cast = robots.world.engine.cast_rays
        grid = survey(cast, start, settings.height, settings.resolution, bounds)
    finally:
        robots.close()
    grid = _cropped(grid, start)
    grid.save(base)
    rows, columns = grid.cells.shape
    count = int((grid.cells == OCCUPIED).sum())
    return f"{base}.yaml: {columns} x {rows} cells of {grid.resolution} m, {count} occupied"


def _cropped(grid: Grid, start: tuple[float, float]) -> Grid:
    """The part of a grid with what is occupied and the start, with margins."""
    side = grid.resolution
    here = (np.array(start) - grid.origin)[::-1] / side  # row, column
    places = np.argwhere(grid.cells == OCCUPIED)
    margin = (MARGIN if len(places) else EMPTY) / side
    places = np.vstack([places, here])
    low, high = places.min(axis=0) - margin, places.max(axis=0) + 1 + margin
    top, left = np.maximum(np.floor(low), 0).astype(int)
    bottom, right = np.minimum(np.ceil(high), grid.cells.shape).astype(int)
    origin = (grid.origin[0] + left * side, grid.origin[1] + top * side)
    return replace(grid, cells=grid.cells[top:bottom, left:right], origin=origin)


def make_world(path: str, height: float, base: str) -> str:
    """Write the world of a map; returns what there is now, for the user.

    Args:
        path: of the map's YAML file.
        height: of the walls [m].
        base: path of the file without .world.

    Raises:
        MapError: the map cannot be read.
    """
    grid = load(path)
    text = walls.world(grid, height)
    with open(f"{base}.world", "w", encoding="utf-8") as file:
        file.write(text)
    return f"{base}.world: walls of {text.count('<collision')} boxes, {height} m high"


def main() -> int:
    """Returns the exit status."""
    parser = argparse.ArgumentParser(prog="./run map")
    parser.add_argument("words", nargs="+")
    parser.add_argument("--height", type=float, required=True)
    parser.add_argument("--resolution", type=float, required=True)
    parser.add_argument("--start", type=float, nargs=2)
    parser.add_argument("--size", type=float, required=True)
    parser.add_argument("--out", required=True)
    options = parser.parse_args()
    base = os.path.splitext(options.out)[0]
    try:
        if options.words[0].endswith((".yaml", ".yml")):
            print(make_world(options.words[0], options.height, base))
        else:
            start = tuple(options.start) if options.start else None
            settings = Settings(options.height, options.resolution, start, options.size)
            print(make_map(options.words, settings, base))
    except (GymError, SimError, MapError, OSError) as error:
        print(f"run: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
