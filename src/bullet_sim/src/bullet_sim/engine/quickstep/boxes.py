"""Contacts of two boxes, as ODE finds them; how much turned boxes overlap."""

import math

from bullet_sim.engine.quickstep import layout as col
from bullet_sim.engine.quickstep.compiled import compiled, temporary
from bullet_sim.engine.quickstep.vectors import copy, rotate
from bullet_sim.pose import Array

_SOLID = col.B_COLUMNS  # for temporary()


@compiled
def relative(one: Array, two: Array, out: Array) -> None:
    """The frame of a second solid in that of a first, as a row of solids."""
    for i in range(3):
        out[col.B_CENTER + i] = 0.0
        for k in range(3):
            away = two[col.B_CENTER + k] - one[col.B_CENTER + k]
            out[col.B_CENTER + i] += one[col.B_ROTATION + 3 * k + i] * away
        for j in range(3):
            cosine = 0.0
            for k in range(3):
                cosine += one[col.B_ROTATION + 3 * k + i] * two[col.B_ROTATION + 3 * k + j]
            out[col.B_ROTATION + 3 * i + j] = cosine


@compiled
def box_overlap(one: Array, two: Array, margin: float, found: Array) -> int:
    """The direction in which two solids overlap least, of 15; its number, -1 if they do not.

    Source: Gottschalk et al., "OBBTree" (1996). Edges count as in ODE only if they overlap 5 %
    less than faces do.

    Args:
        margin: added to the cosines between their edges, so that no rounding parts them.
        found: (4,) gets the direction, from the first to the second, and the overlap [m].

    Returns:
        0 to 2 for a face of the first, 3 to 5 of the second, 6 + 3 i + j for the edges i and j.
    """
    frame, r, q, axis = temporary(_SOLID), temporary(3, 3), temporary(3, 3), temporary(3)
    largest, code, sign = -col.INFINITE, -1, 1.0
    relative(one, two, frame)
    gap = frame[col.B_CENTER : col.B_CENTER + 3]
    for i in range(3):
        for j in range(3):
            r[i, j] = frame[col.B_ROTATION + 3 * i + j]
            q[i, j] = abs(r[i, j]) + margin
    for i in range(3):
        over = abs(gap[i]) - one[i] - two[0] * q[i, 0] - two[1] * q[i, 1] - two[2] * q[i, 2]
        if over > 0.0:
            return -1
        if over > largest:
            largest, code, sign = over, i, -1.0 if gap[i] < 0.0 else 1.0
    for j in range(3):
        along = 0.0
        for k in range(3):
            away = two[col.B_CENTER + k] - one[col.B_CENTER + k]
            along += two[col.B_ROTATION + 3 * k + j] * away
        over = abs(along) - two[j] - one[0] * q[0, j] - one[1] * q[1, j] - one[2] * q[2, j]
        if over > 0.0:
            return -1
        if over > largest:
            largest, code, sign = over, 3 + j, -1.0 if along < 0.0 else 1.0
    for i in range(3):
        i1, i2 = (i + 1) % 3, (i + 2) % 3
        for j in range(3):
            j1, j2 = (j + 1) % 3, (j + 2) % 3
            along = gap[i2] * r[i1, j] - gap[i1] * r[i2, j]
            over = abs(along) - one[i1] * q[i2, j] - one[i2] * q[i1, j]
            over -= two[j1] * q[i, j2] + two[j2] * q[i, j1]
            if over > 0.0:
                return -1
            length = math.sqrt(r[i1, j] * r[i1, j] + r[i2, j] * r[i2, j])
            if length > 0.0 and over / length * col.EDGE_FACTOR > largest:
                largest, code, sign = over / length, 6 + 3 * i + j, -1.0 if along < 0.0 else 1.0
                axis[i], axis[i1], axis[i2] = 0.0, -r[i2, j] / length, r[i1, j] / length
    for k in range(3):
        if code < 3:
            found[k] = sign * one[col.B_ROTATION + 3 * k + code]
        elif code < 6:
            found[k] = sign * two[col.B_ROTATION + 3 * k + code - 3]
        else:
            rotate(one[col.B_ROTATION : col.B_ROTATION + 9], axis, found)
    if code >= 6:
        for k in range(3):
            found[k] *= sign
    found[3] = -largest
    return code


