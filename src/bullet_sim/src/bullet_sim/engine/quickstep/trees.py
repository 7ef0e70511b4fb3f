"""Trees of boxes around the triangles of a mesh, in the order of OPCODE's."""

import numpy as np

from bullet_sim.engine.quickstep import layout as col
from bullet_sim.engine.quickstep.compiled import compiled
from bullet_sim.engine.quickstep.state import Building
from bullet_sim.pose import Array


@compiled
def _split(corners: Array, order: Array, start: int, end: int, means: Array) -> int:
    """Put triangles beyond the middle of their corners, along the axis on which they are spread
    most, first; their number. All in single precision, as in OPCODE; means: (7,) to work with."""
    count = end - start
    third, one = np.float32(1.0) / np.float32(3.0), np.float32(1.0)
    means[:] = np.float32(0.0)
    mean, spread, middle = means[:3], means[3:6], means[6:]
    for k in range(3):
        for i in range(start, end):
            t = corners[order[i]]
            mean[k] += (t[0, k] + t[1, k] + t[2, k]) * third
        mean[k] *= one / np.float32(count)
        for i in range(start, end):
            t = corners[order[i]]
            gap = (t[0, k] + t[1, k] + t[2, k]) * third - mean[k]
            spread[k] += gap * gap
        spread[k] *= one / np.float32(count - 1)
    axis = 0
    if spread[1] > spread[0]:
        axis = 1
    if spread[2] > spread[axis]:
        axis = 2
    for i in range(start, end):
        t = corners[order[i]]
        middle[0] += t[0, axis]
        middle[0] += t[1, axis]
        middle[0] += t[2, axis]
    middle[0] /= np.float32(3 * count)
    n = start
    for i in range(start, end):
        t = corners[order[i]]
        if (t[0, axis] + t[1, axis] + t[2, axis]) * third > middle[0]:
            order[i], order[n] = order[n], order[i]
            n += 1
    return n - start if start < n < end else count // 2


@compiled
def _push(todo: Array, at: int, start: int, end: int, parent: int, which: int, depth: int) -> None:
    todo[at, 0], todo[at, 1], todo[at, 2], todo[at, 3], todo[at, 4] = (
        start, end, parent, which, depth
    )  # fmt: skip


@compiled
def build_tree(building: Building) -> int:
    """Build the tree of triangles; how deep it is."""
    corners, order, nodes, children, todo, means = building
    count, made, deepest = len(corners), 0, 1
    for i in range(count):
        order[i] = i
    _push(todo, 0, 0, count, -1, 0, 1)
    waiting = 1
    while waiting > 0:
        waiting -= 1
        start, end, depth = todo[waiting, 0], todo[waiting, 1], todo[waiting, 4]
        parent, which = todo[waiting, 2], todo[waiting, 3]
        if end - start == 1 and parent >= 0:
            children[parent, which] = -1 - start
            continue
        deepest = max(deepest, depth)
        node, made = made, made + 1
        if parent >= 0:
            children[parent, which] = node
        for k in range(3):
            low, high = np.float32(np.inf), np.float32(-np.inf)
            for i in range(start, end):
                for j in range(3):
                    low = min(low, corners[order[i], j, k])
                    high = max(high, corners[order[i], j, k])
            nodes[node, k] = (high + low) * np.float32(0.5)
            nodes[node, 3 + k] = (high - low) * np.float32(0.5)
        if end - start == 1:
            children[node, 0], children[node, 1] = -1 - start, col.NO_CHILD
            continue
        first = start + _split(corners, order, start, end, means)
        _push(todo, waiting, first, end, node, 1, depth + 1)
        _push(todo, waiting + 1, start, first, node, 0, depth + 1)
        waiting += 2
    return deepest
