"""Contacts of two cylinders by Minkowski portal refinement (MPR), for which ODE calls libccd.

Source: G. Snethen, "XenoCollide" (Game Programming Gems 7, 2008); the tolerances are libccd's.
"""

import math

from bullet_sim.engine.quickstep import layout as col
from bullet_sim.engine.quickstep.compiled import compiled, temporary
from bullet_sim.engine.quickstep.vectors import closest, copy, cross, dot, normalize
from bullet_sim.pose import Array


@compiled
def _support(one: Array, two: Array, direction: Array, vertex: Array) -> None:
    """The farthest point of the Minkowski difference of two cylinders along a direction.

    Args:
        vertex: (9,) gets it, and the points of both cylinders that it is the difference of.
    """
    local = temporary(3)
    for i in range(2):
        body, sign = (one, 1.0) if i == 0 else (two, -1.0)
        for j in range(3):
            local[j] = 0.0
            for k in range(3):
                local[j] += sign * direction[k] * body[col.B_ROTATION + 3 * k + j]
        flat = math.sqrt(local[0] * local[0] + local[1] * local[1])
        scale = 0.0 if flat < col.EPSILON else body[col.B_HALF] / flat
        x, y = scale * local[0], scale * local[1]
        z = 0.0 if abs(local[2]) < col.EPSILON else body[col.B_HALF + 1]
        z = -z if local[2] < 0.0 else z
        for k in range(3):
            row = col.B_ROTATION + 3 * k
            vertex[3 + 3 * i + k] = body[col.B_CENTER + k]
            vertex[3 + 3 * i + k] += body[row] * x + body[row + 1] * y + body[row + 2] * z
    for k in range(3):
        vertex[k] = vertex[3 + k] - vertex[6 + k]


@compiled
def _portal_direction(portal: Array, direction: Array) -> None:
    """Unit vector across the portal's face, away from its inner point."""
    first, second = temporary(3), temporary(3)
    for k in range(3):
        first[k] = portal[2, k] - portal[1, k]
        second[k] = portal[3, k] - portal[1, k]
    cross(first, second, direction)
    normalize(direction)


@compiled
def _expand_portal(portal: Array, vertex: Array) -> None:
    """Replace that corner of the portal's face behind which the ray to the origin does not pass."""
    across = temporary(3)
    cross(vertex[:3], portal[0, :3], across)
    if dot(portal[1], across) > 0.0:
        place = 1 if dot(portal[2], across) > 0.0 else 3
    else:
        place = 2 if dot(portal[3], across) > 0.0 else 1
    copy(vertex, portal[place])


@compiled
def _is_at_surface(portal: Array, vertex: Array, direction: Array) -> bool:
    """Whether a farther point along a direction is not farther than the portal's face."""
    nearest = col.INFINITE
    for i in range(1, 4):
        nearest = min(nearest, dot(vertex, direction) - dot(portal[i], direction))
    return nearest <= col.MPR_TOLERANCE


