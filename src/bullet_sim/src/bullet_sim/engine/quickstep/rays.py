"""Rays from one point at planes, boxes, spheres, cylinders and meshes, eight at once.

Boxes around the shapes are the leaves of a tree of boxes, which each scan fits to where the shapes
are now. A mesh is a tree of boxes around its triangles, in its own frame. Eight rays that follow
each other go through a tree together: to each box that one of them enters.
"""

import math
from typing import Any

from bullet_sim.engine.quickstep import layout as col
from bullet_sim.engine.quickstep.compiled import compiled, inlined, temporary
from bullet_sim.engine.quickstep.lanes import (
    choose,
    greatest,
    highest,
    least,
    load_eight,
    lowest,
    roots,
    spread,
    store,
)
from bullet_sim.engine.quickstep.state import Casting
from bullet_sim.engine.quickstep.vectors import matrix
from bullet_sim.pose import Array

_STEEP = 1e300  # instead of 1 / 0
_SLACK = 1e-9  # of a coordinate, by which boxes are larger
_RAYS = 8
# Places in an array of numbers of eight rays: directions in the world and their inverse, the same
# in the frame of a mesh, distance up to which hits count, distance of the nearest hit
_WORLD, _LOCAL, _FARTHEST, _HIT, _SIZE = 0, 48, 96, 104, 112


@inlined
def _slab(center: float, along: Any, half: float, enter: Any, leave: Any) -> Any:
    """Shorten the parts of rays between two distances to those in a slab |x| <= half."""
    one, two = spread(-half - center) / along, spread(half - center) / along
    near = -math.inf if abs(center) <= half else math.inf  # of a ray along the slab
    zero, level = spread(0.0), greatest(along, spread(0.0) - along)
    low = choose(level, zero, spread(near), least(one, two))
    high = choose(level, zero, spread(-near), greatest(one, two))
    return greatest(enter, low), least(leave, high)


@inlined
def _round(square: Any, half: Any, rest: float) -> Any:
    """Parts of rays |c + x v| <= r: square = v v, half = v c, rest = c c - r r."""
    zero, far = spread(0.0), spread(math.inf)
    near = -math.inf if rest <= 0.0 else math.inf  # of a ray along a cylinder's axis
    inner = half * half - square * spread(rest)
    root = roots(inner)
    enter = choose(zero, inner, (zero - half - root) / square, far)
    leave = choose(zero, inner, (root - half) / square, zero - far)
    return choose(square, zero, spread(near), enter), choose(square, zero, spread(-near), leave)


@inlined
def _part(kind: int, c: Any, v: Any, size: Array) -> Any:
    """Distances at which rays c + x v enter and leave a shape, in its frame."""
    enter, leave = spread(-math.inf), spread(math.inf)
    if kind == col.BOX:
        enter, leave = _slab(c[0], v[0], size[0], enter, leave)
        enter, leave = _slab(c[1], v[1], size[1], enter, leave)
        enter, leave = _slab(c[2], v[2], size[2], enter, leave)
    else:
        square, half = v[0] * v[0] + v[1] * v[1], v[0] * spread(c[0]) + v[1] * spread(c[1])
        rest = c[0] * c[0] + c[1] * c[1] - size[0] * size[0]
        if kind == col.SPHERE:
            square, half = square + v[2] * v[2], half + v[2] * spread(c[2])
            enter, leave = _round(square, half, rest + c[2] * c[2])
        else:
            enter, leave = _round(square, half, rest)
            enter, leave = _slab(c[2], v[2], size[1], enter, leave)
    return enter, leave


@compiled
def _set_directions(at: int, x: Any, y: Any, z: Any, rays: Array) -> None:
    """Write directions and their inverse, finite."""
    zero, one, steep = spread(0.0), spread(1.0), spread(_STEEP)
    for k, v in enumerate((x, y, z)):
        store(rays, at + _RAYS * k, v)
        inverse = choose(greatest(v, zero - v), zero, steep, one / v)
        store(rays, at + 24 + _RAYS * k, inverse)


