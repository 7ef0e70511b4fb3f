"""Contacts of two triangles, as ODE finds them; whether they overlap, or meet boxes, as in OPCODE.

Triangles are nine numbers, their corners.
"""

from __future__ import annotations

import math

from bullet_sim.engine.quickstep import layout as col
from bullet_sim.engine.quickstep.compiled import compiled, temporary
from bullet_sim.pose import Array


@compiled
def _cut_off(
    x: float, y: float, z: float, distance: float, points: Array, count: int, out: Array
) -> int:
    """Corners of the part of a polygon that is behind a plane, at most eight; their number."""
    n, was_behind, before = 0, False, 0.0
    for i in range(count + 1 if count else 0):
        at = i if i < count else 0
        here = x * points[at, 0] + y * points[at, 1] + z * points[at, 2] - distance
        is_behind = here <= 1e-8
        if i > 0 and is_behind != was_behind and n < 8:
            slope = (points[at, 0] - points[i - 1, 0]) * x
            slope += (points[at, 1] - points[i - 1, 1]) * y
            slope += (points[at, 2] - points[i - 1, 2]) * z
            for k in range(3):
                edge = points[at, k] - points[i - 1, k]
                out[n, k] = points[i - 1, k] + edge * (-before / slope)
            n += 1
        if is_behind and n < 8 and i < count:
            for k in range(3):
                out[n, k] = points[at, k]
            n += 1
        was_behind, before = is_behind, here
    return n


@compiled
def _deepest(one: Array, two: Array, normal: Array, work: Array) -> tuple[int, float]:
    """Of a triangle above and below another one, the deepest points below its plane: their number,
    and the depth [m], which is negative above it.

    Args:
        normal: (3,) gets that of the plane.
        work: (3, 9, 3) numbers to work with; the first (9, 3) get the points.
    """
    u0, u1, u2 = one[3] - one[0], one[4] - one[1], one[5] - one[2]
    v0, v1, v2 = one[6] - one[0], one[7] - one[1], one[8] - one[2]
    x, y, z = u1 * v2 - u2 * v1, u2 * v0 - u0 * v2, u0 * v1 - u1 * v0
    length = math.sqrt(x * x + y * y + z * z)
    if length == 0.0:
        return 0, -col.INFINITE
    x, y, z = x / length, y / length, z / length
    normal[0], normal[1], normal[2] = x, y, z
    points, polygon, other = work[0], work[1], work[2]
    for i in range(3):
        for k in range(3):
            polygon[i, k] = two[3 * i + k]
    count = 3
    for i in range(3):
        a, b = 3 * i, 3 * ((i + 1) % 3)
        u0, u1, u2 = one[b] - one[a], one[b + 1] - one[a + 1], one[b + 2] - one[a + 2]
        p, q, r = u1 * z - u2 * y, u2 * x - u0 * z, u0 * y - u1 * x
        length = math.sqrt(p * p + q * q + r * r)
        if length == 0.0:
            continue
        p, q, r = p / length, q / length, r / length
        distance = p * one[a] + q * one[a + 1] + r * one[a + 2]
        count = _cut_off(p, q, r, distance, polygon, count, other)
        polygon, other = other, polygon
    deepest, n, height = -col.INFINITE, 0, x * one[0] + y * one[1] + z * one[2]
    for i in range(count):
        depth = height - (x * polygon[i, 0] + y * polygon[i, 1] + z * polygon[i, 2])
        if depth > deepest:
            deepest, n = depth, 0
        elif depth + 1e-6 < deepest:
            continue
        for k in range(3):
            points[n, k] = polygon[i, k]
        n += 1
    return n, deepest


@compiled
def triangle_on_triangle(
    one: Array, two: Array, normal: Array, work: Array
) -> tuple[int, float, int]:
    """Contacts of two triangles: their number, depth [m], and where in `work` the points are.

    The normal, towards the first, is that of the triangle which the other is less deep in.

    Args:
        work: (6, 9, 3) numbers to work with.
    """
    second = work[5, 8]  # no polygon has nine corners
    count, depth = _deepest(one, two, normal, work[:3])
    if count == 0:
        return 0, -1.0, 0
    n, deep = _deepest(two, one, second, work[3:])
    if deep < depth:
        for k in range(3):
            normal[k] = second[k]
        return (n if deep >= 0.0 else 0), deep, 3
    for k in range(3):
        normal[k] = -normal[k]
    return (count if depth >= 0.0 else 0), depth, 0


