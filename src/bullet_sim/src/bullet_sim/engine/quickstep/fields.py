"""Contacts of shapes with heightmaps, as ODE's dCollideHeightfield finds them (heightfield.cpp).

A shape is collided with the infinite plane of each triangle near it, and a point counts if it is
over one of the plane's triangles: what lies on a ridge sinks into it. Of spheres and boxes that are
larger than one and a half squares, points of the grid that are inside count as well; of cylinders
and meshes ODE casts rays there, with negative lengths: they meet no cylinder, and of a mesh the
triangles above a point that are in boxes below it.

A heightmap is a solid of the kind FIELD, z upwards in its frame. Its grid is counted as in ODE:
along x, and from the edge at +y towards -y, which ODE names z. Each square has two triangles, one
of the points (x, z), (x + 1, z) and (x, z + 1), and one of the others.
"""

import math

from bullet_sim.engine.quickstep import layout as col
from bullet_sim.engine.quickstep.broadphase import solid_around
from bullet_sim.engine.quickstep.compiled import compiled, temporary
from bullet_sim.engine.quickstep.contacts import (
    Pair,
    Table,
    add_contact,
    keep_most,
    most_contacts,
)
from bullet_sim.engine.quickstep.meshes import box_in_frame
from bullet_sim.engine.quickstep.planes import points_with_plane
from bullet_sim.engine.quickstep.state import Fields, Scene
from bullet_sim.engine.quickstep.vectors import copy, cross, dot, rotate, rotate_back
from bullet_sim.pose import Array

_SOLID = col.B_COLUMNS  # for temporary()


@compiled
def _fill(zone: Array, field: Array, fields: Fields, ends: Array) -> None:
    """Heights of the points of a zone; ends (2,) gets the lowest and the highest [m]."""
    count, at = zone[3] - zone[2] + 1, 0
    ends[0], ends[1] = col.INFINITE, -col.INFINITE
    first, across = int(field[col.FD_FIRST]), int(field[col.FD_COUNT_X])
    for x in range(zone[0], zone[1] + 1):
        for z in range(count):
            height = fields.heights[first + (zone[2] + z) * across + x]
            fields.points[at, col.V_HEIGHT] = height
            ends[0], ends[1] = min(ends[0], height), max(ends[1], height)
            at += 1


@compiled
def _add_triangle(n: int, x: int, z: int, sign: int, zone: Array, field: Array, f: Fields) -> None:
    """Write row n: the triangle of a point and those beside it, towards more (1) or less (-1)."""
    count, points, triangle = zone[3] - zone[2] + 1, f.points, f.triangles[n]
    corner = (x - zone[0]) * count + z - zone[2]
    wide, deep = field[col.FD_STEP_X], field[col.FD_STEP_Z]
    height, beside = points[corner, col.V_HEIGHT], points[corner + sign * count, col.V_HEIGHT]
    behind = points[corner + sign, col.V_HEIGHT]
    along, across = (x + sign) * wide - x * wide, (z + sign) * deep - z * deep
    a, b, c = across * (height - beside), across * along, along * (height - behind)
    inverse = 1.0 / math.sqrt(a * a + b * b + c * c)
    triangle[0], triangle[1], triangle[2] = a * inverse, b * inverse, c * inverse
    triangle[3] = triangle[0] * (x * wide) + triangle[1] * height + triangle[2] * (z * deep)
    triangle[col.T_TOP] = max(height, beside, behind)
    triangle[col.T_X], triangle[col.T_Z], triangle[col.T_SIGN] = x, z, sign
    triangle[col.T_DONE] = 0.0


