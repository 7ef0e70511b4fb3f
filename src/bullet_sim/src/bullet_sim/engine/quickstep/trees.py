"""Contacts of meshes, which are trees of boxes around triangles, as ODE finds them with OPCODE.

A mesh is a solid of the kind MESH: a frame (centre and rotation) and the root of a tree, whose
triangles and boxes are in this frame, so that all that have the same file share one tree. The
triangles are in the order of OPCODE's tree: of more contacts than a pair may have the first count.
"""

import math

import numpy as np

from bullet_sim.engine.quickstep.compiled import compiled
from bullet_sim.engine.quickstep.layout import (
    B_CENTRE,
    B_COLUMNS,
    B_HALF,
    B_ROTATION,
    BOX,
    CYLINDER,
    EPSILON,
    F_DEPTH,
    F_NORMAL,
    F_WEIGHT,
    MESH_CONTACTS,
    MOST_FOUND,
    NO_CHILD,
    SAME,
    SPHERE,
    Trees,
)
from bullet_sim.engine.quickstep.triangles import (
    box_on_triangle,
    cylinder_on_triangle,
    sphere_on_triangle,
    triangle_meets_box,
    triangle_on_triangle,
    triangles_overlap,
)
from bullet_sim.engine.quickstep.vectors import cross, dot
from bullet_sim.pose import Array

_CELLS = 1e4  # [1/m] in each of which contacts of two meshes are one
_AS_DEEP = 1e-5  # [m]
_LOOSE = 1e-6  # by which cosines between boxes of two trees count as larger
_BOXES, _TRIANGLE_BOX, _BOX_TRIANGLE, _TRIANGLES = range(4)  # pairs of two trees


@compiled
def _split(corners: Array, order: Array, start: int, end: int) -> int:
    """Put triangles beyond the middle of their corners, along the axis on which they are spread
    most, first; their number. All in single precision, as in OPCODE."""
    count = end - start
    third, one = np.float32(1.0) / np.float32(3.0), np.float32(1.0)
    mean, spread = np.zeros(3, np.float32), np.zeros(3, np.float32)
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
    middle = np.zeros(1, np.float32)
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
def build_tree(corners: Array, order: Array, nodes: Array, children: Array) -> int:
    """Build the tree of triangles (n, 3, 3), single precision [m]; how deep it is.

    Args:
        order: (n,) gets the numbers of the triangles in the tree's order.
        nodes: (max(1, n - 1), 6) get boxes: centre and half the edges [m].
        children: (max(1, n - 1), 2) get the numbers of nodes, or -1 - the place of a triangle in
            the order; NO_CHILD: none.
    """
    count, made, deepest = len(corners), 0, 1
    todo = np.empty((count + 1, 5), np.int64)  # start, end, parent, which child, depth
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
            children[node, 0], children[node, 1] = -1 - start, NO_CHILD
            continue
        first = start + _split(corners, order, start, end)
        _push(todo, waiting, first, end, node, 1, depth + 1)
        _push(todo, waiting + 1, start, first, node, 0, depth + 1)
        waiting += 2
    return deepest


@compiled
def _place_triangle(local: Array, mesh: Array, out: Array) -> None:
    """A triangle of a mesh in the world."""
    for i in range(3):
        for k in range(3):
            at = mesh[B_CENTRE + k]
            for j in range(3):
                at += mesh[B_ROTATION + 3 * k + j] * local[3 * i + j]
            out[3 * i + k] = at


@compiled
def _note(found: Array, n: int, point: Array, normal: Array, depth: float) -> int:
    """Append a contact; the number of all then."""
    if n < MOST_FOUND:
        for k in range(3):
            found[n, k], found[n, F_NORMAL + k] = point[k], normal[k]
        found[n, F_DEPTH], found[n, F_WEIGHT] = depth, 1.0
        n += 1
    return n


