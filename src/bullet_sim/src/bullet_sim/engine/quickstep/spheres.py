"""Contacts of spheres with spheres, boxes and cylinders, as ODE finds them."""

import math

from bullet_sim.engine.quickstep import layout as col
from bullet_sim.engine.quickstep.compiled import compiled, temporary
from bullet_sim.pose import Array


@compiled
def sphere_with_box(ball: Array, solid: Array, points: Array, normal: Array) -> int:
    """Contact of a sphere with a box, as cylinder_with_box()."""
    center, radius, local = ball[col.B_CENTER : col.B_CENTER + 3], ball[col.B_HALF], temporary(3)
    is_outside, least, face = False, col.INFINITE, 0
    for j in range(3):
        local[j] = 0.0
        for k in range(3):
            local[j] += (center[k] - solid[col.B_CENTER + k]) * solid[col.B_ROTATION + 3 * k + j]
        half = solid[col.B_HALF + j]
        if half - abs(local[j]) < least:
            least, face = half - abs(local[j]), j
        if abs(local[j]) > half:
            local[j] = half if local[j] > 0.0 else -half
            is_outside = True
    if is_outside:
        distance = 0.0
        for k in range(3):
            points[0, k] = solid[col.B_CENTER + k]
            for j in range(3):
                points[0, k] += solid[col.B_ROTATION + 3 * k + j] * local[j]
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
            side = solid[col.B_ROTATION + 3 * k + face]
            normal[k] = side if local[face] > 0.0 else -side
    return 1


@compiled
def sphere_with_sphere(one: Array, two: Array, points: Array, normal: Array) -> int:
    """Contact of two spheres, halfway between their surfaces, as cylinder_with_box()."""
    distance = 0.0
    for k in range(3):
        normal[k] = one[col.B_CENTER + k] - two[col.B_CENTER + k]
        distance += normal[k] * normal[k]
    distance = math.sqrt(distance)
    points[0, 3] = one[col.B_HALF] + two[col.B_HALF] - distance
    if points[0, 3] < 0.0:
        return 0
    if distance <= 0.0:
        normal[0], distance = 1.0, 1.0
    for k in range(3):
        normal[k] /= distance
        points[0, k] = one[col.B_CENTER + k]
        points[0, k] += normal[k] * 0.5 * (two[col.B_HALF] - one[col.B_HALF] - distance)
    return 1


@compiled
def cylinder_with_sphere(round_: Array, ball: Array, points: Array, normal: Array) -> int:
    """Contact of a cylinder with a sphere: on its side, a disc or a rim."""
    radius, length, reach = round_[col.B_HALF], 2.0 * round_[col.B_HALF + 1], ball[col.B_HALF]
    axis, across = temporary(3), temporary(3)
    along, away = 0.5 * length, 0.0  # of the sphere's center: from the first disc, from the axis
    for k in range(3):
        axis[k] = round_[col.B_ROTATION + 3 * k + 2]
        along += (ball[col.B_CENTER + k] - round_[col.B_CENTER + k]) * axis[k]
    for k in range(3):
        on_axis = round_[col.B_CENTER + k] + (along - 0.5 * length) * axis[k]
        across[k] = on_axis - ball[col.B_CENTER + k]
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
            points[0, k] = round_[col.B_CENTER + k] - across[k] / away * radius
            points[0, k] += axis[k] * (-0.5 * length if along <= 0.0 else 0.5 * length)
            normal[k] = (points[0, k] - ball[col.B_CENTER + k]) / distance
        return 1
    if radius - away <= along and radius - away <= length - along:
        points[0, 3] = reach + radius - away
        for k in range(3):
            normal[k] = across[k] / away
            way = normal[k] * reach if away > reach + col.PARALLEL else across[k]
            points[0, k] = ball[col.B_CENTER + k] + way
        return 1
    sign = 1.0 if along <= 0.5 * length else -1.0
    points[0, 3] = reach + (along if sign > 0.0 else length - along)
    if points[0, 3] < 0.0:
        return 0
    for k in range(3):
        normal[k] = sign * axis[k]
        points[0, k] = ball[col.B_CENTER + k] + normal[k] * reach
    return 1