@compiled
def _list_triangles(low: float, wants_points: bool, zone: Array, field: Array, f: Fields) -> int:
    """Triangles of a zone that have a point above a height; their number.

    Points that are not above it are done; so is the diagonal of a valley, unless a later square
    takes that back, as in ODE.
    """
    n, count, points = 0, zone[3] - zone[2] + 1, f.points
    for x in range(zone[0], zone[1]):
        for z in range(zone[2], zone[3]):
            a = (x - zone[0]) * count + z - zone[2]
            b, c, d = a + count, a + 1, a + count + 1
            for corner in (a, b, c, d):
                points[corner, col.V_DONE] = 0.0 if points[corner, col.V_HEIGHT] > low else 1.0
            middle = points[b, col.V_DONE] == 0.0 or points[c, col.V_DONE] == 0.0
            if middle or points[a, col.V_DONE] == 0.0:
                _add_triangle(n, x, z, 1, zone, field, f)
                n += 1
            if middle or points[d, col.V_DONE] == 0.0:
                _add_triangle(n, x + 1, z + 1, -1, zone, field, f)
                n += 1
            lower = min(points[a, col.V_HEIGHT], points[d, col.V_HEIGHT])
            higher = max(points[b, col.V_HEIGHT], points[c, col.V_HEIGHT])
            if wants_points and middle and lower > higher:
                points[b, col.V_DONE] = points[c, col.V_DONE] = 1.0
    return n


@compiled
def _group(n: int, f: Fields) -> int:
    """Note of each of n triangles the first one in its plane; the number of planes, whose first
    triangles are in f.order: those whose highest point is low come first."""
    triangles, order, planes = f.triangles, f.order, 0
    for k in range(n):
        if triangles[k, col.T_DONE] != 0.0:
            continue
        top = triangles[k, col.T_TOP]
        triangles[k, col.T_PLANE] = k
        for m in range(k + 1, n):
            same = triangles[m, col.T_DONE] == 0.0
            for i in range(4):
                if not abs(triangles[k, i] - triangles[m, i]) < col.EPSILON:
                    same = False
            if same:
                triangles[m, col.T_PLANE], triangles[m, col.T_DONE] = k, 1.0
                top = max(top, triangles[m, col.T_TOP])
        triangles[k, col.T_DONE], triangles[k, col.T_PLANE_TOP] = 1.0, top
        at = planes
        while at > 0 and triangles[order[at - 1], col.T_PLANE_TOP] - top > col.EPSILON:
            order[at] = order[at - 1]
            at -= 1
        order[at] = k
        planes += 1
    return planes


@compiled
def _is_over(triangle: Array, field: Array, x: float, z: float) -> bool:
    """Whether a point [m, from the grid's corner] is over a triangle, and no other one."""
    wide, deep = field[col.FD_STEP_X], field[col.FD_STEP_Z]
    first = triangle[col.T_SIGN] > 0.0
    left = triangle[col.T_X] - (0.0 if first else 1.0)
    back = triangle[col.T_Z] - (0.0 if first else 1.0)
    low_x, high_x = left * wide, (left + 1.0) * wide
    low_z, high_z = back * deep, (back + 1.0) * deep
    if x < low_x or x >= high_x or z < low_z or z >= high_z:
        return False
    return (high_z - z > (x - low_x) * (deep / wide)) == first


@compiled
def _set_plane(normal: Array, b: int, field: Array, scene: Scene) -> None:
    """Put a plane of the grid (4,) into the world, with the surface of the heightmap."""
    plane, solid, local = scene.fields.plane[0], scene.solids[b], temporary(3)
    copy(scene.faces[b], plane)
    local[0], local[1], local[2] = normal[0], -normal[2], normal[1]
    rotate(solid[col.B_ROTATION : col.B_ROTATION + 9], local, plane[:3])
    plane[3] = normal[3] - 0.5 * (normal[0] * field[col.FD_SIZE_X])
    plane[3] -= 0.5 * (normal[2] * field[col.FD_SIZE_Z])
    for k in range(3):
        plane[3] += plane[k] * solid[col.B_CENTER + k]
    plane[col.P_MOST] = col.MAX_FIELD_RETURNS


