"""Contacts of spheres, cylinders and boxes with a triangle, as ODE finds them.

Triangles are nine numbers, their corners in the world; their outer side is the one from which the
corners are counter-clockwise.
"""

import math

from bullet_sim.engine.quickstep import layout as col
from bullet_sim.engine.quickstep.compiled import compiled, temporary
from bullet_sim.engine.quickstep.cylinders import (
    disc_points,
    hull_points,
    side_line,
    try_axis,
    try_corners,
    try_rims,
)
from bullet_sim.engine.quickstep.vectors import clip_line, clip_polygon, closest, cross, dot
from bullet_sim.pose import Array


@compiled
def sphere_on_triangle(
    ball: Array, corners: Array, plane: Array, points: Array, normal: Array
) -> int:
    """Contact of a sphere with a triangle that it is in front of: point and depth (n, 4) and the
    normal of the triangle's plane, towards the sphere; the number of contacts.

    Args:
        ball: row of solids.
        plane: (4,) normal of the triangle and its distance from the origin.
    """
    center, radius, point = ball[col.B_CENTER : col.B_CENTER + 3], ball[col.B_HALF], temporary(3)
    closest(center, corners, point)
    distance = along = 0.0
    for k in range(3):
        gap = center[k] - point[k]
        distance += gap * gap
        along += gap * plane[k]
        normal[k] = plane[k]
        points[0, k] = point[k]
    distance = math.sqrt(distance)
    if distance > radius or distance == 0.0 or along < 0.0:
        return 0
    points[0, 3] = (radius - distance) * (along / distance)
    return 1


@compiled
def cylinder_on_triangle(
    round_: Array, corners: Array, plane: Array, points: Array, normal: Array
) -> int:
    """Contacts of a cylinder with a triangle, as sphere_on_triangle().

    The direction of the least overlap is the normal; points are those of the cylinder's line, or of
    the triangle below its disc.
    """
    center = round_[col.B_CENTER : col.B_CENTER + 3]
    turn = round_[col.B_ROTATION : col.B_ROTATION + 9]
    cylinder, best, ends = temporary(5), temporary(6), temporary(2, 3)
    hull, edges, axis = temporary(16, 3), temporary(3, 3), temporary(3)
    for k in range(3):
        cylinder[k] = turn[3 * k + 2]
        for i in range(3):
            hull[i, k] = corners[3 * i + k] - center[k]
    cylinder[3], cylinder[4] = round_[col.B_HALF], round_[col.B_HALF + 1]
    best[0] = col.INFINITE
    if not try_axis(-plane[0], -plane[1], -plane[2], hull, 3, cylinder, best):
        return 0
    for i in range(3):
        for k in range(3):
            edges[i, k] = hull[(i + 1) % 3, k] - hull[i, k]
        cross(cylinder[:3], edges[i], axis)
        if not try_axis(axis[0], axis[1], axis[2], hull, 3, cylinder, best):
            return 0
    if not try_corners(hull, 3, cylinder, best):
        return 0
    if not try_axis(cylinder[0], cylinder[1], cylinder[2], hull, 3, cylinder, best):
        return 0
    for side in range(2):
        end = cylinder[4] if side == 0 else -cylinder[4]
        for i in range(3):
            if not try_rims(hull[i], hull[(i + 1) % 3], hull, 3, cylinder, best, end):
                return 0
    cosine = 0.0
    for k in range(3):
        cosine += cylinder[k] * best[3 + k]
        normal[k] = -best[3 + k]
    if abs(cosine) >= col.STANDING:
        count = disc_points(hull, 3, turn, cylinder, best, temporary(16, 3))
        return hull_points(hull, count, False, center, best, points)
    if not side_line(best, cylinder, ends):
        return 0
    distance = 0.0
    for k in range(3):
        distance += plane[k] * hull[0, k]
    if not clip_line(-plane[0], -plane[1], -plane[2], distance, ends):
        return 0
    for i in range(3):
        cross(plane[:3], edges[i], axis)
        distance = 1e-5
        for k in range(3):
            distance -= axis[k] * hull[i, k]
        if not clip_line(axis[0], axis[1], axis[2], distance, ends):
            return 0
    return hull_points(ends, 2, True, center, best, points)


