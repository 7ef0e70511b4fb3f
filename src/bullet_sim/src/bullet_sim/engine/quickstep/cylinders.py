"""Contacts of a cylinder with a box, as ODE finds them; what those with a triangle share."""

import math

from bullet_sim.engine.quickstep import layout as col
from bullet_sim.engine.quickstep.compiled import compiled, temporary
from bullet_sim.engine.quickstep.vectors import clip_line, clip_polygon, copy, cross
from bullet_sim.pose import Array


@compiled
def try_axis(
    x: float, y: float, z: float, hull: Array, count: int, cylinder: Array, best: Array
) -> bool:
    """Whether a cylinder and the hull of points overlap along a direction.

    Args:
        hull: (count, 3) from the cylinder's center [m].
        cylinder: (5,) its axis, radius and half its length.
        best: (6,) the least overlap so far [m], half the extents of the cylinder and of the hull
            along its direction, and that, from the cylinder towards the hull.
    """
    length = math.sqrt(x * x + y * y + z * z)
    if length < 1e-5:
        return True
    x, y, z = x / length, y / length, z / length
    cosine = cylinder[0] * x + cylinder[1] * y + cylinder[2] * z
    own = abs(cylinder[4] * cosine) + cylinder[3] * math.sqrt(max(0.0, 1.0 - cosine * cosine))
    low, high = col.INFINITE, -col.INFINITE
    for i in range(count):
        at = hull[i, 0] * x + hull[i, 1] * y + hull[i, 2] * z
        low, high = min(low, at), max(high, at)
    middle, half = 0.5 * (low + high), 0.5 * (high - low)
    depth = own + half - abs(middle)
    if depth < 0.0:
        return False
    if depth < best[0]:
        sign = -1.0 if middle < 0.0 else 1.0
        best[0], best[1], best[2] = depth, own, half
        best[3], best[4], best[5] = sign * x, sign * y, sign * z
    return True


@compiled
def try_corners(hull: Array, count: int, cylinder: Array, best: Array) -> bool:
    """As try_axis(), across the cylinder's axis and towards each point."""
    axis = temporary(3)
    for i in range(count):
        along = 0.0
        for k in range(3):
            along += hull[i, k] * cylinder[k]
        for k in range(3):
            axis[k] = along * cylinder[k] - hull[i, k]
        if not try_axis(axis[0], axis[1], axis[2], hull, count, cylinder, best):
            return False
    return True


@compiled
def try_rims(start: Array, end: Array, hull: Array, count: int, cylinder: Array, best: Array,
              end_of_axis: float) -> bool:  # fmt: skip
    """As try_axis, across an edge and the tangent of a rim where the edge meets its plane."""
    edge, gap, tangent, across = temporary(3), temporary(3), temporary(3), temporary(3)
    length = along = reach = 0.0
    for k in range(3):
        edge[k] = end[k] - start[k]
        length += edge[k] * edge[k]
    length = math.sqrt(length)
    if length == 0.0:
        return True
    for k in range(3):
        edge[k] /= length
        along += edge[k] * cylinder[k]
        reach += (end_of_axis * cylinder[k] - start[k]) * cylinder[k]
    if abs(along) < 1e-5:
        return True
    for k in range(3):
        gap[k] = end_of_axis * cylinder[k] - start[k] - edge[k] * reach / along
    cross(gap, cylinder[:3], tangent)
    cross(tangent, edge, across)
    return try_axis(across[0], across[1], across[2], hull, count, cylinder, best)


@compiled
def side_line(best: Array, cylinder: Array, ends: Array) -> bool:
    """The line of a cylinder's side, (2, 3) from its center, closest to the hull; whether it is."""
    cosine, length, across = 0.0, 0.0, temporary(3)
    for k in range(3):
        cosine += cylinder[k] * best[3 + k]
    for k in range(3):
        across[k] = best[3 + k] - cylinder[k] * cosine
        length += across[k] * across[k]
    length = math.sqrt(length)
    if length < 1e-5:
        return False
    for k in range(3):
        ends[0, k] = across[k] * (cylinder[3] / length) + cylinder[k] * cylinder[4]
        ends[1, k] = across[k] * (cylinder[3] / length) - cylinder[k] * cylinder[4]
    return True


@compiled
def disc_points(
    polygon: Array, count: int, turn: Array, cylinder: Array, best: Array, other: Array
) -> int:
    """Points of a polygon below a disc of a cylinder, which counts as an octagon; their number.

    Args:
        polygon: (16, 3) corners from the cylinder's center; gets the points.
        turn: (9,) the cylinder's rotation.
        other: (16, 3) numbers to work with.
    """
    cosine = 0.0
    for k in range(3):
        cosine += cylinder[k] * best[3 + k]
    sign, half = 1.0 if cosine > 0.0 else -1.0, cylinder[4]
    x, y, z = -sign * cylinder[0], -sign * cylinder[1], -sign * cylinder[2]
    count = clip_polygon(x, y, z, half, polygon, count, other)
    for i in range(8):
        c, s = math.cos(math.pi * (i + 0.5) / 4.0), math.sin(math.pi * (i + 0.5) / 4.0)
        x, y, z = (
            -c * turn[0] - s * turn[1], -c * turn[3] - s * turn[4], -c * turn[6] - s * turn[7],
        )  # fmt: skip
        if i % 2 == 0:
            count = clip_polygon(x, y, z, cylinder[3], other, count, polygon)
        else:
            count = clip_polygon(x, y, z, cylinder[3], polygon, count, other)
    for i in range(count):
        copy(other[i], polygon[i])
    return count


