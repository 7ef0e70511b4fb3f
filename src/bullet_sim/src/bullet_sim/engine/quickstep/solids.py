"""Contacts of two boxes, spheres or cylinders, as ODE finds them."""

import math

from bullet_sim.engine.quickstep.compiled import compiled, temporary
from bullet_sim.engine.quickstep.layout import (
    B_CENTER,
    B_COLUMNS,
    B_HALF,
    B_ROTATION,
    EDGE_FACTOR,
    EPSILON,
    INFINITE,
    MPR_ITERATIONS,
    MPR_TOLERANCE,
    PARALLEL,
    STANDING,
)
from bullet_sim.engine.quickstep.vectors import (
    clip_line,
    clip_polygon,
    closest,
    copy,
    cross,
    dot,
    normalize,
    rotate,
)
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
    low, high = INFINITE, -INFINITE
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
    center, turn = round_[B_CENTER : B_CENTER + 3], round_[B_ROTATION : B_ROTATION + 9]
    cylinder, best, ends = temporary(5), temporary(6), temporary(2, 3)
    hull, middle, axis, local = temporary(16, 3), temporary(3), temporary(3), temporary(3)
    for k in range(3):
        cylinder[k] = turn[3 * k + 2]
        middle[k] = solid[B_CENTER + k] - center[k]
    cylinder[3], cylinder[4] = round_[B_HALF], round_[B_HALF + 1]
    for i in range(8):
        for k in range(3):
            hull[i, k] = middle[k]
            for j in range(3):
                sign = 1.0 if (i >> j) & 1 else -1.0
                hull[i, k] += sign * solid[B_HALF + j] * solid[B_ROTATION + 3 * k + j]
    best[0], face = INFINITE, 0
    for j in range(3):
        least = best[0]
        if not try_axis(solid[B_ROTATION + j], solid[B_ROTATION + 3 + j],
                         solid[B_ROTATION + 6 + j], hull, 8, cylinder, best):  # fmt: skip
            return 0
        if best[0] < least:
            face = j
    # above the middle of a face no other direction has less overlap
    reach, inside = math.hypot(cylinder[3], cylinder[4]), True
    for j in range(3):
        local[j] = 0.0
        for k in range(3):
            local[j] += middle[k] * solid[B_ROTATION + 3 * k + j]
        if j != face and abs(local[j]) + reach > solid[B_HALF + j]:
            inside = False
    if not inside and not _try_other_axes(hull, solid, cylinder, best):
        return 0
    cosine = 0.0
    for k in range(3):
        cosine += cylinder[k] * best[3 + k]
    for k in range(3):
        normal[k] = -best[3 + k]
    if abs(cosine) >= STANDING:
        count = _face_of(solid, middle, best, hull)
        count = disc_points(hull, count, turn, cylinder, best, temporary(16, 3))
        return hull_points(hull, count, False, center, best, points)
    if not side_line(best, cylinder, ends):
        return 0
    for side in range(2):
        sign = 1.0 if side == 0 else -1.0
        for j in range(3):
            for k in range(3):
                axis[k] = sign * solid[B_ROTATION + 3 * k + j]
            distance = solid[B_HALF + j] + sign * local[j]
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
            side[k] = solid[B_ROTATION + 3 * k + j]
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
    most, face, sign = -1.0, 0, 1.0
    for j in range(3):
        along = 0.0
        for k in range(3):
            along += best[3 + k] * solid[B_ROTATION + 3 * k + j]
        if abs(along) > most:
            most, face, sign = abs(along), j, -1.0 if along > 0.0 else 1.0
    one, two = (face + 1) % 3, (face + 2) % 3
    for i in range(4):
        first = 1.0 if i in (0, 3) else -1.0
        second = 1.0 if i >= 2 else -1.0
        for k in range(3):
            row = B_ROTATION + 3 * k
            hull[i, k] = middle[k] + sign * solid[B_HALF + face] * solid[row + face]
            hull[i, k] += first * solid[B_HALF + one] * solid[row + one]
            hull[i, k] += second * solid[B_HALF + two] * solid[row + two]
    return 4