@compiled
def _find_portal(one: Array, two: Array, portal: Array) -> int:
    """A tetrahedron in the Minkowski difference of two cylinders, from its inner point (row 0)
    with a face that the ray to the origin passes.

    Returns:
        0; 1: the origin is on the line from the inner point to row 1; -1: they are apart.
    """
    direction, first, second = temporary(3), temporary(3), temporary(3)
    for k in range(3):
        portal[0, 3 + k], portal[0, 6 + k] = one[col.B_CENTER + k], two[col.B_CENTER + k]
        portal[0, k] = one[col.B_CENTER + k] - two[col.B_CENTER + k]
    if abs(portal[0, 0]) + abs(portal[0, 1]) + abs(portal[0, 2]) < col.EPSILON:
        portal[0, 0] += 10.0 * col.EPSILON
    for k in range(3):
        direction[k] = -portal[0, k]
    normalize(direction)
    _support(one, two, direction, portal[1])
    if dot(portal[1], direction) < col.EPSILON:
        return -1
    cross(portal[0, :3], portal[1, :3], direction)
    if dot(direction, direction) < col.EPSILON:
        return 1
    normalize(direction)
    _support(one, two, direction, portal[2])
    if dot(portal[2], direction) < col.EPSILON:
        return -1
    for k in range(3):
        first[k], second[k] = portal[1, k] - portal[0, k], portal[2, k] - portal[0, k]
    cross(first, second, direction)
    normalize(direction)
    if dot(direction, portal[0]) > 0.0:
        for k in range(9):
            portal[1, k], portal[2, k] = portal[2, k], portal[1, k]
        for k in range(3):
            direction[k] = -direction[k]
    for _ in range(col.MPR_ITERATIONS):
        _support(one, two, direction, portal[3])
        if dot(portal[3], direction) < col.EPSILON:
            return -1
        cross(portal[1, :3], portal[3, :3], first)
        replaced = 2 if dot(first, portal[0]) <= -col.EPSILON else 0
        if replaced == 0:
            cross(portal[3, :3], portal[2, :3], first)
            replaced = 1 if dot(first, portal[0]) <= -col.EPSILON else 0
        if replaced == 0:
            return 0
        copy(portal[3], portal[replaced])
        for k in range(3):
            first[k], second[k] = portal[1, k] - portal[0, k], portal[2, k] - portal[0, k]
        cross(first, second, direction)
        normalize(direction)
    return -1


@compiled
def cylinder_with_cylinder(one: Array, two: Array, points: Array, normal: Array) -> int:
    """Contact of two cylinders, as cylinder_with_box()."""
    portal, vertex, direction = temporary(4, 9), temporary(9), temporary(3)
    corners, weights = temporary(9), temporary(4)
    found = _find_portal(one, two, portal)
    if found < 0:
        return 0
    if found == 1:  # the deepest point is known
        depth = math.sqrt(dot(portal[1], portal[1]))
        for k in range(3):
            points[0, k] = 0.5 * (portal[1, 3 + k] + portal[1, 6 + k])
            normal[k] = -portal[1, k] / depth if depth > 0.0 else 0.0
        points[0, 3] = depth
        return 1
    is_inside = False
    for _ in range(2 * col.MPR_ITERATIONS):
        _portal_direction(portal, direction)
        is_inside = is_inside or dot(direction, portal[1]) > -col.EPSILON
        _support(one, two, direction, vertex)
        if not is_inside and dot(vertex, direction) < -col.EPSILON:
            return 0
        if _is_at_surface(portal, vertex, direction):
            break
        _expand_portal(portal, vertex)
    if not is_inside:
        return 0
    for i in range(3):
        copy(portal[1 + i, :3], corners[3 * i : 3 * i + 3])
    origin = temporary(3)
    origin[:] = 0.0
    closest(origin, corners, vertex[:3])
    points[0, 3] = math.sqrt(dot(vertex, vertex))
    for k in range(3):
        normal[k] = -vertex[k] / points[0, 3] if points[0, 3] >= col.EPSILON else 0.0
    _portal_weights(portal, direction, weights)
    for k in range(3):
        points[0, k] = 0.0
        for i in range(4):
            points[0, k] += 0.5 * weights[i] * (portal[i, 3 + k] + portal[i, 6 + k])
    return 1


@compiled
def _portal_weights(portal: Array, direction: Array, weights: Array) -> None:
    """Barycentric coordinates (4,) of the origin in the portal."""
    across = temporary(3)
    for i, (a, b, c) in enumerate(((1, 2, 3), (3, 2, 0), (0, 1, 3), (2, 1, 0))):
        cross(portal[a, :3], portal[b, :3], across)
        weights[i] = dot(across, portal[c])
    total = weights[0] + weights[1] + weights[2] + weights[3]
    if total < col.EPSILON:
        weights[0] = 0.0
        for i, (a, b) in enumerate(((2, 3), (3, 1), (1, 2))):
            cross(portal[a, :3], portal[b, :3], across)
            weights[1 + i] = dot(across, direction)
        total = weights[1] + weights[2] + weights[3]
    for i in range(4):
        weights[i] /= total