@compiled
def _try_interval(
    low: float, high: float, half: float, axis: Array, code: int, edge: bool, best: Array
) -> bool:
    """Whether a box of half a width overlaps an interval [m] along a direction of any length.

    Args:
        axis: (3,) the direction.
        edge: the direction is across two edges, which count only if they overlap less than two
            thirds of what faces do.
        best: (5,) least overlap so far [m], its direction and its number.
    """
    before, behind = half - low, high + half
    if before < 0.0 or behind < 0.0:
        return False
    sign = -1.0 if before > behind else 1.0
    depth = behind if before > behind else before
    x, y, z = axis[0], axis[1], axis[2]
    length = math.sqrt(x * x + y * y + z * z) if edge else 1.0
    depth /= length
    if depth * (1.5 if edge else 1.0) < best[0]:
        best[0], best[4] = depth, code
        best[1], best[2], best[3] = sign * x / length, sign * y / length, sign * z / length
    return True


@compiled
def _overlap_with_box(box: Array, corners: Array, edges: Array, face: Array, best: Array) -> bool:
    """Whether a box and a triangle overlap in 13 directions; `best` as in _try_interval(): number 1
    is the triangle's normal, 2 to 4 are the box's, from 5 on edges of both."""
    gap, axes, across = temporary(3), temporary(3, 3), temporary(3)
    height, reach = 0.0, 0.0
    for k in range(3):
        gap[k] = corners[k] - box[col.B_CENTER + k]
        height += face[k] * gap[k]
    for i in range(3):
        for k in range(3):
            axes[i, k] = box[col.B_ROTATION + 3 * k + i]
        reach += box[col.B_HALF + i] * abs(dot(face, axes[i]))
    length = math.sqrt(dot(face, face))
    if length < col.EPSILON or reach + height < 0.0:
        return False
    best[0], best[4] = (reach + height) / length, 1.0
    for k in range(3):
        best[1 + k] = -face[k] / length
    for i in range(3):
        a = dot(axes[i], gap)
        b, c = a + dot(axes[i], edges[0]), a + dot(axes[i], edges[1])
        half = box[col.B_HALF + i]
        if not _try_interval(min(a, b, c), max(a, b, c), half, axes[i], 2 + i, False, best):
            return False
    for i in range(3):
        turn = dot(axes[i], face)
        one, two = (i + 1) % 3, (i + 2) % 3
        for j in range(3):
            cross(axes[i], edges[j], across)
            if dot(across, across) <= col.EPSILON:
                continue
            a = dot(across, gap)
            b = a + turn if j == 0 else a - turn
            reach = box[col.B_HALF + one] * abs(dot(axes[two], edges[j]))
            reach += box[col.B_HALF + two] * abs(dot(axes[one], edges[j]))
            if not _try_interval(min(a, b), max(a, b), reach, across, 5 + 3 * i + j, True, best):
                return False
    return True


