"""Rays from one point at boxes, spheres and cylinders; slow where there is no numba."""

import math
from collections.abc import Callable
from typing import Any

from bullet_sim.engine.quickstep import layout as col
from bullet_sim.engine.quickstep.state import Casting
from bullet_sim.pose import Array

try:
    from bullet_sim.engine.quickstep.compiled import compiled
except ImportError:  # another solver was chosen, and PyBullet casts at what moves

    def compiled(function: Callable[..., Any]) -> Callable[..., Any]:
        return function


@compiled
def _slab(center: float, along: float, half: float, enter: float, leave: float) -> Any:
    """Shorten the part of a ray between two distances to that in a slab |x| <= half."""
    if along == 0.0:
        return (enter, leave) if abs(center) <= half else (math.inf, -math.inf)
    one, two = (-half - center) / along, (half - center) / along
    return max(enter, min(one, two)), min(leave, max(one, two))


@compiled
def _round(square: float, half: float, rest: float) -> Any:
    """Part of a ray |c + x v| <= r: square = v v, half = v c, rest = c c - r r."""
    if square == 0.0:  # along a cylinder's axis
        return (-math.inf, math.inf) if rest <= 0.0 else (math.inf, -math.inf)
    root = half * half - square * rest
    if not root >= 0.0:
        return math.inf, -math.inf
    root = math.sqrt(root)
    return (-half - root) / square, (-half + root) / square


@compiled
def _part(kind: int, c: Any, v: Any, size: Array) -> Any:
    """Distances at which a ray c + x v enters and leaves a shape, in its frame."""
    if kind == col.BOX:
        enter, leave = _slab(c[0], v[0], size[0], -math.inf, math.inf)
        enter, leave = _slab(c[1], v[1], size[1], enter, leave)
        return _slab(c[2], v[2], size[2], enter, leave)
    square, half = v[0] * v[0] + v[1] * v[1], v[0] * c[0] + v[1] * c[1]
    rest = c[0] * c[0] + c[1] * c[1] - size[0] * size[0]
    if kind == col.SPHERE:
        return _round(square + v[2] * v[2], half + v[2] * c[2], rest + c[2] * c[2])
    enter, leave = _round(square, half, rest)
    return _slab(c[2], v[2], size[1], enter, leave)


@compiled
def cast(far: float, casting: Casting) -> int:
    """Shorten distances to those of the nearest hit up to `far` [m]; what begins in a shape misses
    it."""
    (center, directions, low, high, centers, frames, sizes, radii, kinds, starts,
     ranges) = casting  # fmt: skip
    for s in range(len(kinds)):
        kind = kinds[s]
        if kind != col.BOX and kind != col.SPHERE and kind != col.CYLINDER:
            continue
        x, y, z = centers[s, 0], centers[s, 1], centers[s, 2]
        r, f = radii[s], frames[s]
        if x + r < low[0] or y + r < low[1] or z + r < low[2]:
            continue
        if x - r > high[0] or y - r > high[1] or z - r > high[2]:
            continue
        x, y, z = x - center[0], y - center[1], z - center[2]
        square = x * x + y * y + z * z - r * r
        tangent = math.sqrt(square) if square > 0.0 else -math.inf  # of a cone around the sphere
        c = (
            -(x * f[0, 0] + y * f[1, 0] + z * f[2, 0]),
            -(x * f[0, 1] + y * f[1, 1] + z * f[2, 1]),
            -(x * f[0, 2] + y * f[1, 2] + z * f[2, 2]),
        )
        for i in range(len(directions)):
            u, v, w = directions[i, 0], directions[i, 1], directions[i, 2]
            if u * x + v * y + w * z < tangent:
                continue
            ray = (
                u * f[0, 0] + v * f[1, 0] + w * f[2, 0],
                u * f[0, 1] + v * f[1, 1] + w * f[2, 1],
                u * f[0, 2] + v * f[1, 2] + w * f[2, 2],
            )
            enter, leave = _part(kind, c, ray, sizes[s])
            if enter <= leave and starts[s] <= enter <= far and enter < ranges[i]:
                ranges[i] = enter
    return 0