@compiled
def _note_of_box(found: Array, n: int, point: Array, normal: Array, depth: float) -> int:
    """As _note(), but one that has the place and the direction of another makes that deeper."""
    is_new = True
    for i in range(n):
        distance = cosine = 0.0
        for k in range(3):
            gap = point[k] - found[i, k]
            distance += gap * gap
            cosine += normal[k] * found[i, F_NORMAL + k]
        if distance < EPSILON and 1.0 - abs(cosine) < EPSILON:
            found[i, F_DEPTH] = max(found[i, F_DEPTH], depth)
            is_new = False
    return _note(found, n, point, normal, depth) if is_new else n


@compiled
def _note_of_mesh(found: Array, n: int, point: Array, normal: Array, depth: float) -> int:
    """As _note(), but of several in one cell the deepest counts; equal ones have one normal."""
    for i in range(n):
        is_same = True
        for k in range(3):
            if math.floor(point[k] * _CELLS) != math.floor(found[i, k] * _CELLS):
                is_same = False
        if not is_same:
            continue
        if depth - found[i, F_DEPTH] > _AS_DEEP:
            for k in range(3):
                found[i, F_NORMAL + k] = normal[k]
            found[i, F_DEPTH], found[i, F_WEIGHT] = depth, 1.0
        elif depth - found[i, F_DEPTH] >= -_AS_DEEP:
            length = 0.0
            for k in range(3):
                found[i, F_NORMAL + k] = normal[k] + found[i, F_WEIGHT] * found[i, F_NORMAL + k]
                length += found[i, F_NORMAL + k] ** 2
            length = math.sqrt(length)
            if length > 1e-7:
                for k in range(3):
                    found[i, F_NORMAL + k] /= length
                found[i, F_WEIGHT] = length
            else:
                found[i] = found[n - 1]
                n -= 1
        return n
    return _note(found, n, point, normal, depth)


@compiled
def _merge(found: Array, n: int) -> int:
    """Leave one contact of a sphere: at the mean place, the normals weighted with the depths, and
    deeper than each of them, as ODE has it; the number of contacts."""
    if n < 2:
        return n
    length = 0.0
    for k in range(3):
        place, mean = 0.0, 0.0
        for i in range(n):
            place += found[i, k]
            mean += found[i, F_NORMAL + k] * found[i, F_DEPTH]
        found[0, k], found[1, F_NORMAL + k] = place / n, mean
        length += mean * mean
    found[0, F_DEPTH] = math.sqrt(length / n)
    if found[0, F_DEPTH] > EPSILON:
        for k in range(3):
            found[0, F_NORMAL + k] = found[1, F_NORMAL + k] / math.sqrt(length)
    return 1


@compiled
def _leave_most(found: Array, n: int, merge: bool) -> int:
    """Leave MESH_CONTACTS: the first ones, the last of them in favour of the deepest of the rest;
    their number.

    Args:
        merge: leave one, the deepest, of those at the same place and in the same direction.
    """
    hidden = np.zeros(n, np.bool_)
    for i in range(n - 1 if merge else 0):
        for j in range(i + 1, n):
            same = True
            for k in range(6):
                if abs(found[i, k] - found[j, k]) >= SAME:
                    same = False
            if same:
                hidden[i if found[j, F_DEPTH] > found[i, F_DEPTH] else j] = True
    kept = 0
    for i in range(n):
        if hidden[i]:
            continue
        if kept < MESH_CONTACTS:
            found[kept] = found[i]
            kept += 1
        elif found[i, F_DEPTH] > found[kept - 1, F_DEPTH]:
            found[kept - 1] = found[i]
    return kept


@compiled
def _box_in_frame(solid: Array, kind: int, mesh: Array, box: Array) -> None:
    """The box around a solid along the axes of a mesh's frame: centre and half the edges."""
    for i in range(3):
        box[i] = 0.0
        for k in range(3):
            away = solid[B_CENTRE + k] - mesh[B_CENTRE + k]
            box[i] += mesh[B_ROTATION + 3 * k + i] * away
        if kind == SPHERE:
            box[3 + i] = solid[B_HALF]
            continue
        box[3 + i] = 0.0
        for j in range(3):
            cosine = 0.0
            for k in range(3):
                cosine += mesh[B_ROTATION + 3 * k + i] * solid[B_ROTATION + 3 * k + j]
            half = solid[B_HALF + j]
            if kind == CYLINDER:
                half = solid[B_HALF + (1 if j == 2 else 0)]
            box[3 + i] += abs(cosine) * half


