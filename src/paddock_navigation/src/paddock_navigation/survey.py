"""The map that a lidar makes of a world which looks around everywhere that can be reached."""

from __future__ import annotations

import math
from typing import Callable

import cv2
import numpy as np
from bullet_sim.engine.api import Rays

from paddock_navigation.grid import FREE, OCCUPIED, UNKNOWN, Grid, MapError

REACH = 8.0  # of a look [m]
ROOM = 2  # cells between an obstacle and where a look is taken from
GAP = 4  # cells between hits of neighbouring rays that are of one surface
CROSSED = 100  # surfaces on a way that are looked for
INTO = 0.01  # how far behind its surface an obstacle is marked [m]

Cast = Callable[[Rays], np.ndarray]


def survey(
    cast: Cast,
    start: tuple[float, float],
    height: float,
    resolution: float,
    bounds: tuple[float, float, float, float],
) -> Grid:
    """Look around from the start, then from wherever what is free ends at what is unknown.

    Args:
        cast: engine.cast_rays.
        start: (x, y) of the first look [m].
        height: of all looks [m].
        resolution: side of a cell [m].
        bounds: smallest x, y, largest x, y of the map [m].

    Raises:
        MapError: the start is outside of the bounds, or inside something.
    """
    return _Survey(cast, height, resolution, bounds).run(start)


class _Survey:
    def __init__(self, cast: Cast, height: float, resolution: float, bounds: tuple) -> None:
        self._cast, self._height, self._resolution = cast, height, resolution
        self._corner = np.array(bounds[:2])
        columns, rows = np.ceil((np.array(bounds[2:]) - self._corner) / resolution).astype(int)
        self._cells = np.full((rows, columns), UNKNOWN, np.int8)
        count = int(2.0 * math.pi * REACH / resolution)  # neighbours hit neighbouring cells
        angles = np.arange(count) * (2.0 * math.pi / count)
        self._directions = np.column_stack([np.cos(angles), np.sin(angles), np.zeros(count)])
        self._along = np.arange(0.0, REACH, 0.5 * resolution)

    def run(self, start: tuple[float, float]) -> Grid:
        """See survey()."""
        row, column = self._indices(np.array([start]))
        if not self._inside(row, column)[0]:
            raise MapError(f"the start {start} is outside of the map")
        if self._is_within(np.array(start)):
            raise MapError(f"the start {start} at the height of {self._height} m is no free place")
        self._look(np.array(start))
        done = np.zeros(self._cells.shape, bool)  # from where was looked
        while True:
            row_column = self._next(done)
            if row_column is None:
                break
            done[row_column] = True
            row, column = row_column
            self._look(self._corner + (np.array([column, row]) + 0.5) * self._resolution)
        return Grid(self._cells, self._resolution, (float(self._corner[0]), float(self._corner[1])))

    def _is_within(self, place: np.ndarray) -> bool:
        """Whether a place is inside a solid: most ways from it cross an odd number of surfaces."""
        odd = 0
        for direction in self._directions[:: len(self._directions) // 8]:
            there, crossed = np.array([*place, self._height]), 0
            while crossed < CROSSED:
                rays = Rays(there, direction[None], 0.0, REACH)
                distance = float(self._cast(rays)[0])
                if not math.isfinite(distance):
                    break
                there, crossed = there + (distance + INTO) * direction, crossed + 1
            odd += 1 if crossed % 2 else -1
        return odd > 0

    def _next(self, done: np.ndarray) -> tuple[int, int] | None:
        """A free cell beside unknown ones with room around it, farthest from earlier looks."""
        near = np.ones((3, 3), np.uint8)
        unknown = cv2.dilate((self._cells == UNKNOWN).astype(np.uint8), near)
        tight = cv2.dilate((self._cells == OCCUPIED).astype(np.uint8), near, iterations=ROOM)
        open_ends = (self._cells == FREE) & (unknown > 0) & (tight == 0) & ~done
        if not open_ends.any():
            return None
        distance = cv2.distanceTransform((~done).astype(np.uint8), cv2.DIST_L2, 3)
        distance[~open_ends] = -1.0
        found = np.unravel_index(int(np.argmax(distance)), distance.shape)
        return int(found[0]), int(found[1])

    def _indices(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        column, row = np.floor((points[..., :2] - self._corner) / self._resolution).astype(int).T
        return row.T, column.T

    def _inside(self, row: np.ndarray, column: np.ndarray) -> np.ndarray:
        rows, columns = self._cells.shape
        return (row >= 0) & (row < rows) & (column >= 0) & (column < columns)

    def _look(self, place: np.ndarray) -> None:
        """Mark what a lidar sees from a place: free cells, then what its rays end at."""
        rays = Rays(np.array([*place, self._height]), self._directions, 0.0, REACH)
        distances = self._cast(rays)
        ends = np.minimum(distances, REACH)
        hit = np.isfinite(distances)
        points = place + self._along[:, None, None] * self._directions[:, :2]
        passed = self._along[:, None] < np.where(hit, ends - 0.5 * self._resolution, ends)
        row, column = self._indices(points[passed])
        inside = self._inside(row, column)
        row, column = row[inside], column[inside]
        free = self._cells[row, column] == UNKNOWN
        self._cells[row[free], column[free]] = FREE
        struck = place + (ends + INTO)[:, None] * self._directions[:, :2]
        row, column = self._indices(self._filled(struck, hit))
        inside = self._inside(row, column)
        self._cells[row[inside], column[inside]] = OCCUPIED

    def _filled(self, struck: np.ndarray, hit: np.ndarray) -> np.ndarray:
        """Points that rays hit, with those between neighbouring ones that are of one surface.

        Args:
            struck: (n, 2) ends of the rays [m].
            hit: (n,) whether there is something.
        """
        following = np.roll(struck, -1, axis=0)
        apart = np.hypot(*(following - struck).T)
        joined = hit & np.roll(hit, -1) & (apart < GAP * self._resolution)
        shares = np.linspace(0.0, 1.0, 2 * GAP, endpoint=False)[:, None, None]
        between = struck[joined] + shares * (following - struck)[joined]
        return np.concatenate([struck[hit], between.reshape(-1, 2)])
