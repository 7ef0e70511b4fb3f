"""A world whose walls are the occupied cells of a map."""

from __future__ import annotations

import math

import numpy as np

from paddock_navigation.grid import OCCUPIED, Grid

WORLD = """<?xml version="1.0"?>
<sdf version="1.6">
  <world name="map">
    <include><uri>model://sun</uri></include>
    <include><uri>model://ground_plane</uri></include>
    <model name="walls">
      <static>true</static>
      <pose>{x:.6g} {y:.6g} 0 0 0 {yaw:.9g}</pose>
      <link name="walls">
{boxes}
      </link>
    </model>
  </world>
</sdf>
"""
BOX = """        <{what} name="{name}"><pose>{x:.6g} {y:.6g} {z:.6g} 0 0 0</pose>\
<geometry><box><size>{a:.6g} {b:.6g} {c:.6g}</size></box></geometry></{what}>"""


def rectangles(occupied: np.ndarray) -> list[tuple[int, int, int, int]]:
    """Rectangles that cover the occupied cells, each once: equal runs of following rows are one.

    Args:
        occupied: (rows, columns) bool.

    Returns:
        (first row, first column, last row + 1, last column + 1) each.
    """
    done, growing = [], {}  # type: ignore[var-annotated]
    for row in range(len(occupied) + 1):
        runs: list[tuple[int, int]] = []
        if row < len(occupied):
            edges = np.flatnonzero(np.diff(np.concatenate([[0], occupied[row].view(np.int8), [0]])))
            runs = list(zip(edges[::2].tolist(), edges[1::2].tolist()))
        for run in set(growing) - set(runs):
            done.append((growing.pop(run), run[0], row, run[1]))
        for run in runs:
            growing.setdefault(run, row)
    return sorted(done)


def world(grid: Grid, height: float) -> str:
    """Text of an SDF world: walls of a height [m] on the ground, in the map's frame.

    The model of the walls is at the map's origin, as its YAML file has it.
    """
    boxes, side = [], grid.resolution
    for number, (top, left, bottom, right) in enumerate(rectangles(grid.cells == OCCUPIED)):
        place = {
            "x": 0.5 * (left + right) * side,
            "y": 0.5 * (top + bottom) * side,
            "z": 0.5 * height,
            "a": (right - left) * side,
            "b": (bottom - top) * side,
            "c": height,
        }
        for what in ("collision", "visual"):
            boxes.append(BOX.format(what=what, name=f"wall_{number}", **place))
    yaw = math.remainder(grid.yaw, 2.0 * math.pi)
    return WORLD.format(x=grid.origin[0], y=grid.origin[1], yaw=yaw, boxes="\n".join(boxes))
