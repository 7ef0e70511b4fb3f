"""Contacts of a mesh with a box, sphere or cylinder, as ODE finds them with OPCODE.

A mesh is a solid of the kind MESH: a frame (center and rotation) and the root of a tree, whose
triangles and boxes are in this frame, so that all that have the same file share one tree. The
triangles are in the order of OPCODE's tree: of more contacts than a pair may have the first count.
"""

import math

from bullet_sim.engine.quickstep import layout as col
from bullet_sim.engine.quickstep.boxes import relative
from bullet_sim.engine.quickstep.compiled import compiled, temporary
from bullet_sim.engine.quickstep.state import Trees
from bullet_sim.engine.quickstep.triangles import (
    box_on_triangle,
    cylinder_on_triangle,
    sphere_on_triangle,
)
from bullet_sim.engine.quickstep.vectors import copy, cross, dot
from bullet_sim.pose import Array

_SOLID = col.B_COLUMNS  # for temporary()


@compiled
def place_triangle(local: Array, mesh: Array, out: Array) -> None:
    """A triangle of a mesh in the world."""
    for i in range(3):
        for k in range(3):
            at = mesh[col.B_CENTER + k]
            for j in range(3):
                at += mesh[col.B_ROTATION + 3 * k + j] * local[3 * i + j]
            out[3 * i + k] = at


@compiled
def add_candidate(found: Array, n: int, point: Array, normal: Array, depth: float) -> int:
    """Append a contact; the number of all then."""
    if n < col.MAX_COLLIDE_RETURNS:
        for k in range(3):
            found[n, k], found[n, col.F_NORMAL + k] = point[k], normal[k]
        found[n, col.F_DEPTH], found[n, col.F_WEIGHT] = depth, 1.0
        n += 1
    return n


@compiled
def _add_unless_there(found: Array, n: int, point: Array, normal: Array, depth: float) -> int:
    """As add_candidate(), but what has the place and the direction of another makes that
    deeper."""
    is_new = True
    for i in range(n):
        distance = cosine = 0.0
        for k in range(3):
            gap = point[k] - found[i, k]
            distance += gap * gap
            cosine += normal[k] * found[i, col.F_NORMAL + k]
        if distance < col.EPSILON and 1.0 - abs(cosine) < col.EPSILON:
            found[i, col.F_DEPTH] = max(found[i, col.F_DEPTH], depth)
            is_new = False
    return add_candidate(found, n, point, normal, depth) if is_new else n


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
            mean += found[i, col.F_NORMAL + k] * found[i, col.F_DEPTH]
        found[0, k], found[1, col.F_NORMAL + k] = place / n, mean
        length += mean * mean
    found[0, col.F_DEPTH] = math.sqrt(length / n)
    if found[0, col.F_DEPTH] > col.EPSILON:
        for k in range(3):
            found[0, col.F_NORMAL + k] = found[1, col.F_NORMAL + k] / math.sqrt(length)
    return 1


@compiled
def keep_contacts(found: Array, n: int, merge: bool, most: int) -> int:
    """Keep `most` of n: the first ones, the last of them in favour of the deepest of the rest;
    their number.

    Args:
        merge: leave one, the deepest, of those at the same place and in the same direction.
    """
    for i in range(n):
        found[i, col.F_WEIGHT] = 1.0
    for i in range(n - 1 if merge else 0):
        for j in range(i + 1, n):
            same = True
            for k in range(6):
                if abs(found[i, k] - found[j, k]) >= col.SAME_CONTACT:
                    same = False
            if same:
                found[i if found[j, col.F_DEPTH] > found[i, col.F_DEPTH] else j, col.F_WEIGHT] = 0.0
    kept = 0
    for i in range(n):
        if found[i, col.F_WEIGHT] == 0.0:
            continue
        if kept < most:
            copy(found[i], found[kept])
            kept += 1
        elif kept > 0 and found[i, col.F_DEPTH] > found[kept - 1, col.F_DEPTH]:
            copy(found[i], found[kept - 1])
    return kept


@compiled
def box_in_frame(solid: Array, kind: int, mesh: Array, box: Array) -> None:
    """The box around a solid along the axes of a mesh's frame: center and half the edges."""
    frame = temporary(_SOLID)
    relative(mesh, solid, frame)
    for i in range(3):
        box[i], box[3 + i] = frame[col.B_CENTER + i], 0.0
        if kind == col.SPHERE:
            box[3 + i] = solid[col.B_HALF]
            continue
        for j in range(3):
            half = solid[col.B_HALF + j]
            if kind == col.CYLINDER:
                half = solid[col.B_HALF + (1 if j == 2 else 0)]
            box[3 + i] += abs(frame[col.B_ROTATION + 3 * i + j]) * half


@compiled
def _apart(box: Array, other: Array) -> bool:
    """Whether two boxes along the same axes, centers and half the edges, are apart."""
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
    mesh: Array, root: int, solid: Array, kind: int, trees: Trees, found: Array, most: int
) -> int:
    """Contacts of a mesh with a box, sphere or cylinder, normals towards the solid; their number.

    Of a sphere or cylinder a triangle counts only in front of it.

    Args:
        found: (MAX_COLLIDE_RETURNS, F_COLUMNS) gets them.
        most: of them are left.
    """
    box, corners, plane, normal = temporary(6), temporary(9), temporary(4), temporary(3)
    one, two, points, todo = temporary(3), temporary(3), temporary(16, 4), trees.todo[:, 0]
    box_in_frame(solid, kind, mesh, box)
    todo[0], waiting, n = root, 1, 0
    while waiting > 0:
        waiting -= 1
        node = todo[waiting]
        if node >= 0:
            if not _apart(trees.nodes[node], box):
                todo[waiting], todo[waiting + 1] = trees.children[node, 1], trees.children[node, 0]
                waiting += 2
            continue
        if node == col.NO_CHILD or _triangle_apart(trees.corners[-1 - node], box):
            continue
        place_triangle(trees.corners[-1 - node], mesh, corners)
        if kind == col.BOX:
            count = box_on_triangle(solid, corners, points, normal)
            for i in range(count):
                n = _add_unless_there(found, n, points[i, :3], normal, points[i, 3])
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
            height += plane[k] * solid[col.B_CENTER + k]
        if height - plane[3] < 0.0:
            continue
        if kind == col.SPHERE:
            count = sphere_on_triangle(solid, corners, plane, points, normal)
        else:
            count = cylinder_on_triangle(solid, corners, plane, points, normal)
        for i in range(count):
            n = add_candidate(found, n, points[i, :3], normal, points[i, 3])
    if kind == col.SPHERE:
        return min(_merge(found, n), most)
    return keep_contacts(found, n, kind == col.CYLINDER, most)