@compiled
def _plane_points(
    first: int, k: int, n: int, pair: Pair, field: Array, scene: Scene, table: Table
) -> int:
    """Contacts with the plane of triangle k that are over one of its triangles, of n, from row
    `first`; the number of all then."""
    triangles, solid = scene.fields.triangles, scene.solids[pair.surface]
    local, away, kept = temporary(3), temporary(3), first
    end = points_with_plane(
        first,
        Pair(pair.shape, pair.body, scene.fields.plane, 0),
        scene,
        table,
        col.MAX_FIELD_RETURNS,
    )
    for i in range(first, end):
        for j in range(3):
            away[j] = table.rows[i, col.C_POINT + j] - solid[col.B_CENTER + j]
        rotate_back(solid[col.B_ROTATION : col.B_ROTATION + 9], away, local)
        x, z = local[0] + 0.5 * field[col.FD_SIZE_X], 0.5 * field[col.FD_SIZE_Z] - local[1]
        for m in range(k, n):
            if triangles[m, col.T_PLANE] == k and _is_over(triangles[m], field, x, z):
                if kept != i:
                    copy(table.rows[i], table.rows[kept])
                    copy(table.owners[i], table.owners[kept])
                kept += 1
                break
    return kept


@compiled
def _mark(k: int, n: int, collided: bool, zone: Array, f: Fields) -> None:
    """Note that the plane of triangle k has contacts, so that its points need none, or has none."""
    triangles, count = f.triangles, zone[3] - zone[2] + 1
    for m in range(k, n):
        if triangles[m, col.T_PLANE] != k:
            continue
        if not collided:
            triangles[m, col.T_DONE] = 0.0
            continue
        sign = int(triangles[m, col.T_SIGN])
        x, z = int(triangles[m, col.T_X]), int(triangles[m, col.T_Z])
        corner = (x - zone[0]) * count + z - zone[2]
        for at in (corner, corner + sign * count, corner + sign):
            f.points[at, col.V_DONE] = 1.0


@compiled
def _depth_inside(point: Array, solid: Array, kind: int) -> float:
    """How deep a point is inside a sphere or a box [m]; not above 0: outside."""
    away, local = temporary(3), temporary(3)
    for k in range(3):
        away[k] = point[k] - solid[col.B_CENTER + k]
    if kind == col.SPHERE:
        length = math.sqrt(away[0] * away[0] + away[1] * away[1] + away[2] * away[2])
        return float(solid[col.B_HALF] - length)
    rotate_back(solid[col.B_ROTATION : col.B_ROTATION + 9], away, local)
    depth = col.INFINITE
    for k in range(3):
        depth = min(depth, solid[col.B_HALF + k] - abs(local[k]))
    return depth


@compiled
def _meets_box(middle: Array, half: Array, box: Array) -> bool:
    """Whether a segment, its middle and half of it, meets a box: OPCODE's SegmentAABBOverlap."""
    away = temporary(3)
    for k in range(3):
        away[k] = middle[k] - box[k]
        if abs(away[k]) > box[3 + k] + abs(half[k]):
            return False
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        reach = box[3 + i] * abs(half[j]) + box[3 + j] * abs(half[i])
        if abs(half[i] * away[j] - half[j] * away[i]) > reach:
            return False
    return True


@compiled
def _distance_to_triangle(start: Array, along: Array, corners: Array) -> float:
    """Where a ray meets a triangle from any side; -1: nowhere. Source: Moeller and Trumbore, "Fast,
    minimum storage ray/triangle intersection" (1997)."""
    one, two, away, p, q = temporary(3), temporary(3), temporary(3), temporary(3), temporary(3)
    for k in range(3):
        one[k], two[k] = corners[3 + k] - corners[k], corners[6 + k] - corners[k]
        away[k] = start[k] - corners[k]
    cross(along, two, p)
    volume = dot(one, p)
    if abs(volume) < col.RAY_EPSILON:
        return -1.0
    u = dot(away, p) / volume
    cross(away, one, q)
    v = dot(along, q) / volume
    if u < 0.0 or u > 1.0 or v < 0.0 or u + v > 1.0:
        return -1.0
    return float(dot(two, q) / volume)


