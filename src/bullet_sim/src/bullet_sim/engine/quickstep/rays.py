"""Rays from one point at planes, boxes, spheres, cylinders and meshes.

Boxes around the shapes are the leaves of a tree of boxes, which each scan fits to where the shapes
are now. A mesh is a tree of boxes around its triangles, in its own frame.
"""

import math
from typing import Any

from bullet_sim.engine.quickstep import layout as col
from bullet_sim.engine.quickstep.compiled import compiled, inlined, temporary
from bullet_sim.engine.quickstep.state import Casting
from bullet_sim.engine.quickstep.vectors import matrix
from bullet_sim.pose import Array

_STEEP = 1e300  # instead of 1 / 0
_SLACK = 1e-9  # of a coordinate, by which boxes are larger


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
def _inverse(v: Any) -> Any:
    """1 / v of each component, finite."""
    return (
        1.0 / v[0] if v[0] != 0.0 else _STEEP,
        1.0 / v[1] if v[1] != 0.0 else _STEEP,
        1.0 / v[2] if v[2] != 0.0 else _STEEP,
    )


@compiled
def _enter(box: Array, c: Any, inverse: Any, farthest: float) -> float:
    """Distance at which a ray enters a box (lower and upper corner), at least 0; inf: it misses it
    or is there beyond the farthest."""
    one, two = (box[0] - c[0]) * inverse[0], (box[3] - c[0]) * inverse[0]
    enter, leave = min(one, two), max(one, two)
    one, two = (box[1] - c[1]) * inverse[1], (box[4] - c[1]) * inverse[1]
    enter, leave = max(enter, min(one, two)), min(leave, max(one, two))
    one, two = (box[2] - c[2]) * inverse[2], (box[5] - c[2]) * inverse[2]
    enter, leave = max(enter, min(one, two), 0.0), min(leave, max(one, two), farthest)
    return enter if enter <= leave else math.inf


@compiled
def _at_triangle(t: Array, c: Any, v: Any) -> float:
    """Distance at which a ray meets a triangle (a corner, two edges), from either side; inf: not.

    After Möller and Trumbore, "Fast, Minimum Storage Ray/Triangle Intersection" (1997).
    """
    x, y, z = v[1] * t[8] - v[2] * t[7], v[2] * t[6] - v[0] * t[8], v[0] * t[7] - v[1] * t[6]
    volume = t[3] * x + t[4] * y + t[5] * z
    if volume == 0.0:
        return math.inf
    p, q, r = c[0] - t[0], c[1] - t[1], c[2] - t[2]
    one = (p * x + q * y + r * z) / volume
    if not -_SLACK <= one <= 1.0 + _SLACK:
        return math.inf
    x, y, z = q * t[5] - r * t[4], r * t[3] - p * t[5], p * t[4] - q * t[3]
    two = (v[0] * x + v[1] * y + v[2] * z) / volume
    if not (two >= -_SLACK and one + two <= 1.0 + _SLACK):
        return math.inf
    return (t[6] * x + t[7] * y + t[8] * z) / volume


@inlined
def _next_leaf(
    node: int, waiting: int, first: int, boxes: Array, children: Array, stack: Any, ray: Any,
    farthest: float,
) -> Any:  # fmt: skip
    """The next leaf of a tree that a ray enters, the nearer of two branches before the other.

    Args:
        node: with which to go on; -1: with what waits.
        waiting, first: places of `todo` after the last node that waits, and of the first.
        stack, ray: todo and entries; where a ray comes from and the inverse of its direction.

    Returns:
        (its number, -1: there is none any more; how far `todo` is filled).
    """
    inner, (todo, entries), (c, inverse) = len(children), stack, ray
    while True:
        while 0 <= node < inner:
            one, two = children[node, 0], children[node, 1]
            enter = _enter(boxes[one], c, inverse, farthest)
            other = _enter(boxes[two], c, inverse, farthest)
            if other < enter:
                one, two, enter, other = two, one, other, enter
            if other <= farthest:
                todo[waiting], entries[waiting] = two, other
                waiting += 1
            node = one if enter <= farthest else -1
        if node >= inner:
            return node - inner, waiting
        if waiting == first:
            return -1, waiting
        waiting -= 1
        if entries[waiting] <= farthest:
            node = todo[waiting]


@inlined
def _at_mesh(
    root: int, c: Any, v: Any, start: float, farthest: float, first: int, casting: Casting
) -> float:
    """Distance of the nearest triangle of a mesh between two distances; inf: none.

    Args:
        first: place of `todo` that is free, and those after it.
    """
    nodes, children, stack = casting.nodes, casting.children, (casting.todo, casting.entries)
    inverse, nearest = _inverse(v), math.inf
    node, waiting = root if _enter(nodes[root], c, inverse, farthest) <= farthest else -1, first
    while True:
        leaf, waiting = _next_leaf(
            node, waiting, first, nodes, children, stack, (c, inverse), farthest
        )
        if leaf < 0:
            return nearest
        node, at = -1, _at_triangle(casting.triangles[leaf], c, v)
        if start <= at <= farthest:
            nearest = farthest = at