@compiled
def _sides(a: Array, b: Array, out: Array) -> bool:
    """Whether the corners of b are on both sides of the plane of a, near ones being in it.

    Args:
        out: (6,) gets the normal of a, twice its area long, and the distances of the corners, times
            this.
    """
    x1, y1, z1 = a[3] - a[0], a[4] - a[1], a[5] - a[2]
    x2, y2, z2 = a[6] - a[0], a[7] - a[1], a[8] - a[2]
    x, y, z = y1 * z2 - z1 * y2, z1 * x2 - x1 * z2, x1 * y2 - y1 * x2
    d0 = x * (b[0] - a[0]) + y * (b[1] - a[1]) + z * (b[2] - a[2])
    d1 = x * (b[3] - a[0]) + y * (b[4] - a[1]) + z * (b[5] - a[2])
    d2 = x * (b[6] - a[0]) + y * (b[7] - a[1]) + z * (b[8] - a[2])
    d0 = 0.0 if abs(d0) < col.COPLANAR else d0
    d1 = 0.0 if abs(d1) < col.COPLANAR else d1
    d2 = 0.0 if abs(d2) < col.COPLANAR else d2
    if d0 * d1 > 0.0 and d0 * d2 > 0.0:
        return False
    out[0], out[1], out[2], out[3], out[4], out[5] = x, y, z, d0, d1, d2
    return True


@compiled
def _span(a: Array, d0: float, d1: float, d2: float, axis: int, out: Array) -> bool:
    """Where a triangle's plane cut is along an axis: five numbers; whether it is cut at all.

    T. Moeller, "A Fast Triangle-Triangle Intersection Test" (1997), without divisions.
    """
    if d0 * d1 > 0.0:
        i, j, k = 2, 0, 1
    elif d0 * d2 > 0.0:
        i, j, k = 1, 0, 2
    elif d1 * d2 > 0.0 or d0 != 0.0:
        i, j, k = 0, 1, 2
    elif d1 != 0.0:
        i, j, k = 1, 0, 2
    elif d2 != 0.0:
        i, j, k = 2, 0, 1
    else:
        return False
    here = d0 if i == 0 else d1 if i == 1 else d2
    one, two = d0 if j == 0 else d1, d2 if k == 2 else d1
    at = a[3 * i + axis]
    out[0] = at
    out[1] = (a[3 * j + axis] - at) * here
    out[2] = (a[3 * k + axis] - at) * here
    out[3], out[4] = here - one, here - two
    return True


@compiled
def _edges_cross(a: Array, b: Array, i: int, j: int, u: int, v: int) -> bool:
    """Whether the edges from corner i of a triangle and j of another cross in the plane (u, v)."""
    i2, j2 = (i + 1) % 3, (j + 1) % 3
    ax, ay = a[3 * i2 + u] - a[3 * i + u], a[3 * i2 + v] - a[3 * i + v]
    bx, by = b[3 * j + u] - b[3 * j2 + u], b[3 * j + v] - b[3 * j2 + v]
    cx, cy = a[3 * i + u] - b[3 * j + u], a[3 * i + v] - b[3 * j + v]
    f, d = ay * bx - ax * by, by * cx - bx * cy
    if f > 0.0 and 0.0 <= d <= f:
        return 0.0 <= ax * cy - ay * cx <= f
    if f < 0.0 and f <= d <= 0.0:
        return f <= ax * cy - ay * cx <= 0.0
    return False


@compiled
def _is_inside(a: Array, b: Array, u: int, v: int) -> bool:
    """Whether the first corner of a triangle is in another in the plane (u, v)."""
    side = temporary(3)
    for i in range(3):
        j = (i + 1) % 3
        x, y = b[3 * j + v] - b[3 * i + v], b[3 * i + u] - b[3 * j + u]
        side[i] = x * (a[u] - b[3 * i + u]) + y * (a[v] - b[3 * i + v])
    return side[0] * side[1] > 0.0 and side[0] * side[2] > 0.0