@compiled
def _enter(box: Array, c: Any, at: int, rays: Array) -> float:
    """Least distance at which one of eight rays enters a box (lower and upper corner), at least 0;
    inf: all miss it or are there beyond the farthest.

    Args:
        c: where they come from.
        at: place of their directions.
    """
    inverse = load_eight(rays, at + 24)
    one, two = spread(box[0] - c[0]) * inverse, spread(box[3] - c[0]) * inverse
    enter, leave = least(one, two), greatest(one, two)
    inverse = load_eight(rays, at + 32)
    one, two = spread(box[1] - c[1]) * inverse, spread(box[4] - c[1]) * inverse
    enter, leave = greatest(enter, least(one, two)), least(leave, greatest(one, two))
    inverse = load_eight(rays, at + 40)
    one, two = spread(box[2] - c[2]) * inverse, spread(box[5] - c[2]) * inverse
    enter, leave = greatest(enter, least(one, two)), least(leave, greatest(one, two))
    enter, leave = greatest(enter, spread(0.0)), least(leave, load_eight(rays, _FARTHEST))
    return lowest(choose(enter, leave, enter, spread(math.inf)))


@inlined
def _note(at: Any, start: float, rays: Array) -> None:
    """Note the distances at which rays hit something, where they are not before `start`, and the
    nearest yet; inf, or no number: not."""
    farthest, found = load_eight(rays, _FARTHEST), load_eight(rays, _HIT)
    at = choose(spread(start), at, at, spread(math.inf))
    store(rays, _HIT, choose(at, farthest, at, found))
    store(rays, _FARTHEST, choose(at, farthest, at, farthest))


@inlined
def _at_triangle(t: Array, c: Any, v: Any) -> Any:
    """Distances at which rays meet a triangle (a corner, two edges), from either side; inf: not.

    After Möller and Trumbore, "Fast, Minimum Storage Ray/Triangle Intersection" (1997).
    """
    x = v[1] * spread(t[8]) - v[2] * spread(t[7])
    y = v[2] * spread(t[6]) - v[0] * spread(t[8])
    z = v[0] * spread(t[7]) - v[1] * spread(t[6])
    volume = spread(t[3]) * x + spread(t[4]) * y + spread(t[5]) * z
    p, q, r = c[0] - t[0], c[1] - t[1], c[2] - t[2]
    one = (spread(p) * x + spread(q) * y + spread(r) * z) / volume  # no number if volume is 0
    a, b, d = q * t[5] - r * t[4], r * t[3] - p * t[5], p * t[4] - q * t[3]
    two = (v[0] * spread(a) + v[1] * spread(b) + v[2] * spread(d)) / volume
    at = spread(t[6] * a + t[7] * b + t[8] * d) / volume
    far, low, high = spread(math.inf), spread(-_SLACK), spread(1.0 + _SLACK)
    at = choose(low, one, choose(one, high, at, far), far)
    return choose(low, two, choose(one + two, high, at, far), far)


@inlined
def _next_leaf(
    node: int, waiting: int, first: int, tree: Any, stack: Any, c: Any, at: int, rays: Array
) -> Any:
    """The next leaf of a tree that one of the rays enters, the nearer of two branches before the
    other.

    Args:
        node: with which to go on; -1: with what waits.
        waiting, first: places of `todo` after the last node that waits, and of the first.
        tree: boxes and children of its nodes.
        stack: todo and entries.
        c, at: where the rays come from, and the place of their directions.

    Returns:
        (its number, -1: there is none any more; how far `todo` is filled).
    """
    (boxes, children), (todo, entries) = tree, stack
    inner = len(children)
    while True:
        while 0 <= node < inner:
            one, two = children[node, 0], children[node, 1]
            enter, other = _enter(boxes[one], c, at, rays), _enter(boxes[two], c, at, rays)
            if other < enter:
                one, two, enter, other = two, one, other, enter
            if other < math.inf:
                todo[waiting], entries[waiting] = two, other
                waiting += 1
            node = one if enter < math.inf else -1
        if node >= inner:
            return node - inner, waiting
        if waiting == first:
            return -1, waiting
        waiting -= 1
        if entries[waiting] <= highest(load_eight(rays, _FARTHEST)):
            node = todo[waiting]