@compiled
def _depth_in_mesh(point: Array, along: Array, length: float, b: int, scene: Scene) -> float:
    """How far a triangle of a mesh is from a point along a direction [m], the first in OPCODE's
    order; -1: none. Its boxes have to meet the segment of a length, which is below 0."""
    mesh, trees, waiting = scene.solids[b], scene.trees, 1
    start, turned, half, middle = temporary(3), temporary(3), temporary(3), temporary(3)
    for k in range(3):
        middle[k] = point[k] - mesh[col.B_CENTER + k]
    turn, todo = mesh[col.B_ROTATION : col.B_ROTATION + 9], trees.todo[:, 0]
    rotate_back(turn, middle, start)
    rotate_back(turn, along, turned)
    for k in range(3):
        half[k] = 0.5 * length * turned[k]
        middle[k] = start[k] + half[k]
    todo[0] = scene.roots[b]
    while waiting > 0:
        waiting -= 1
        node = todo[waiting]
        if node >= 0:
            if _meets_box(middle, half, trees.nodes[node]):
                todo[waiting], todo[waiting + 1] = trees.children[node, 1], trees.children[node, 0]
                waiting += 2
        elif node != col.NO_CHILD:
            distance = _distance_to_triangle(start, turned, trees.corners[-1 - node])
            if distance >= 0.0:
                return distance
    return -1.0


@compiled
def _corner_points(
    n: int,
    count: int,
    low: float,
    pair: Pair,
    zone: Array,
    field: Array,
    scene: Scene,
    table: Table,
) -> int:
    """Contacts of points of the grid with a sphere, box or mesh, of the first `count` triangles
    without contacts, from row n; the number of all then. low: of the shape [m]."""
    f, solid, deep = scene.fields, scene.solids[pair.surface], zone[3] - zone[2] + 1
    mine, kind = scene.solids[scene.solid_of[pair.shape]], scene.kinds[pair.shape, 1]
    local, point, normal = temporary(3), temporary(3), temporary(4)
    touching = Pair(pair.shape, pair.body, f.plane, 0)
    for m in range(count):
        triangle = f.triangles[m]
        sign, first_x, first_z = (
            int(triangle[col.T_SIGN]),
            int(triangle[col.T_X]),
            int(triangle[col.T_Z]),
        )
        for corner in range(0 if triangle[col.T_DONE] == 0.0 else 3, 3):
            beside = sign if corner == (1 if sign > 0 else 2) else 0
            behind = sign if corner == (2 if sign > 0 else 1) else 0
            x, z = first_x + beside, first_z + behind
            at = (x - zone[0]) * deep + z - zone[2]
            if f.points[at, col.V_DONE] != 0.0 or n >= len(table.rows):
                continue
            local[0] = x * field[col.FD_STEP_X] - 0.5 * field[col.FD_SIZE_X]
            local[1] = 0.5 * field[col.FD_SIZE_Z] - z * field[col.FD_STEP_Z]
            local[2] = f.points[at, col.V_HEIGHT]
            rotate(solid[col.B_ROTATION : col.B_ROTATION + 9], local, point)
            for k in range(3):
                point[k] += solid[col.B_CENTER + k]
            copy(triangle[:4], normal)
            _set_plane(normal, pair.surface, field, scene)
            if kind == col.MESH:
                length = 1000.0 * (low - local[2])
                b = scene.solid_of[pair.shape]
                depth = _depth_in_mesh(point, f.plane[0, :3], length, b, scene)
            else:
                depth = _depth_inside(point, mine, kind)
            if depth > (-0.5 if kind == col.MESH else col.EPSILON):
                add_contact(n, touching, point, depth, table)
                f.points[at, col.V_DONE] = 1.0
                n += 1
    return n


