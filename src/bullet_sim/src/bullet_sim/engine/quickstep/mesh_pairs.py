"""Contacts of two meshes, as ODE finds them with OPCODE."""

import math

from bullet_sim.engine.quickstep import layout as col
from bullet_sim.engine.quickstep.boxes import relative
from bullet_sim.engine.quickstep.compiled import compiled, temporary
from bullet_sim.engine.quickstep.meshes import add_candidate, keep_contacts, place_triangle
from bullet_sim.engine.quickstep.state import Trees
from bullet_sim.engine.quickstep.triangle_pairs import (
    triangle_meets_box,
    triangle_on_triangle,
    triangles_overlap,
)
from bullet_sim.engine.quickstep.vectors import copy
from bullet_sim.pose import Array

_SOLID = col.B_COLUMNS  # for temporary()
_CELLS = 1e4  # [1/m] in each of which contacts of two meshes are one
_AS_DEEP = 1e-5  # [m]
_LOOSE = 1e-6  # by which cosines between boxes of two trees count as larger
_SINGLE = 1e-6  # of a size, above what single precision rounds
# pairs of two trees; of the last two the triangle of the first, or of the second, was there first
_BOXES, _TRIANGLE_BOX, _BOX_TRIANGLE, _TRIANGLES, _TRIANGLES_OF_BOX = range(5)


@compiled
def _add_to_cell(found: Array, n: int, point: Array, normal: Array, depth: float) -> int:
    """As add_candidate(), but of several in one cell the deepest counts; equally deep ones have
    one normal."""
    for i in range(n):
        is_same = True
        for k in range(3):
            if math.floor(point[k] * _CELLS) != math.floor(found[i, k] * _CELLS):
                is_same = False
        if not is_same:
            continue
        if depth - found[i, col.F_DEPTH] > _AS_DEEP:
            for k in range(3):
                found[i, col.F_NORMAL + k] = normal[k]
            found[i, col.F_DEPTH], found[i, col.F_WEIGHT] = depth, 1.0
        elif depth - found[i, col.F_DEPTH] >= -_AS_DEEP:
            length = 0.0
            for k in range(3):
                found[i, col.F_NORMAL + k] = (
                    normal[k] + found[i, col.F_WEIGHT] * found[i, col.F_NORMAL + k]
                )
                length += found[i, col.F_NORMAL + k] ** 2
            length = math.sqrt(length)
            if length > 1e-7:
                for k in range(3):
                    found[i, col.F_NORMAL + k] /= length
                found[i, col.F_WEIGHT] = length
            else:
                copy(found[n - 1], found[i])
                n -= 1
        return n
    return add_candidate(found, n, point, normal, depth)


@compiled
def _boxes_overlap(a: Array, b: Array, f: Array, s: Array) -> bool:
    """Whether boxes of two trees overlap, as in Gottschalk et al., "OBBTree" (1996).

    Args:
        f: frame of the second in the first, a row of solids.
        s: (9,) absolute values of its rotation, a little larger.
    """
    r = col.B_ROTATION
    a0, a1, a2 = a[3], a[4], a[5]
    b0, b1, b2 = b[3], b[4], b[5]
    x, y, z = b[0], b[1], b[2]
    t0 = f[col.B_CENTER] - a[0] + f[r] * x + f[r + 1] * y + f[r + 2] * z
    if abs(t0) > a0 + b0 * s[0] + b1 * s[1] + b2 * s[2]:
        return False
    t1 = f[col.B_CENTER + 1] - a[1] + f[r + 3] * x + f[r + 4] * y + f[r + 5] * z
    if abs(t1) > a1 + b0 * s[3] + b1 * s[4] + b2 * s[5]:
        return False
    t2 = f[col.B_CENTER + 2] - a[2] + f[r + 6] * x + f[r + 7] * y + f[r + 8] * z
    if abs(t2) > a2 + b0 * s[6] + b1 * s[7] + b2 * s[8]:
        return False
    for j in range(3):
        b_j = b0 if j == 0 else b1 if j == 1 else b2
        along = t0 * f[r + j] + t1 * f[r + 3 + j] + t2 * f[r + 6 + j]
        if abs(along) > b_j + a0 * s[j] + a1 * s[3 + j] + a2 * s[6 + j]:
            return False
    for j in range(3):
        u, v = (1, 2) if j == 0 else (0, 2) if j == 1 else (0, 1)
        b_u, b_v = (b1, b2) if j == 0 else (b0, b2) if j == 1 else (b0, b1)
        r0, r1, r2 = f[r + j], f[r + 3 + j], f[r + 6 + j]
        s0, s1, s2 = s[j], s[3 + j], s[6 + j]
        if abs(t2 * r1 - t1 * r2) > a1 * s2 + a2 * s1 + b_u * s[v] + b_v * s[u]:
            return False
        if abs(t0 * r2 - t2 * r0) > a2 * s0 + a0 * s2 + b_u * s[3 + v] + b_v * s[3 + u]:
            return False
        if abs(t1 * r0 - t0 * r1) > a0 * s1 + a1 * s0 + b_u * s[6 + v] + b_v * s[6 + u]:
            return False
    return True