@inlined
def _meet_mesh(root: int, c: Any, start: float, first: int, casting: Casting, rays: Array) -> None:
    """Note where rays meet triangles of a mesh.

    Args:
        first: place of `todo` that is free, and those after it.
    """
    nodes, stack = casting.nodes, (casting.todo, casting.entries)
    tree = nodes, casting.children
    node, waiting = root if _enter(nodes[root], c, _LOCAL, rays) < math.inf else -1, first
    while True:
        leaf, waiting = _next_leaf(node, waiting, first, tree, stack, c, _LOCAL, rays)
        if leaf < 0:
            break
        v = load_eight(rays, _LOCAL), load_eight(rays, _LOCAL + 8), load_eight(rays, _LOCAL + 16)
        _note(_at_triangle(casting.triangles[leaf], c, v), start, rays)
        node = -1


@inlined
def _meet_shape(s: int, start: float, waiting: int, casting: Casting, rays: Array) -> None:
    """Note where rays meet a shape but a plane."""
    f, c = casting.frames[s], casting.origins[s]
    u, v, w = load_eight(rays, 0), load_eight(rays, 8), load_eight(rays, 16)
    kind, origin = casting.kinds[s], (c[0], c[1], c[2])
    x = u * spread(f[0, 0]) + v * spread(f[1, 0]) + w * spread(f[2, 0])
    y = u * spread(f[0, 1]) + v * spread(f[1, 1]) + w * spread(f[2, 1])
    z = u * spread(f[0, 2]) + v * spread(f[1, 2]) + w * spread(f[2, 2])
    if kind == col.MESH:
        _set_directions(_LOCAL, x, y, z, rays)
        _meet_mesh(casting.roots[s], origin, start, waiting, casting, rays)
    else:
        enter, leave = _part(kind, origin, (x, y, z), casting.sizes[s])
        first = choose(spread(start), enter, enter, leave)  # from inside, as ODE's rays
        _note(choose(enter, leave, first, spread(math.inf)), start, rays)


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
def _meet_all(near: float, casting: Casting, rays: Array) -> None:
    """Note what rays hit first."""
    boxes, branches = casting.boxes, casting.branches
    tree, stack = (boxes, branches), (casting.todo, casting.entries)
    c = casting.center
    u, v, w = load_eight(rays, 0), load_eight(rays, 8), load_eight(rays, 16)
    for s in range(len(casting.extents), len(casting.kinds)):  # planes
        f = casting.frames[s]
        along = u * spread(f[0, 2]) + v * spread(f[1, 2]) + w * spread(f[2, 2])
        _note(spread(-casting.origins[s, 2]) / along, near, rays)
    if len(branches) == 0:
        return
    origin = c[0], c[1], c[2]
    node, waiting = 0 if _enter(boxes[0], origin, _WORLD, rays) < math.inf else -1, 0
    while True:
        leaf, waiting = _next_leaf(node, waiting, 0, tree, stack, origin, _WORLD, rays)
        if leaf < 0:
            break
        _meet_shape(leaf, near, waiting, casting, rays)
        node = -1


@compiled
def cast(near: float, far: float, casting: Casting) -> int:
    """Distances of what rays that begin at `near` hit first up to `far` [m], into casting.ranges;
    inf: nothing. What begins in a shape hits it from inside."""
    rays, directions, ranges = temporary(_SIZE), casting.directions, casting.ranges
    _place_shapes(casting)
    _fit(casting)
    for first in range(0, len(directions), _RAYS):
        for k in range(_RAYS):
            i = min(first + k, len(directions) - 1)
            for axis in range(3):
                rays[_RAYS * axis + k] = directions[i, axis]
            rays[_FARTHEST + k], rays[_HIT + k] = far, math.inf
        u, v, w = load_eight(rays, 0), load_eight(rays, 8), load_eight(rays, 16)
        _set_directions(_WORLD, u, v, w, rays)
        _meet_all(near, casting, rays)
        for i in range(first, min(first + _RAYS, len(directions))):
            ranges[i] = rays[_HIT + i - first]
    return 0