@compiled
def _crossing(box: Array, corners: Array, edges: Array, best: Array, points: Array) -> int:
    """The contact of an edge of a box with one of a triangle: between both lines."""
    code = int(best[4]) - 5
    a, b = temporary(3), temporary(3)
    along, to, between, edge = temporary(3), temporary(3), temporary(3), edges[code % 3]
    length = math.sqrt(dot(edge, edge))
    first = 0 if code % 3 == 0 else 6 if code % 3 == 1 else 3  # a corner on the edge
    for k in range(3):
        a[k] = box[col.B_CENTER + k]
        b[k], to[k] = corners[first + k], edge[k] / length
        along[k] = box[col.B_ROTATION + 3 * k + code // 3]
    for i in range(3):
        cosine = 0.0
        for k in range(3):
            cosine += best[1 + k] * box[col.B_ROTATION + 3 * k + i]
        for k in range(3):
            side = box[col.B_HALF + i] if cosine > 0.0 else -box[col.B_HALF + i]
            a[k] += side * box[col.B_ROTATION + 3 * k + i]
    for k in range(3):
        between[k] = b[k] - a[k]
    cosine = dot(along, to)
    one, two, rest = dot(along, between), -dot(to, between), 1.0 - cosine * cosine
    if rest > 0.0:
        rest = 1.0 / rest
        on_a, on_b = (one + cosine * two) * rest, (cosine * one + two) * rest
        for k in range(3):
            a[k] += along[k] * on_a
            b[k] += to[k] * on_b
    for k in range(3):
        points[0, k] = 0.5 * (a[k] + b[k])
    points[0, 3] = best[0]
    return 1


@compiled
def _on_face_of_triangle(
    box: Array, corners: Array, edges: Array, face: Array, best: Array, points: Array
) -> int:
    """Contacts of a box's side with a triangle: what of it is above the triangle and behind its
    plane."""
    local, one, two = temporary(3), temporary(16, 3), temporary(16, 3)
    for i in range(3):
        local[i] = 0.0
        for k in range(3):
            local[i] -= box[col.B_ROTATION + 3 * k + i] * best[1 + k]
    x, y, z = abs(local[0]), abs(local[1]), abs(local[2])
    first = (1 if y > z else 2) if y > x else (0 if x > z else 2)
    u, v = (1, 2) if first == 0 else (0, 2) if first == 1 else (0, 1)
    for k in range(3):
        side = box[col.B_HALF + first] * box[col.B_ROTATION + 3 * k + first]
        middle = box[col.B_CENTER + k] - corners[k] + (-side if local[first] > 0.0 else side)
        du = box[col.B_HALF + u] * box[col.B_ROTATION + 3 * k + u]
        dv = box[col.B_HALF + v] * box[col.B_ROTATION + 3 * k + v]
        one[0, k], one[1, k] = middle + du - dv, middle - du - dv
        one[2, k], one[3, k] = middle - du + dv, middle + du + dv
    length = math.sqrt(dot(face, face))
    count = clip_polygon(-face[0] / length, -face[1] / length, -face[2] / length, 0.0, one, 4, two)
    across, edge = temporary(3), temporary(3)
    for i in range(3):
        distance = 0.0
        for k in range(3):
            edge[k] = corners[3 * ((i + 1) % 3) + k] - corners[3 * i + k]
        cross(face, edge, across)
        length = math.sqrt(dot(across, across))
        for k in range(3):
            across[k] /= length
            if i == 1:  # the only one that does not meet the first corner
                distance -= edges[1, k] * across[k]
        if i % 2 == 0:
            count = clip_polygon(across[0], across[1], across[2], distance, two, count, one)
        else:
            count = clip_polygon(across[0], across[1], across[2], distance, one, count, two)
    for i in range(count):
        depth = 0.0
        for k in range(3):
            depth += best[1 + k] * one[i, k]
            points[i, k] = one[i, k] + corners[k]
        points[i, 3] = max(0.0, depth)
    return count


@compiled
def _on_face_of_box(box: Array, corners: Array, best: Array, points: Array) -> int:
    """Contacts of a triangle with a box's side: what of it is in the box."""
    first, one, two = int(best[4]) - 2, temporary(16, 3), temporary(16, 3)
    for i in range(3):
        for k in range(3):
            one[i, k] = corners[3 * i + k] - box[col.B_CENTER + k]
    count = clip_polygon(-best[1], -best[2], -best[3], box[col.B_HALF + first], one, 3, two)
    for i in range(3):
        if i == first:
            continue
        x, y, z = box[col.B_ROTATION + i], box[col.B_ROTATION + 3 + i], box[col.B_ROTATION + 6 + i]
        count = clip_polygon(x, y, z, box[col.B_HALF + i], two, count, one)
        count = clip_polygon(-x, -y, -z, box[col.B_HALF + i], one, count, two)
    for i in range(count):
        depth = box[col.B_HALF + first]
        for k in range(3):
            depth -= best[1 + k] * two[i, k]
            points[i, k] = two[i, k] + box[col.B_CENTER + k]
        points[i, 3] = max(0.0, depth)
    return count


@compiled
def box_on_triangle(box: Array, corners: Array, points: Array, normal: Array) -> int:
    """Contacts of a box with a triangle, as sphere_on_triangle(); a box behind it counts, too."""
    edges, face, best = temporary(3, 3), temporary(3), temporary(5)
    for k in range(3):
        edges[0, k] = corners[3 + k] - corners[k]
        edges[1, k] = corners[6 + k] - corners[k]
        edges[2, k] = edges[1, k] - edges[0, k]
    cross(edges[0], edges[1], face)
    if not _overlap_with_box(box, corners, edges, face, best):
        return 0
    for k in range(3):
        normal[k] = -best[1 + k]
    if best[4] > 4.0:
        return _crossing(box, corners, edges, best, points)
    if best[4] == 1.0:
        return _on_face_of_triangle(box, corners, edges, face, best, points)
    return _on_face_of_box(box, corners, best, points)