@compiled
def _apart(box: Array, other: Array) -> bool:
    """Whether two boxes along the same axes, centres and half the edges, are apart."""
    for k in range(3):
        if abs(box[k] - other[k]) > box[3 + k] + other[3 + k]:
            return True
    return False


@compiled
def _triangle_apart(corners: Array, box: Array) -> bool:
    """Whether the box around a triangle and another one are apart."""
    for k in range(3):
        low = min(corners[k], corners[3 + k], corners[6 + k])
        high = max(corners[k], corners[3 + k], corners[6 + k])
        if low > box[k] + box[3 + k] or high < box[k] - box[3 + k]:
            return True
    return False


@compiled
def mesh_with_solid(
    mesh: Array, root: int, solid: Array, kind: int, trees: Trees, found: Array
) -> int:
    """Contacts of a mesh with a box, sphere or cylinder: `found` (MOST_FOUND, F_COLUMNS), normals
    towards the solid; their number.

    Of a sphere or cylinder a triangle counts only in front of it.
    """
    box, corners, plane, normal = np.empty(6), np.empty(9), np.empty(4), np.empty(3)
    one, two, points = np.empty(3), np.empty(3), np.empty((16, 4))
    todo = np.empty(trees.depth[0] + 2, np.int64)
    _box_in_frame(solid, kind, mesh, box)
    todo[0], waiting, n = root, 1, 0
    while waiting > 0:
        waiting -= 1
        node = todo[waiting]
        if node >= 0:
            if not _apart(trees.nodes[node], box):
                todo[waiting], todo[waiting + 1] = trees.children[node, 1], trees.children[node, 0]
                waiting += 2
            continue
        if node == NO_CHILD or _triangle_apart(trees.corners[-1 - node], box):
            continue
        _place_triangle(trees.corners[-1 - node], mesh, corners)
        if kind == BOX:
            count = box_on_triangle(solid, corners, points, normal)
            for i in range(count):
                n = _note_of_box(found, n, points[i, :3], normal, points[i, 3])
            continue
        for k in range(3):
            one[k], two[k] = corners[3 + k] - corners[k], corners[6 + k] - corners[k]
        cross(one, two, plane)
        length = math.sqrt(dot(plane, plane))
        if length < 1e-12:
            continue
        height = plane[3] = 0.0
        for k in range(3):
            plane[k] /= length
            plane[3] += plane[k] * corners[k]
            height += plane[k] * solid[B_CENTRE + k]
        if height - plane[3] < 0.0:
            continue
        if kind == SPHERE:
            count = sphere_on_triangle(solid, corners, plane, points, normal)
        else:
            count = cylinder_on_triangle(solid, corners, plane, points, normal)
        for i in range(count):
            n = _note(found, n, points[i, :3], normal, points[i, 3])
    if kind == SPHERE:
        return _merge(found, n)
    return _leave_most(found, n, kind == CYLINDER)


@compiled
def _relative(one: Array, two: Array, out: Array) -> None:
    """The frame of a second solid in that of a first, as a row of solids."""
    for i in range(3):
        out[B_CENTRE + i] = 0.0
        for k in range(3):
            away = two[B_CENTRE + k] - one[B_CENTRE + k]
            out[B_CENTRE + i] += one[B_ROTATION + 3 * k + i] * away
        for j in range(3):
            cosine = 0.0
            for k in range(3):
                cosine += one[B_ROTATION + 3 * k + i] * two[B_ROTATION + 3 * k + j]
            out[B_ROTATION + 3 * i + j] = cosine