@compiled
def sphere_with_box(ball: Array, solid: Array, points: Array, normal: Array) -> int:
    """Contact of a sphere with a box, as cylinder_with_box()."""
    center, radius, local = ball[B_CENTER : B_CENTER + 3], ball[B_HALF], temporary(3)
    is_outside, least, face = False, INFINITE, 0
    for j in range(3):
        local[j] = 0.0
        for k in range(3):
            local[j] += (center[k] - solid[B_CENTER + k]) * solid[B_ROTATION + 3 * k + j]
        half = solid[B_HALF + j]
        if half - abs(local[j]) < least:
            least, face = half - abs(local[j]), j
        if abs(local[j]) > half:
            local[j] = half if local[j] > 0.0 else -half
            is_outside = True
    if is_outside:
        distance = 0.0
        for k in range(3):
            points[0, k] = solid[B_CENTER + k]
            for j in range(3):
                points[0, k] += solid[B_ROTATION + 3 * k + j] * local[j]
            normal[k] = center[k] - points[0, k]
            distance += normal[k] * normal[k]
        distance = math.sqrt(distance)
        points[0, 3] = radius - distance
        if points[0, 3] < 0.0 or distance == 0.0:
            return 0
        for k in range(3):
            normal[k] /= distance
    else:
        points[0, 3] = least + radius
        for k in range(3):
            points[0, k] = center[k]
            side = solid[B_ROTATION + 3 * k + face]
            normal[k] = side if local[face] > 0.0 else -side
    return 1


@compiled
def sphere_with_sphere(one: Array, two: Array, points: Array, normal: Array) -> int:
    """Contact of two spheres, halfway between their surfaces, as cylinder_with_box()."""
    distance = 0.0
    for k in range(3):
        normal[k] = one[B_CENTER + k] - two[B_CENTER + k]
        distance += normal[k] * normal[k]
    distance = math.sqrt(distance)
    points[0, 3] = one[B_HALF] + two[B_HALF] - distance
    if points[0, 3] < 0.0:
        return 0
    if distance <= 0.0:
        normal[0], distance = 1.0, 1.0
    for k in range(3):
        normal[k] /= distance
        points[0, k] = one[B_CENTER + k]
        points[0, k] += normal[k] * 0.5 * (two[B_HALF] - one[B_HALF] - distance)
    return 1


@compiled
def cylinder_with_sphere(round_: Array, ball: Array, points: Array, normal: Array) -> int:
    """Contact of a cylinder with a sphere: on its side, a disc or a rim."""
    radius, length, reach = round_[B_HALF], 2.0 * round_[B_HALF + 1], ball[B_HALF]
    axis, across = temporary(3), temporary(3)
    along, away = 0.5 * length, 0.0  # of the sphere's center: from the first disc, from the axis
    for k in range(3):
        axis[k] = round_[B_ROTATION + 3 * k + 2]
        along += (ball[B_CENTER + k] - round_[B_CENTER + k]) * axis[k]
    for k in range(3):
        across[k] = round_[B_CENTER + k] + (along - 0.5 * length) * axis[k] - ball[B_CENTER + k]
        away += across[k] * across[k]
    away = math.sqrt(away)
    if along < -reach or along > length + reach or away > radius + reach:
        return 0
    if away > radius and (along < 0.0 or along > length):
        beyond = along if along <= 0.0 else along - length
        distance = math.hypot(beyond, away - radius)
        points[0, 3] = reach - distance
        if points[0, 3] < 0.0:
            return 0
        for k in range(3):
            points[0, k] = round_[B_CENTER + k] - across[k] / away * radius
            points[0, k] += axis[k] * (-0.5 * length if along <= 0.0 else 0.5 * length)
            normal[k] = (points[0, k] - ball[B_CENTER + k]) / distance
        return 1
    if radius - away <= along and radius - away <= length - along:
        points[0, 3] = reach + radius - away
        for k in range(3):
            normal[k] = across[k] / away
            way = normal[k] * reach if away > reach + PARALLEL else across[k]
            points[0, k] = ball[B_CENTER + k] + way
        return 1
    sign = 1.0 if along <= 0.5 * length else -1.0
    points[0, 3] = reach + (along if sign > 0.0 else length - along)
    if points[0, 3] < 0.0:
        return 0
    for k in range(3):
        normal[k] = sign * axis[k]
        points[0, k] = ball[B_CENTER + k] + normal[k] * reach
    return 1


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
                local[j] += sign * direction[k] * body[B_ROTATION + 3 * k + j]
        flat = math.sqrt(local[0] * local[0] + local[1] * local[1])
        scale = 0.0 if flat < EPSILON else body[B_HALF] / flat
        x, y = scale * local[0], scale * local[1]
        z = 0.0 if abs(local[2]) < EPSILON else body[B_HALF + 1]
        z = -z if local[2] < 0.0 else z
        for k in range(3):
            row = B_ROTATION + 3 * k
            vertex[3 + 3 * i + k] = body[B_CENTER + k]
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
    nearest = INFINITE
    for i in range(1, 4):
        nearest = min(nearest, dot(vertex, direction) - dot(portal[i], direction))
    return nearest <= MPR_TOLERANCE