@compiled
def _edge_point(one: Array, two: Array, code: int, found: Array, points: Array) -> None:
    """Where two edges of solids are closest to each other, in the middle; its depth."""
    a, b, gap = temporary(3), temporary(3), temporary(3)
    i, j = (code - 6) // 3, (code - 6) % 3
    cosine = first = second = 0.0
    for k in range(3):
        a[k], b[k] = one[col.B_CENTER + k], two[col.B_CENTER + k]
    for side in range(3):
        along = across = 0.0
        for k in range(3):
            along += found[k] * one[col.B_ROTATION + 3 * k + side]
            across += found[k] * two[col.B_ROTATION + 3 * k + side]
        for k in range(3):
            reach = one[side] if along > 0.0 else -one[side]
            a[k] += reach * one[col.B_ROTATION + 3 * k + side]
            reach = -two[side] if across > 0.0 else two[side]
            b[k] += reach * two[col.B_ROTATION + 3 * k + side]
    for k in range(3):
        gap[k] = b[k] - a[k]
        u, v = one[col.B_ROTATION + 3 * k + i], two[col.B_ROTATION + 3 * k + j]
        cosine += u * v
        first += u * gap[k]
        second -= v * gap[k]
    rest = 1.0 - cosine * cosine
    alpha = beta = 0.0
    if rest > 1e-4:
        alpha, beta = (first + cosine * second) / rest, (cosine * first + second) / rest
    for k in range(3):
        a[k] += alpha * one[col.B_ROTATION + 3 * k + i]
        b[k] += beta * two[col.B_ROTATION + 3 * k + j]
        points[0, k] = 0.5 * (a[k] + b[k])
    points[0, 3] = found[3]


@compiled
def _clip_to_face(polygon: Array, reach: Array) -> int:
    """Corners of the part of a quadrilateral (16, 2) in a rectangle of half the edges `reach`;
    their number. They begin and go around as ODE's."""
    count, out = 4, temporary(16, 2)
    for along in range(2):
        for side in range(2):
            sign, n = -1.0 if side == 0 else 1.0, 0
            for i in range(count):
                p, q = polygon[i], polygon[(i + 1) % count]
                is_inside = sign * p[along] < reach[along]
                if is_inside:
                    copy(p, out[n])
                    n += 1
                if is_inside != (sign * q[along] < reach[along]):
                    slope = (q[1 - along] - p[1 - along]) / (q[along] - p[along])
                    out[n, 1 - along] = p[1 - along] + slope * (sign * reach[along] - p[along])
                    out[n, along] = sign * reach[along]
                    n += 1
            count = n
            for i in range(count):
                copy(out[i], polygon[i])
    return count


@compiled
def _face_points(one: Array, two: Array, found: Array, face: int, points: Array) -> int:
    """Points of the second solid's face that are in the first one, within its face; their number.

    Args:
        found: direction across the first's face, from the first to the second.
        points: (16, 4) get the points and their depths.
    """
    polygon, reach, middle = temporary(16, 2), temporary(2), temporary(3)
    c, m = temporary(2), temporary(2, 2)
    c[:] = 0.0
    m[:] = 0.0
    sides = (1 if face == 0 else 0, 1 if face == 2 else 2)
    largest, other, sign = -1.0, 0, 1.0
    for j in range(3):
        along = 0.0
        for k in range(3):
            along += found[k] * two[col.B_ROTATION + 3 * k + j]
        if abs(along) > largest:
            largest, other, sign = abs(along), j, 1.0 if along < 0.0 else -1.0
    a1, a2 = 1 if other == 0 else 0, 1 if other == 2 else 2
    for k in range(3):
        middle[k] = two[col.B_CENTER + k] - one[col.B_CENTER + k]
        middle[k] += sign * two[other] * two[col.B_ROTATION + 3 * k + other]
    for i in range(2):
        reach[i] = one[sides[i]]
        for k in range(3):
            axis = one[col.B_ROTATION + 3 * k + sides[i]]
            c[i] += middle[k] * axis
            m[i, 0] += axis * two[col.B_ROTATION + 3 * k + a1]
            m[i, 1] += axis * two[col.B_ROTATION + 3 * k + a2]
    for i in range(4):
        first = -two[a1] if i < 2 else two[a1]
        second = two[a2] if i in (1, 2) else -two[a2]
        for k in range(2):
            polygon[i, k] = c[k] + first * m[k, 0] + second * m[k, 1]
    count, n = _clip_to_face(polygon, reach), 0
    determinant = m[0, 0] * m[1, 1] - m[0, 1] * m[1, 0]
    for i in range(count):
        x, y = polygon[i, 0] - c[0], polygon[i, 1] - c[1]
        first = (m[1, 1] * x - m[0, 1] * y) / determinant
        second = (m[0, 0] * y - m[1, 0] * x) / determinant
        depth = one[face]
        for k in range(3):
            row = col.B_ROTATION + 3 * k
            points[n, k] = middle[k] + first * two[row + a1] + second * two[row + a2]
            depth -= found[k] * points[n, k]
            points[n, k] += one[col.B_CENTER + k]
        points[n, 3] = depth
        if depth >= 0.0:
            n += 1
    return n


@compiled
def box_with_box(one: Array, two: Array, points: Array, normal: Array) -> int:
    """Contacts of two boxes: where edges meet, or corners of a face in the other's face, as
    cylinder_with_box()."""
    found = temporary(4)
    code = box_overlap(one, two, 0.0, found)
    for k in range(3):
        normal[k] = -found[k]
    if code < 0:
        return 0
    if code >= 6:
        _edge_point(one, two, code, found, points)
        return 1
    if code < 3:
        return _face_points(one, two, found, code, points)
    return _face_points(two, one, normal, code - 3, points)