@compiled
def _spread_of(frame: Array, out: Array) -> None:
    """What _boxes_overlap() takes as s."""
    for i in range(9):
        out[i] = abs(frame[col.B_ROTATION + i]) + _LOOSE


@compiled
def _grow(box: Array, slack: float, out: Array) -> None:
    """A box of a tree with larger edges."""
    for k in range(3):
        out[k], out[3 + k] = box[k], box[3 + k] + slack


@compiled
def _mark_path(number: int, side: int, trees: Trees) -> None:
    """Mark a triangle, as in trees.children, and all boxes that it is in."""
    row, call = number + len(trees.corners), trees.calls[0]
    while row >= 0 and trees.marks[row, side] != call:
        trees.marks[row, side] = call
        row = trees.parents[row]


@compiled
def _boxes_of_triangles(root: int, large: Array, f: Array, s: Array, trees: Trees) -> int:
    """List boxes of a tree that have triangles of their own and overlap another box, into
    trees.near; their number, or -1: they are more than it has room for."""
    count, waiting, todo = 0, 1, trees.todo[:, 0]
    todo[0] = root
    while waiting > 0:
        waiting -= 1
        i, has_triangle = todo[waiting], False
        if not _boxes_overlap(trees.nodes[i], large, f, s):
            continue
        for p in range(2):
            child = trees.children[i, p]
            if child >= 0:
                todo[waiting] = child
                waiting += 1
            elif child != col.NO_CHILD:
                has_triangle = True
        if has_triangle:
            if count == len(trees.near):
                return -1
            trees.near[count] = i
            count += 1
    return count


@compiled
def _mark_cut(
    t: Array, box: Array, root: int, side: int, f: Array, s: Array, slack: float, trees: Trees
) -> bool:
    """Mark triangles of a tree that the plane of another's triangle may cut; whether there are any.

    Args:
        t: the triangle, in the tree's frame.
        box: around it, in the frame of the other tree.
        side: 0 or 1: which of both the tree is.
    """
    u, v, w = t[3] - t[0], t[4] - t[1], t[5] - t[2]
    p, q, r = t[6] - t[0], t[7] - t[1], t[8] - t[2]
    x, y, z = v * r - w * q, w * p - u * r, u * q - v * p
    at = x * t[0] + y * t[1] + z * t[2]
    near = (abs(x) + abs(y) + abs(z)) * slack + 2.0 * col.COPLANAR
    waiting, todo, cut = 1, trees.todo[:, 0], False
    todo[0] = root
    while waiting > 0:
        waiting -= 1
        j = todo[waiting]
        node = trees.nodes[j]
        reach = abs(x) * node[3] + abs(y) * node[4] + abs(z) * node[5] + near
        if abs(x * node[0] + y * node[1] + z * node[2] - at) > reach:
            continue
        if not _boxes_overlap(box, node, f, s):
            continue
        for k in range(2):
            child = trees.children[j, k]
            if child >= 0:
                todo[waiting] = child
                waiting += 1
            elif child != col.NO_CHILD:
                c = trees.corners[-1 - child]
                d0 = x * c[0] + y * c[1] + z * c[2] - at
                d1 = x * c[3] + y * c[4] + z * c[5] - at
                d2 = x * c[6] + y * c[7] + z * c[8] - at
                if min(d0, d1, d2) <= near and max(d0, d1, d2) >= -near:
                    _mark_path(child, side, trees)
                    cut = True
    return cut