@compiled
def _find_portal(one: Array, two: Array, portal: Array) -> int:
    """A tetrahedron in the Minkowski difference of two cylinders, from its inner point (row 0)
    with a face that the ray to the origin passes.

    Returns:
        0; 1: the origin is on the line from the inner point to row 1; -1: they are apart.
    """
    direction, first, second = temporary(3), temporary(3), temporary(3)
    for k in range(3):
        portal[0, 3 + k], portal[0, 6 + k] = one[B_CENTER + k], two[B_CENTER + k]
        portal[0, k] = one[B_CENTER + k] - two[B_CENTER + k]
    if abs(portal[0, 0]) + abs(portal[0, 1]) + abs(portal[0, 2]) < EPSILON:
        portal[0, 0] += 10.0 * EPSILON
    for k in range(3):
        direction[k] = -portal[0, k]
    normalize(direction)
    _support(one, two, direction, portal[1])
    if dot(portal[1], direction) < EPSILON:
        return -1
    cross(portal[0, :3], portal[1, :3], direction)
    if dot(direction, direction) < EPSILON:
        return 1
    normalize(direction)
    _support(one, two, direction, portal[2])
    if dot(portal[2], direction) < EPSILON:
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
    for _ in range(MPR_ITERATIONS):
        _support(one, two, direction, portal[3])
        if dot(portal[3], direction) < EPSILON:
            return -1
        cross(portal[1, :3], portal[3, :3], first)
        replaced = 2 if dot(first, portal[0]) <= -EPSILON else 0
        if replaced == 0:
            cross(portal[3, :3], portal[2, :3], first)
            replaced = 1 if dot(first, portal[0]) <= -EPSILON else 0
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
    """Contact of two cylinders by Minkowski portal refinement, as cylinder_with_box().

    Source: G. Snethen, "XenoCollide" (Game Programming Gems 7, 2008), with the tolerances of
    libccd, which ODE asks.
    """
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
    for _ in range(2 * MPR_ITERATIONS):
        _portal_direction(portal, direction)
        is_inside = is_inside or dot(direction, portal[1]) > -EPSILON
        _support(one, two, direction, vertex)
        if not is_inside and dot(vertex, direction) < -EPSILON:
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
        normal[k] = -vertex[k] / points[0, 3] if points[0, 3] >= EPSILON else 0.0
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
    if total < EPSILON:
        weights[0] = 0.0
        for i, (a, b) in enumerate(((2, 3), (3, 1), (1, 2))):
            cross(portal[a, :3], portal[b, :3], across)
            weights[1 + i] = dot(across, direction)
        total = weights[1] + weights[2] + weights[3]
    for i in range(4):
        weights[i] /= total