@compiled
def _zone_points(
    n: int, box: Array, pair: Pair, zone: Array, field: Array, scene: Scene, table: Table
) -> int:
    """Contacts with the squares of a zone, from row n; the number of all then.

    Args:
        box: (6,) around the shape in the heightmap's frame: center and half the edges [m].
    """
    f, ends, normal, kind = scene.fields, temporary(2), temporary(4), scene.kinds[pair.shape, 1]
    touching, low, high = Pair(pair.shape, pair.body, f.plane, 0), box[2] - box[5], box[2] + box[5]
    _fill(zone, field, f, ends)
    if low - ends[1] > -col.EPSILON:
        return n
    normal[0], normal[1], normal[2], normal[3] = 0.0, 1.0, 0.0, ends[0]
    if ends[0] - high > -col.EPSILON:  # all of it is below
        point, local, solid = temporary(3), temporary(3), scene.solids[pair.surface]
        local[0], local[1], local[2] = box[0], box[1], ends[0]
        rotate(solid[col.B_ROTATION : col.B_ROTATION + 9], local, point)
        for k in range(3):
            point[k] += solid[col.B_CENTER + k]
        _set_plane(normal, pair.surface, field, scene)
        add_contact(n, touching, point, ends[0] - high, table)
        return n + 1
    if ends[1] - ends[0] < col.EPSILON:
        _set_plane(normal, pair.surface, field, scene)
        return points_with_plane(n, touching, scene, table, col.MAX_COLLIDE_RETURNS)
    wide = 2.0 * box[3] / field[col.FD_STEP_X] > col.FEW_SQUARES
    wide |= 2.0 * box[4] / field[col.FD_STEP_Z] > col.FEW_SQUARES
    wants_points = wide or kind == col.MESH
    count = _list_triangles(low, wants_points, zone, field, f)
    for i in range(_group(count, f)):
        if n + 16 > len(table.rows):
            return n
        k = f.order[i]
        copy(f.triangles[k, :4], normal)
        _set_plane(normal, pair.surface, field, scene)
        end = _plane_points(n, k, count, pair, field, scene, table)
        _mark(k, count, end > n, zone, f)
        n = end
    if wants_points and kind != col.CYLINDER:
        n = _corner_points(n, count, low, pair, zone, field, scene, table)
    return n


@compiled
def field_contacts(n: int, pair: Pair, scene: Scene, table: Table) -> int:
    """Contacts of a shape of a body with a heightmap, from row n; the number of all then."""
    f, box, around, first = scene.fields, temporary(6), temporary(_SOLID), n
    solid, field = scene.solids[pair.surface], f.rows[scene.roots[pair.surface]]
    kind = scene.kinds[pair.shape, 1]
    if kind == col.MESH:
        solid_around(pair.shape, table.bodies[pair.body], scene, around)
        box_in_frame(around, col.BOX, solid, box)
    else:
        box_in_frame(scene.solids[scene.solid_of[pair.shape]], kind, solid, box)
    left, right = (
        box[0] - box[3] + 0.5 * field[col.FD_SIZE_X],
        box[0] + box[3] + 0.5 * field[col.FD_SIZE_X],
    )
    near, far = (
        0.5 * field[col.FD_SIZE_Z] - box[1] - box[4],
        0.5 * field[col.FD_SIZE_Z] - box[1] + box[4],
    )
    if not (
        left <= field[col.FD_SIZE_X]
        and right >= 0.0
        and near <= field[col.FD_SIZE_Z]
        and far >= 0.0
    ):
        return n
    zone = f.zone
    zone[0] = max(int(math.ceil(left / field[col.FD_STEP_X])) - 1, 0)
    zone[1] = min(int(math.floor(right / field[col.FD_STEP_X])) + 1, int(field[col.FD_COUNT_X]) - 1)
    zone[2] = max(int(math.ceil(near / field[col.FD_STEP_Z])) - 1, 0)
    zone[3] = min(int(math.floor(far / field[col.FD_STEP_Z])) + 1, int(field[col.FD_COUNT_Z]) - 1)
    if zone[0] >= zone[1] or zone[2] >= zone[3]:
        return n
    if (zone[1] - zone[0] + 1) * (zone[3] - zone[2] + 1) > len(f.points):
        return n
    n = _zone_points(n, box, pair, zone, field, scene, table)
    for i in range(first, n):
        table.owners[i, 2], table.owners[i, 3] = -1, scene.owners[pair.surface]
    return keep_most(first, n, most_contacts(pair, table), table)