@compiled
def hull_points(
    hull: Array, count: int, is_line: bool, center: Array, best: Array, points: Array
) -> int:
    """Of contacts of a cylinder at `hull` (count, 3) from its center: their points and depths in
    (16, 4); their number."""
    n = 0
    for i in range(count):
        along = 0.0
        for k in range(3):
            along += best[3 + k] * hull[i, k]
            points[n, k] = center[k] + hull[i, k]
        depth = max(0.0, best[0] - best[1] + along) if is_line else best[1] - abs(along)
        points[n, 3] = depth
        if depth > 0.0 or is_line:
            n += 1
    return n


@compiled
def cylinder_with_box(round_: Array, solid: Array, points: Array, normal: Array) -> int:
    """Contacts of a cylinder with a box, as cylinder_on_triangle(): points (16, 4) and the normal
    towards the cylinder; their number."""
    center = round_[col.B_CENTER : col.B_CENTER + 3]
    turn = round_[col.B_ROTATION : col.B_ROTATION + 9]
    cylinder, best, ends = temporary(5), temporary(6), temporary(2, 3)
    hull, middle, axis, local = temporary(16, 3), temporary(3), temporary(3), temporary(3)
    for k in range(3):
        cylinder[k] = turn[3 * k + 2]
        middle[k] = solid[col.B_CENTER + k] - center[k]
    cylinder[3], cylinder[4] = round_[col.B_HALF], round_[col.B_HALF + 1]
    for i in range(8):
        for k in range(3):
            hull[i, k] = middle[k]
            for j in range(3):
                sign = 1.0 if (i >> j) & 1 else -1.0
                hull[i, k] += sign * solid[col.B_HALF + j] * solid[col.B_ROTATION + 3 * k + j]
    best[0], face = col.INFINITE, 0
    for j in range(3):
        least = best[0]
        if not try_axis(solid[col.B_ROTATION + j], solid[col.B_ROTATION + 3 + j],
                         solid[col.B_ROTATION + 6 + j], hull, 8, cylinder, best):  # fmt: skip
            return 0
        if best[0] < least:
            face = j
    # above the middle of a face no other direction has less overlap
    reach, inside = math.hypot(cylinder[3], cylinder[4]), True
    for j in range(3):
        local[j] = 0.0
        for k in range(3):
            local[j] += middle[k] * solid[col.B_ROTATION + 3 * k + j]
        if j != face and abs(local[j]) + reach > solid[col.B_HALF + j]:
            inside = False
    if not inside and not _try_other_axes(hull, solid, cylinder, best):
        return 0
    cosine = 0.0
    for k in range(3):
        cosine += cylinder[k] * best[3 + k]
    for k in range(3):
        normal[k] = -best[3 + k]
    if abs(cosine) >= col.STANDING:
        count = _face_of(solid, middle, best, hull)
        count = disc_points(hull, count, turn, cylinder, best, temporary(16, 3))
        return hull_points(hull, count, False, center, best, points)
    if not side_line(best, cylinder, ends):
        return 0
    for side in range(2):
        sign = 1.0 if side == 0 else -1.0
        for j in range(3):
            for k in range(3):
                axis[k] = sign * solid[col.B_ROTATION + 3 * k + j]
            distance = solid[col.B_HALF + j] + sign * local[j]
            if not clip_line(-axis[0], -axis[1], -axis[2], distance, ends):
                return 0
    return hull_points(ends, 2, True, center, best, points)


@compiled
def _try_other_axes(hull: Array, solid: Array, cylinder: Array, best: Array) -> bool:
    """Whether a cylinder and a box overlap along all directions but those across its faces."""
    axis, side = temporary(3), temporary(3)
    if not try_axis(cylinder[0], cylinder[1], cylinder[2], hull, 8, cylinder, best):
        return False
    for j in range(3):
        for k in range(3):
            side[k] = solid[col.B_ROTATION + 3 * k + j]
        cross(cylinder[:3], side, axis)
        if not try_axis(axis[0], axis[1], axis[2], hull, 8, cylinder, best):
            return False
    if not try_corners(hull, 8, cylinder, best):
        return False
    for rim in range(2):
        end = cylinder[4] if rim == 0 else -cylinder[4]
        for i in range(8):
            for j in range(3):
                other = i | 1 << j
                if other != i and not try_rims(hull[i], hull[other], hull, 8, cylinder, best, end):
                    return False
    return True


@compiled
def _face_of(solid: Array, middle: Array, best: Array, hull: Array) -> int:
    """Corners of the face of a box that is the closest along a direction; their number."""
    largest, face, sign = -1.0, 0, 1.0
    for j in range(3):
        along = 0.0
        for k in range(3):
            along += best[3 + k] * solid[col.B_ROTATION + 3 * k + j]
        if abs(along) > largest:
            largest, face, sign = abs(along), j, -1.0 if along > 0.0 else 1.0
    one, two = (face + 1) % 3, (face + 2) % 3
    for i in range(4):
        first = 1.0 if i in (0, 3) else -1.0
        second = 1.0 if i >= 2 else -1.0
        for k in range(3):
            row = col.B_ROTATION + 3 * k
            hull[i, k] = middle[k] + sign * solid[col.B_HALF + face] * solid[row + face]
            hull[i, k] += first * solid[col.B_HALF + one] * solid[row + one]
            hull[i, k] += second * solid[col.B_HALF + two] * solid[row + two]
    return 4