@compiled
def relative(one: Array, two: Array, out: Array) -> None:
    """The frame of a second solid in that of a first, as a row of solids."""
    for i in range(3):
        out[B_CENTER + i] = 0.0
        for k in range(3):
            away = two[B_CENTER + k] - one[B_CENTER + k]
            out[B_CENTER + i] += one[B_ROTATION + 3 * k + i] * away
        for j in range(3):
            cosine = 0.0
            for k in range(3):
                cosine += one[B_ROTATION + 3 * k + i] * two[B_ROTATION + 3 * k + j]
            out[B_ROTATION + 3 * i + j] = cosine


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
    frame, r, q, axis = temporary(B_COLUMNS), temporary(3, 3), temporary(3, 3), temporary(3)
    most, code, sign = -INFINITE, -1, 1.0
    relative(one, two, frame)
    gap = frame[B_CENTER : B_CENTER + 3]
    for i in range(3):
        for j in range(3):
            r[i, j] = frame[B_ROTATION + 3 * i + j]
            q[i, j] = abs(r[i, j]) + margin
    for i in range(3):
        over = abs(gap[i]) - one[i] - two[0] * q[i, 0] - two[1] * q[i, 1] - two[2] * q[i, 2]
        if over > 0.0:
            return -1
        if over > most:
            most, code, sign = over, i, -1.0 if gap[i] < 0.0 else 1.0
    for j in range(3):
        along = 0.0
        for k in range(3):
            away = two[B_CENTER + k] - one[B_CENTER + k]
            along += two[B_ROTATION + 3 * k + j] * away
        over = abs(along) - two[j] - one[0] * q[0, j] - one[1] * q[1, j] - one[2] * q[2, j]
        if over > 0.0:
            return -1
        if over > most:
            most, code, sign = over, 3 + j, -1.0 if along < 0.0 else 1.0
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
            if length > 0.0 and over / length * EDGE_FACTOR > most:
                most, code, sign = over / length, 6 + 3 * i + j, -1.0 if along < 0.0 else 1.0
                axis[i], axis[i1], axis[i2] = 0.0, -r[i2, j] / length, r[i1, j] / length
    for k in range(3):
        if code < 3:
            found[k] = sign * one[B_ROTATION + 3 * k + code]
        elif code < 6:
            found[k] = sign * two[B_ROTATION + 3 * k + code - 3]
        else:
            rotate(one[B_ROTATION : B_ROTATION + 9], axis, found)
    if code >= 6:
        for k in range(3):
            found[k] *= sign
    found[3] = -most
    return code


@compiled
def _edge_point(one: Array, two: Array, code: int, found: Array, points: Array) -> None:
    """Where two edges of solids are closest to each other, in the middle; its depth."""
    a, b, gap = temporary(3), temporary(3), temporary(3)
    i, j = (code - 6) // 3, (code - 6) % 3
    cosine = first = second = 0.0
    for k in range(3):
        a[k], b[k] = one[B_CENTER + k], two[B_CENTER + k]
    for side in range(3):
        along = across = 0.0
        for k in range(3):
            along += found[k] * one[B_ROTATION + 3 * k + side]
            across += found[k] * two[B_ROTATION + 3 * k + side]
        for k in range(3):
            reach = one[side] if along > 0.0 else -one[side]
            a[k] += reach * one[B_ROTATION + 3 * k + side]
            reach = -two[side] if across > 0.0 else two[side]
            b[k] += reach * two[B_ROTATION + 3 * k + side]
    for k in range(3):
        gap[k] = b[k] - a[k]
        u, v = one[B_ROTATION + 3 * k + i], two[B_ROTATION + 3 * k + j]
        cosine += u * v
        first += u * gap[k]
        second -= v * gap[k]
    rest = 1.0 - cosine * cosine
    alpha = beta = 0.0
    if rest > 1e-4:
        alpha, beta = (first + cosine * second) / rest, (cosine * first + second) / rest
    for k in range(3):
        a[k] += alpha * one[B_ROTATION + 3 * k + i]
        b[k] += beta * two[B_ROTATION + 3 * k + j]
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
    most, other, sign = -1.0, 0, 1.0
    for j in range(3):
        along = 0.0
        for k in range(3):
            along += found[k] * two[B_ROTATION + 3 * k + j]
        if abs(along) > most:
            most, other, sign = abs(along), j, 1.0 if along < 0.0 else -1.0
    a1, a2 = 1 if other == 0 else 0, 1 if other == 2 else 2
    for k in range(3):
        middle[k] = two[B_CENTER + k] - one[B_CENTER + k]
        middle[k] += sign * two[other] * two[B_ROTATION + 3 * k + other]
    for i in range(2):
        reach[i] = one[sides[i]]
        for k in range(3):
            axis = one[B_ROTATION + 3 * k + sides[i]]
            c[i] += middle[k] * axis
            m[i, 0] += axis * two[B_ROTATION + 3 * k + a1]
            m[i, 1] += axis * two[B_ROTATION + 3 * k + a2]
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
            row = B_ROTATION + 3 * k
            points[n, k] = middle[k] + first * two[row + a1] + second * two[row + a2]
            depth -= found[k] * points[n, k]
            points[n, k] += one[B_CENTER + k]
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