@compiled
def _mark(root: int, other: int, side: int, f: Array, g: Array, trees: Trees) -> bool:
    """Mark in two trees at least all that leads to triangles that overlap, if the first has few
    triangles near the second; whether it has.

    Between large triangles and a finer mesh boxes tell little, and planes much.

    Args:
        side: 0 or 1: which of both trees `root` is of.
        f, g: the frames of the second in the first, and the other way round.
    """
    spread, box, t, size = temporary(9), temporary(6), temporary(9), 0.0
    _spread_of(f, spread)
    for k in range(3):
        for around in (trees.nodes[root], trees.nodes[other]):
            size = max(size, abs(around[k]) + around[3 + k])
    slack = _SINGLE * size
    _grow(trees.nodes[other], slack, box)
    count = _boxes_of_triangles(root, box, f, spread, trees)
    for at in range(count):
        i = trees.near[at]
        _grow(trees.nodes[i], slack, box)
        for p in range(2):
            child = trees.children[i, p]
            if child < 0 and child != col.NO_CHILD:
                place_triangle(trees.corners[-1 - child], g, t)
                if _mark_cut(t, box, other, 1 - side, f, spread, slack, trees):
                    _mark_path(child, side, trees)
    return count >= 0


@compiled
def mesh_with_mesh(
    one: Array, root: int, two: Array, other: int, trees: Trees, found: Array, most: int
) -> int:
    """Contacts of two meshes, as mesh_with_solid(); normals towards the first.

    Args:
        root, other: of their trees.
    """
    forth, back = temporary(_SOLID), temporary(_SOLID)  # of the second in the first
    normal, spread, polygons = temporary(3), temporary(9), temporary(6, 9, 3)
    a, b, leaf, work = temporary(9), temporary(9), temporary(9), temporary(4, 6)
    nodes, children, todo = trees.nodes, trees.children, trees.todo
    relative(one, two, forth)
    relative(two, one, back)
    _spread_of(forth, spread)
    trees.calls[0] += 1
    call, row, marks = trees.calls[0], len(trees.corners), trees.marks
    few = _mark(root, other, 0, forth, back, trees) or _mark(other, root, 1, back, forth, trees)
    todo[0, 0], todo[0, 1], todo[0, 2] = _BOXES, root, other
    waiting, n, held = 1, 0, 0  # held: triangle in the frame of the other mesh, and of which it is
    while waiting > 0:
        waiting -= 1
        kind, i, j = todo[waiting, 0], todo[waiting, 1], todo[waiting, 2]
        if kind == _BOXES:
            if not _boxes_overlap(nodes[i], nodes[j], forth, spread):
                continue
        elif kind == _TRIANGLE_BOX or kind == _TRIANGLES:
            if held != 2 * i:
                place_triangle(trees.corners[-1 - i], back, leaf)
                held = 2 * i
        elif held != 2 * j + 1:
            place_triangle(trees.corners[-1 - j], forth, leaf)
            held = 2 * j + 1
        if kind == _TRIANGLES or kind == _TRIANGLES_OF_BOX:
            unmoved = j if kind == _TRIANGLES else i  # it is in its own frame
            if triangles_overlap(leaf, trees.corners[-1 - unmoved], work):
                place_triangle(trees.corners[-1 - i], one, a)
                place_triangle(trees.corners[-1 - j], two, b)
                count, depth, place = triangle_on_triangle(a, b, normal, polygons)
                for k in range(count):
                    n = _add_to_cell(found, n, polygons[place, k], normal, depth)
            continue
        if kind == _TRIANGLE_BOX and not triangle_meets_box(leaf, nodes, j):
            continue
        if kind == _BOX_TRIANGLE and not triangle_meets_box(leaf, nodes, i):
            continue
        for p in range(1 if i >= 0 else 0, -1, -1):  # the last is the first that is looked at
            first = children[i, p] if i >= 0 else i
            if few and first != col.NO_CHILD and marks[row + first, 0] != call:
                continue
            for q in range(1 if j >= 0 else 0, -1, -1):
                second = children[j, q] if j >= 0 else j
                if first == col.NO_CHILD or second == col.NO_CHILD:
                    continue
                if few and marks[row + second, 1] != call:
                    continue
                if first >= 0:
                    next_ = _BOXES if second >= 0 else _BOX_TRIANGLE
                elif second >= 0:
                    next_ = _TRIANGLE_BOX
                else:
                    next_ = _TRIANGLES_OF_BOX if kind == _BOX_TRIANGLE else _TRIANGLES
                todo[waiting, 0], todo[waiting, 1], todo[waiting, 2] = next_, first, second
                waiting += 1
    return keep_contacts(found, n, False, most)