@compiled
def _boxes_overlap(a: Array, b: Array, frame: Array, spread: Array) -> bool:
    """Whether boxes of two trees overlap, as in Gottschalk et al., "OBBTree" (1996).

    Args:
        frame: of the second in the first.
        spread: (3, 3) absolute values of its rotation, a little larger.
    """
    r, gap = frame[B_ROTATION : B_ROTATION + 9], np.empty(3)
    for i in range(3):
        gap[i] = frame[B_CENTRE + i] - a[i]
        reach = a[3 + i]
        for j in range(3):
            gap[i] += r[3 * i + j] * b[j]
            reach += spread[i, j] * b[3 + j]
        if abs(gap[i]) > reach:
            return False
    for j in range(3):
        along, reach = 0.0, b[3 + j]
        for i in range(3):
            along += gap[i] * r[3 * i + j]
            reach += a[3 + i] * spread[i, j]
        if abs(along) > reach:
            return False
    for i in range(3):
        i1, i2 = (i + 1) % 3, (i + 2) % 3
        for j in range(3):
            j1, j2 = (j + 1) % 3, (j + 2) % 3
            reach = a[3 + i1] * spread[i2, j] + a[3 + i2] * spread[i1, j]
            reach += b[3 + j1] * spread[i, j2] + b[3 + j2] * spread[i, j1]
            if abs(gap[i2] * r[3 * i1 + j] - gap[i1] * r[3 * i2 + j]) > reach:
                return False
    return True


@compiled
def mesh_with_mesh(
    one: Array, root: int, two: Array, other: int, trees: Trees, found: Array
) -> int:
    """Contacts of two meshes, as mesh_with_solid(); normals towards the first.

    Args:
        root, other: of their trees.
    """
    forth, back = np.empty(B_COLUMNS), np.empty(B_COLUMNS)  # of the second in the first
    points, normal, spread = np.empty((9, 3)), np.empty(3), np.empty((3, 3))
    a, b, leaf = np.empty(9), np.empty(9), np.empty(9)
    _relative(one, two, forth)
    _relative(two, one, back)
    for i in range(3):
        for j in range(3):
            spread[i, j] = abs(forth[B_ROTATION + 3 * i + j]) + _LOOSE
    todo = np.empty((4 * trees.depth[0] + 8, 3), np.int64)
    todo[0, 0], todo[0, 1], todo[0, 2] = _BOXES, root, other
    waiting, n = 1, 0
    while waiting > 0:
        waiting -= 1
        kind, i, j = todo[waiting, 0], todo[waiting, 1], todo[waiting, 2]
        if kind == _TRIANGLES:
            _place_triangle(trees.corners[-1 - i], one, a)
            _place_triangle(trees.corners[-1 - j], two, b)
            if not triangles_overlap(a, b):
                continue
            count, depth = triangle_on_triangle(a, b, points, normal)
            for k in range(count):
                n = _note_of_mesh(found, n, points[k], normal, depth)
            continue
        if kind == _BOXES:
            if not _boxes_overlap(trees.nodes[i], trees.nodes[j], forth, spread):
                continue
        elif kind == _TRIANGLE_BOX:
            _place_triangle(trees.corners[-1 - i], back, leaf)
            if not triangle_meets_box(leaf, trees.nodes[j]):
                continue
        else:
            _place_triangle(trees.corners[-1 - j], forth, leaf)
            if not triangle_meets_box(leaf, trees.nodes[i]):
                continue
        for p in range(1 if i >= 0 else 0, -1, -1):  # the last is the first that is looked at
            first = trees.children[i, p] if i >= 0 else i
            for q in range(1 if j >= 0 else 0, -1, -1):
                second = trees.children[j, q] if j >= 0 else j
                if first == NO_CHILD or second == NO_CHILD:
                    continue
                todo[waiting, 0] = (
                    (_BOXES if second >= 0 else _BOX_TRIANGLE)
                    if first >= 0
                    else (_TRIANGLE_BOX if second >= 0 else _TRIANGLES)
                )
                todo[waiting, 1], todo[waiting, 2] = first, second
                waiting += 1
    return _leave_most(found, n, False)