@compiled
def _overlap_in_plane(a: Array, b: Array, normal: Array) -> bool:
    """Whether two triangles of one plane overlap."""
    x, y, z = abs(normal[0]), abs(normal[1]), abs(normal[2])
    u, v = (1, 2) if x > y and x > z else (0, 2) if y >= x and y >= z else (0, 1)
    for i in range(3):
        for j in range(3):
            if _edges_cross(a, b, i, j, u, v):
                return True
    return _is_inside(a, b, u, v) or _is_inside(b, a, u, v)


@compiled
def triangles_overlap(a: Array, b: Array, work: Array) -> bool:
    """Whether two triangles meet, as OPCODE has it: those nearly in one plane, the smaller they are
    the further apart, do if they overlap seen along its normal.

    Args:
        work: (4, 6) numbers to work with.
    """
    if not _sides(a, b, work[0]) or not _sides(b, a, work[1]):
        return False
    m, n, s, t = work[0], work[1], work[2], work[3]
    x, y, z = m[1] * n[2] - m[2] * n[1], m[2] * n[0] - m[0] * n[2], m[0] * n[1] - m[1] * n[0]
    axis = 0 if abs(x) >= abs(y) and abs(x) >= abs(z) else 1 if abs(y) >= abs(z) else 2
    if not _span(a, n[3], n[4], n[5], axis, s) or not _span(b, m[3], m[4], m[5], axis, t):
        return _overlap_in_plane(a, b, m)
    xx, yy = s[3] * s[4], t[3] * t[4]
    s0, s1 = s[0] * xx * yy + s[1] * s[4] * yy, s[0] * xx * yy + s[2] * s[3] * yy
    t0, t1 = t[0] * xx * yy + t[1] * xx * t[4], t[0] * xx * yy + t[2] * xx * t[3]
    return not (max(s0, s1) < min(t0, t1) or max(t0, t1) < min(s0, s1))


@compiled
def _beyond(p: float, q: float, r: float, reach: float) -> bool:
    """Whether three numbers are all above a bound or all below its negative."""
    return min(p, q, r) > reach or max(p, q, r) < -reach


@compiled
def triangle_meets_box(t: Array, boxes: Array, b: int) -> bool:
    """Whether a triangle meets a box along the axes: a row of center and half the edges.

    T. Akenine-Moeller, "Fast 3D Triangle-Box Overlap Testing" (2001).
    """
    x, y, z = boxes[b, 3], boxes[b, 4], boxes[b, 5]
    x0, x1, x2 = t[0] - boxes[b, 0], t[3] - boxes[b, 0], t[6] - boxes[b, 0]
    if _beyond(x0, x1, x2, x):
        return False
    y0, y1, y2 = t[1] - boxes[b, 1], t[4] - boxes[b, 1], t[7] - boxes[b, 1]
    if _beyond(y0, y1, y2, y):
        return False
    z0, z1, z2 = t[2] - boxes[b, 2], t[5] - boxes[b, 2], t[8] - boxes[b, 2]
    if _beyond(z0, z1, z2, z):
        return False
    u, v, w = x1 - x0, y1 - y0, z1 - z0
    p, q, r = x2 - x1, y2 - y1, z2 - z1
    nx, ny, nz = v * r - w * q, w * p - u * r, u * q - v * p
    if abs(nx * x0 + ny * y0 + nz * z0) > abs(nx) * x + abs(ny) * y + abs(nz) * z:
        return False
    for i in range(3):
        if i == 1:
            u, v, w = p, q, r
        elif i == 2:
            u, v, w = x0 - x2, y0 - y2, z0 - z2
        reach = abs(w) * y + abs(v) * z
        if _beyond(w * y0 - v * z0, w * y1 - v * z1, w * y2 - v * z2, reach):
            return False
        reach = abs(u) * z + abs(w) * x
        if _beyond(u * z0 - w * x0, u * z1 - w * x1, u * z2 - w * x2, reach):
            return False
        reach = abs(v) * x + abs(u) * y
        if _beyond(v * x0 - u * y0, v * x1 - u * y1, v * x2 - u * y2, reach):
            return False
    return True