@inlined
def _at_shape(
    s: int, direction: Array, start: float, farthest: float, waiting: int, casting: Casting
) -> float:
    """Distance at which a ray meets a shape but a plane, between two distances; inf: not."""
    f, c = casting.frames[s], casting.origins[s]
    u, v, w = direction[0], direction[1], direction[2]
    kind, origin = casting.kinds[s], (c[0], c[1], c[2])
    ray = (
        u * f[0, 0] + v * f[1, 0] + w * f[2, 0],
        u * f[0, 1] + v * f[1, 1] + w * f[2, 1],
        u * f[0, 2] + v * f[1, 2] + w * f[2, 2],
    )
    if kind == col.MESH:
        return _at_mesh(casting.roots[s], origin, ray, start, farthest, waiting, casting)
    enter, leave = _part(kind, origin, ray, casting.sizes[s])
    return enter if enter <= leave and start <= enter <= farthest else math.inf


@compiled
def _place_shapes(casting: Casting) -> None:
    """Put the shapes of bodies where these are, boxes around all but planes, and the rays' origin
    into the frames of all."""
    turn = temporary(9)
    center, bodies, inner = casting.center, casting.bodies, len(casting.branches)
    for s in range(len(casting.kinds)):
        f, at, row = casting.frames[s], casting.centers[s], casting.rows[s]
        if row >= 0:
            matrix(bodies[row, col.QUAT : col.QUAT + 4], turn)
            for i in range(3):
                at[i] = bodies[row, col.POS + i]
                for j in range(3):
                    at[i] += turn[3 * i + j] * casting.places[s, j]
                    f[i, j] = 0.0
                    for k in range(3):
                        f[i, j] += turn[3 * i + k] * casting.turns[s, k, j]
        for i in range(3):
            casting.origins[s, i] = 0.0
            for j in range(3):
                casting.origins[s, i] += (center[j] - at[j]) * f[j, i]
        if s < len(casting.extents):
            extent, box = casting.extents[s], casting.boxes[inner + s]
            for i in range(3):
                x, half = at[i], 0.0
                for j in range(3):
                    x += f[i, j] * extent[j]
                    half += abs(f[i, j]) * extent[3 + j]
                half += _SLACK * (abs(x) + half)
                box[i], box[3 + i] = x - half, x + half


@compiled
def _fit(casting: Casting) -> None:
    """Fit the tree's boxes to those of the shapes; what is not a number is in none."""
    boxes, branches = casting.boxes, casting.branches
    for n in range(len(branches) - 1, -1, -1):  # children come after their parents
        one, two = boxes[branches[n, 0]], boxes[branches[n, 1]]
        for k in range(3):
            low, high, other, far = one[k], one[3 + k], two[k], two[3 + k]
            boxes[n, k] = low if low <= other or other != other else other
            boxes[n, 3 + k] = high if high >= far or far != far else far


@inlined
def _nearest(i: int, near: float, far: float, own: int, look_near: bool, casting: Casting) -> float:
    """Distance of what a ray hits first."""
    boxes, branches, stack = casting.boxes, casting.branches, (casting.todo, casting.entries)
    direction, c, owners = casting.directions[i], casting.center, casting.owners
    nearest, farthest = math.inf, far
    for s in range(len(casting.extents), len(casting.kinds)):  # planes
        start = 0.0 if look_near and owners[s] != own else near
        f = casting.frames[s]
        along = direction[0] * f[0, 2] + direction[1] * f[1, 2] + direction[2] * f[2, 2]
        if along != 0.0:
            at = -casting.origins[s, 2] / along
            if start <= at <= farthest:
                nearest = farthest = at
    if len(branches) == 0:
        return nearest
    origin, inverse = (c[0], c[1], c[2]), _inverse((direction[0], direction[1], direction[2]))
    node, waiting = 0 if _enter(boxes[0], origin, inverse, farthest) <= farthest else -1, 0
    while True:
        leaf, waiting = _next_leaf(
            node, waiting, 0, boxes, branches, stack, (origin, inverse), farthest
        )
        if leaf < 0:
            return nearest
        start = 0.0 if look_near and owners[leaf] != own else near
        node, at = -1, _at_shape(leaf, direction, start, farthest, waiting, casting)
        if at <= farthest:
            nearest = farthest = at


@compiled
def cast(near: float, far: float, own: int, look_near: bool, casting: Casting) -> int:
    """Distances of what rays hit first up to `far` [m], into casting.ranges; inf: nothing.

    What begins in a box, sphere or cylinder misses it.

    Args:
        near: distance from which on hits count, of bodies but `own` only if not look_near [m].
        own: number of a body, or -1.
        look_near: what is nearer than `near` has the distance -inf.
    """
    _place_shapes(casting)
    _fit(casting)
    for i in range(len(casting.directions)):
        found = _nearest(i, near, far, own, look_near, casting)
        casting.ranges[i] = -math.inf if found < near else found
    return 0
