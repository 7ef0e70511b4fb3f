"""Contacts of shapes with planes, as ODE finds them.

Functions of one kind of shape take the row of contacts from which they write, what touches, the
depth [m] of the shape's center below the plane, this center (3,) and the table; they give the
number of all contacts then.
"""

import math

from bullet_sim.engine.quickstep import layout as col
from bullet_sim.engine.quickstep.compiled import compiled, switch, temporary
from bullet_sim.engine.quickstep.contacts import (
    Pair,
    Table,
    add_contact,
    keep_most,
    most_contacts,
)
from bullet_sim.engine.quickstep.state import Scene
from bullet_sim.engine.quickstep.vectors import cross, rotate
from bullet_sim.pose import Array


@compiled
def _sphere_with_plane(n: int, pair: Pair, below: float, center: Array, table: Table) -> int:
    """Contact of a sphere: its lowest point."""
    radius, point = table.shapes[pair.shape, col.G_SIZE], temporary(3)
    depth = below + radius
    if depth < 0.0:
        return n
    for k in range(3):
        point[k] = center[k] - pair.surfaces[pair.surface, k] * radius
    add_contact(n, pair, point, depth, table)
    return n + 1


@compiled
def _mesh_with_plane(
    n: int, pair: Pair, below: float, scene: Scene, table: Table, returns: int
) -> int:
    """Contacts of the vertices of a mesh, whose center is its body's.

    The first ones below the plane; if there are more than the pair may have, the deepest of the
    rest in place of the last. Only the first `returns` count.
    """
    offset, at, local = temporary(3), temporary(3), temporary(3)
    found, seen, deepest, last = 0, 0, 0.0, n
    s, planes, p = pair.shape, pair.surfaces, pair.surface
    most = min(most_contacts(pair, table), len(table.rows) - n)
    turn = table.work[pair.body, col.W_R : col.W_R + 9]
    a, b, c = planes[p, 0], planes[p, 1], planes[p, 2]
    for k in range(3):  # the plane's normal in the body
        local[k] = turn[k] * a + turn[3 + k] * b + turn[6 + k] * c
    first, end = scene.kinds[s, 2], scene.kinds[s, 3]
    for start in range(first, end, col.CHUNK):
        box = scene.chunks[scene.kinds[s, 4] + (start - first) // col.CHUNK]
        highest = below + col.ROUNDING
        for k in range(3):
            highest += abs(local[k]) * box[3 + k] - local[k] * box[k]
        if not highest > 0.0:
            continue
        for v in range(start, min(start + col.CHUNK, end)):
            point = scene.points[v]
            depth = below - (local[0] * point[0] + local[1] * point[1] + local[2] * point[2])
            if depth < -col.ROUNDING:
                continue
            rotate(turn, point, offset)
            depth = below - (a * offset[0] + b * offset[1] + c * offset[2])
            if depth <= 0.0:
                continue
            seen += 1
            if seen > returns:
                return n
            if found >= most and (depth <= deepest or most <= 0):
                continue
            for k in range(3):
                at[k] = table.bodies[pair.body, col.POS + k] + offset[k]
            if found < most:
                last, found = n, found + 1
                n += 1
                deepest = depth
            deepest = max(deepest, depth)
            add_contact(last, pair, at, depth, table)
    return n


@compiled
def _box_with_plane(n: int, pair: Pair, below: float, center: Array, table: Table) -> int:
    """Contacts of a box: the deepest corner, its neighbors along the two sides that are the least
    inclined, and the corner opposite to it."""
    sides, edge, corner, point = temporary(3, 3), temporary(3), temporary(3), temporary(3)
    rise, shape = temporary(3), table.shapes[pair.shape]
    depth = below
    for k in range(3):
        corner[k] = center[k]
    for i in range(3):  # sides that point up from the deepest corner
        for k in range(3):
            edge[k] = shape[col.G_ROTATION + 3 * k + i]
        rotate(table.work[pair.body, col.W_R : col.W_R + 9], edge, sides[i])
        along = 0.0
        for k in range(3):
            along += pair.surfaces[pair.surface, k] * sides[i, k]
        size = shape[col.G_SIZE + i]
        rise[i] = abs(along) * size
        for k in range(3):
            sides[i, k] *= size if along > 0.0 else -size
            corner[k] -= 0.5 * sides[i, k]
        depth += 0.5 * rise[i]
    if depth < 0.0:
        return n
    order = (0, 1)
    if rise[0] < rise[1]:
        if rise[2] < rise[0]:
            order = (2, 0)
        elif rise[1] >= rise[2]:
            order = (0, 2)
    elif rise[2] < rise[1]:
        order = (2, 1)
    else:
        order = (1, 0 if rise[0] < rise[2] else 2)
    add_contact(n, pair, corner, depth, table)
    n += 1
    for i in range(2):
        if depth - rise[order[i]] < 0.0:
            return n
        for k in range(3):
            point[k] = corner[k] + sides[order[i], k]
        add_contact(n, pair, point, depth - rise[order[i]], table)
        n += 1
    depth -= rise[order[0]] + rise[order[1]]
    if depth > 0.0:
        for k in range(3):
            point[k] += sides[order[0], k]
        add_contact(n, pair, point, depth, table)
        n += 1
    return n


@compiled
def _lowest_line(
    shape: Array, center: Array, axis: Array, along: float, plane: Array, ends: Array
) -> None:
    """The line of a cylinder that is deepest below a plane.

    Args:
        shape: row of shapes.
        axis, along: of the cylinder, and the cosine between it and the plane's normal.
        ends: (2, 3) gets the line.
    """
    rim = temporary(3)
    for k in range(3):
        rim[k] = axis[k] * along - plane[k]
    length = math.sqrt(rim[0] ** 2 + rim[1] ** 2 + rim[2] ** 2)
    radius, half = shape[col.G_SIZE], 0.5 * shape[col.G_SIZE + 1]
    for k in range(3):
        ends[0, k] = center[k] + half * axis[k] + rim[k] * (radius / length)
        ends[1, k] = center[k] - half * axis[k] + rim[k] * (radius / length)


@compiled
def _disc_with_plane(
    n: int, pair: Pair, center: Array, axis: Array, along: float, table: Table
) -> int:
    """Contacts of a cylinder that stands: four points of the lower disc; arguments as those of
    _lowest_line()."""
    rim, other, point = temporary(3), temporary(3), temporary(3)
    shape, plane = table.shapes[pair.shape], pair.surfaces[pair.surface]
    a, b, c, d = plane[0], plane[1], plane[2], plane[3]
    radius, half = shape[col.G_SIZE], 0.5 * shape[col.G_SIZE + 1]
    sign = -1.0 if along > 0.0 else 1.0
    for k in range(3):
        point[k] = center[k] + sign * half * axis[k]
    if d - (a * point[0] + b * point[1] + c * point[2]) < 0.0:
        return n
    for k in range(3):
        other[k] = axis[k]
    other[0 if abs(axis[0]) < col.PARALLEL else 1] += 1.0
    cross(other, axis, rim)
    length = math.sqrt(rim[0] ** 2 + rim[1] ** 2 + rim[2] ** 2)
    for k in range(3):
        rim[k] *= radius / length
    cross(rim, axis, other)
    for corner in range(4):
        for k in range(3):
            reach = other[k] if corner < 2 else rim[k]
            reach = reach if corner % 2 == 0 else -reach
            point[k] = center[k] + sign * half * axis[k] + reach
        depth = d - (a * point[0] + b * point[1] + c * point[2])
        if depth > 0.0:
            add_contact(n, pair, point, depth, table)
            n += 1
    return n


@compiled
def _cylinder_with_plane(n: int, pair: Pair, _below: float, center: Array, table: Table) -> int:
    """Contacts of a cylinder: the lowest point of each rim, or four of the lower disc if it
    stands."""
    axis, ends = temporary(3), temporary(2, 3)
    shape, plane = table.shapes[pair.shape], pair.surfaces[pair.surface]
    for k in range(3):
        axis[k] = shape[col.G_ROTATION + 3 * k + 2]
    rotate(table.work[pair.body, col.W_R : col.W_R + 9], axis, axis)
    along = axis[0] * plane[0] + axis[1] * plane[1] + axis[2] * plane[2]
    if abs(abs(along) - 1.0) < col.PARALLEL:
        return _disc_with_plane(n, pair, center, axis, along, table)
    _lowest_line(shape, center, axis, along, plane, ends)
    for end in (1, 0):
        away = plane[0] * ends[end, 0] + plane[1] * ends[end, 1] + plane[2] * ends[end, 2]
        depth = plane[3] - away
        if depth >= 0.0:
            add_contact(n, pair, ends[end], depth, table)
            n += 1
    return n


_collide = switch(
    {
        col.CYLINDER: _cylinder_with_plane,
        col.BOX: _box_with_plane,
        col.SPHERE: _sphere_with_plane,
    }
)


@compiled
def points_with_plane(n: int, pair: Pair, scene: Scene, table: Table, returns: int) -> int:
    """As plane_contacts(), more than a pair may have where it is of no mesh; returns: vertices of a
    mesh that count."""
    kind, shape, plane = (
        scene.kinds[pair.shape, 1], table.shapes[pair.shape], pair.surfaces[pair.surface],
    )  # fmt: skip
    center = temporary(3)
    center[:] = 0.0
    if kind != col.MESH:
        turn = table.work[pair.body, col.W_R : col.W_R + 9]
        rotate(turn, shape[col.G_OFFSET : col.G_OFFSET + 3], center)
    below = plane[col.P_PLANE + 3]
    for k in range(3):
        center[k] += table.bodies[pair.body, col.POS + k]
        below -= plane[k] * center[k]
    if not below + table.bodies[pair.body, col.RADIUS] >= 0.0:
        return n
    if kind == col.MESH:  # the only one that has more than a row of shapes
        return _mesh_with_plane(n, pair, below, scene, table, returns)
    return _collide(kind, n, pair, below, center, table)


@compiled
def plane_contacts(n: int, pair: Pair, scene: Scene, table: Table) -> int:
    """Contacts of a shape of a body with a plane, from row n; the number of all then."""
    end = points_with_plane(n, pair, scene, table, col.MAX_COLLIDE_RETURNS)
    return keep_most(n, end, most_contacts(pair, table), table)
