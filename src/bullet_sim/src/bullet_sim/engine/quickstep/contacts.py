"""Contacts of all bodies, in the order in which Gazebo has them."""

import math

from bullet_sim.engine.quickstep.compiled import compiled, temporary
from bullet_sim.engine.quickstep.layout import (
    B_CENTER,
    B_ROTATION,
    BOX,
    C_CFM,
    C_DEPTH,
    C_ERP,
    C_FDIR,
    C_MAX,
    C_MU,
    C_NORMAL,
    C_POINT,
    C_SLIP,
    CHUNK,
    CYLINDER,
    F_DEPTH,
    F_NORMAL,
    G_FDIR,
    G_KD,
    G_KP,
    G_MU,
    G_OFFSET,
    G_ROTATION,
    G_SIZE,
    G_SLIP,
    MAX_VEL,
    MESH,
    MESH_CONTACTS,
    MIN_DEPTH,
    MOST_FOUND,
    P_FDIR,
    P_KD,
    P_KP,
    P_MU,
    P_PLANE,
    P_SLIP,
    PARALLEL,
    POS,
    RADIUS,
    ROUNDING,
    SPHERE,
    W_R,
    Scene,
    softness,
)
from bullet_sim.engine.quickstep.near import list_pairs
from bullet_sim.engine.quickstep.solids import (
    box_with_box,
    cylinder_with_box,
    cylinder_with_cylinder,
    cylinder_with_sphere,
    sphere_with_box,
    sphere_with_sphere,
)
from bullet_sim.engine.quickstep.trees import mesh_with_mesh, mesh_with_solid
from bullet_sim.engine.quickstep.vectors import copy, cross, rotate
from bullet_sim.pose import Array

_softness = compiled(softness)


@compiled
def _add_contact(
    step: float,
    n: int,
    contacts: Array,
    owners: Array,
    bodies: Array,
    shapes: Array,
    s: int,
    planes: Array,
    p: int,
    body: int,
    point: Array,
    depth: float,
    work: Array,
) -> None:
    """Contact of a shape with a plane, row n."""
    row, plane, shape = contacts[n], planes[p], shapes[s]
    owners[n, 0], owners[n, 1], owners[n, 2], owners[n, 3] = body, -1, s, p
    for k in range(3):
        row[C_POINT + k], row[C_NORMAL + k] = point[k], plane[P_PLANE + k]
        row[C_FDIR + k] = 0.0
    row[C_DEPTH] = depth - bodies[body, MIN_DEPTH]
    for k in range(2):
        row[C_MU + k] = min(shape[G_MU + k], plane[P_MU + k])
        row[C_SLIP + k] = shape[G_SLIP + k] + plane[P_SLIP + k]
    row[C_ERP], row[C_CFM] = _softness(step, shape[G_KP], shape[G_KD], plane[P_KP], plane[P_KD])
    row[C_MAX] = bodies[body, MAX_VEL]
    if shape[G_FDIR] != 0.0 or shape[G_FDIR + 1] != 0.0 or shape[G_FDIR + 2] != 0.0:
        across = temporary(3)
        rotate(shape[G_ROTATION : G_ROTATION + 9], shape[G_FDIR : G_FDIR + 3], across)
        rotate(work[body, W_R : W_R + 9], across, row[C_FDIR : C_FDIR + 3])
    elif plane[P_FDIR] != 0.0 or plane[P_FDIR + 1] != 0.0 or plane[P_FDIR + 2] != 0.0:
        copy(plane[P_FDIR : P_FDIR + 3], row[C_FDIR : C_FDIR + 3])


@compiled
def _vertex_contacts(
    step: float,
    n: int,
    s: int,
    p: int,
    below: float,
    body: int,
    bodies: Array,
    scene: Scene,
    contacts: Array,
    owners: Array,
    work: Array,
) -> int:
    """Contacts of the vertices of a mesh with a plane; the number of all contacts then.

    The first ten below the plane; if there are more, the deepest of the rest in place of the tenth.
    Only the first MOST_FOUND count.
    """
    offset, at, local = temporary(3), temporary(3), temporary(3)
    found, seen, deepest, last = 0, 0, 0.0, n
    planes = scene.planes
    a, b, c = planes[p, 0], planes[p, 1], planes[p, 2]
    for k in range(3):  # the plane's normal in the body
        local[k] = (
            work[body, W_R + k] * a + work[body, W_R + 3 + k] * b + work[body, W_R + 6 + k] * c
        )
    first, end = scene.kinds[s, 2], scene.kinds[s, 3]
    for start in range(first, end, CHUNK):
        box = scene.chunks[scene.kinds[s, 4] + (start - first) // CHUNK]
        highest = below + ROUNDING
        for k in range(3):
            highest += abs(local[k]) * box[3 + k] - local[k] * box[k]
        if highest <= 0.0:
            continue
        for v in range(start, min(start + CHUNK, end)):
            point = scene.points[v]
            depth = below - (local[0] * point[0] + local[1] * point[1] + local[2] * point[2])
            if depth < -ROUNDING:
                continue
            rotate(work[body, W_R : W_R + 9], point, offset)
            depth = below - (a * offset[0] + b * offset[1] + c * offset[2])
            if depth <= 0.0:
                continue
            seen += 1
            if seen > MOST_FOUND:
                return n
            if found >= MESH_CONTACTS and depth <= deepest:
                continue
            for k in range(3):
                at[k] = bodies[body, POS + k] + offset[k]
            if found < MESH_CONTACTS:
                last, found = n, found + 1
                n += 1
                deepest = depth
            deepest = max(deepest, depth)
            _add_contact(step, last, contacts, owners, bodies, scene.shapes, s, planes, p, body, at,
                         depth, work)  # fmt: skip
    return n


@compiled
def _box_contacts(
    step: float,
    n: int,
    s: int,
    p: int,
    below: float,
    center: Array,
    body: int,
    bodies: Array,
    shapes: Array,
    planes: Array,
    contacts: Array,
    owners: Array,
    work: Array,
) -> int:
    """Contacts of a box with a plane: the deepest corner, its neighbors along the two sides that
    are the least inclined, and the corner opposite to it; the number of all contacts then.

    Args:
        below: depth of its center [m].
    """
    sides, edge, corner, point = temporary(3, 3), temporary(3), temporary(3), temporary(3)
    rise = temporary(3)
    depth = below
    for k in range(3):
        corner[k] = center[k]
    for i in range(3):  # sides that point up from the deepest corner
        for k in range(3):
            edge[k] = shapes[s, G_ROTATION + 3 * k + i]
        rotate(work[body, W_R : W_R + 9], edge, sides[i])
        along = 0.0
        for k in range(3):
            along += planes[p, k] * sides[i, k]
        size = shapes[s, G_SIZE + i]
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
    _add_contact(step, n, contacts, owners, bodies, shapes, s, planes, p, body, corner, depth,
                 work)  # fmt: skip
    n += 1
    for i in range(2):
        if depth - rise[order[i]] < 0.0:
            return n
        for k in range(3):
            point[k] = corner[k] + sides[order[i], k]
        _add_contact(step, n, contacts, owners, bodies, shapes, s, planes, p, body, point,
                     depth - rise[order[i]], work)  # fmt: skip
        n += 1
    depth -= rise[order[0]] + rise[order[1]]
    if depth > 0.0:
        for k in range(3):
            point[k] += sides[order[0], k]
        _add_contact(step, n, contacts, owners, bodies, shapes, s, planes, p, body, point, depth,
                     work)  # fmt: skip
        n += 1
    return n


@compiled
def _axis_of(s: int, body: int, shapes: Array, plane: Array, work: Array, axis: Array) -> float:
    """A cylinder's axis; the cosine between it and a plane's normal."""
    for k in range(3):
        axis[k] = shapes[s, G_ROTATION + 3 * k + 2]
    rotate(work[body, W_R : W_R + 9], axis, axis)
    return axis[0] * plane[0] + axis[1] * plane[1] + axis[2] * plane[2]


@compiled
def _lowest_line(
    s: int, center: Array, axis: Array, along: float, shapes: Array, plane: Array, ends: Array
) -> None:
    """The line of a cylinder that is deepest below a plane, (2, 3); axis, along: _axis_of()."""
    rim = temporary(3)
    for k in range(3):
        rim[k] = axis[k] * along - plane[k]
    length = math.sqrt(rim[0] ** 2 + rim[1] ** 2 + rim[2] ** 2)
    radius, half = shapes[s, G_SIZE], 0.5 * shapes[s, G_SIZE + 1]
    for k in range(3):
        ends[0, k] = center[k] + half * axis[k] + rim[k] * (radius / length)
        ends[1, k] = center[k] - half * axis[k] + rim[k] * (radius / length)


@compiled
def _cylinder_contacts(
    step: float,
    n: int,
    s: int,
    p: int,
    center: Array,
    body: int,
    bodies: Array,
    shapes: Array,
    planes: Array,
    contacts: Array,
    owners: Array,
    work: Array,
) -> int:
    """Contacts of a cylinder with a plane: the lowest point of each rim, or four of the lower disc
    if it stands; the number of all contacts then."""
    axis, rim, other, point = temporary(3), temporary(3), temporary(3), temporary(3)
    a, b, c, d = planes[p, 0], planes[p, 1], planes[p, 2], planes[p, 3]
    radius, half = shapes[s, G_SIZE], 0.5 * shapes[s, G_SIZE + 1]
    along = _axis_of(s, body, shapes, planes[p], work, axis)
    if abs(abs(along) - 1.0) < PARALLEL:
        sign = -1.0 if along > 0.0 else 1.0
        for k in range(3):
            point[k] = center[k] + sign * half * axis[k]
        if d - (a * point[0] + b * point[1] + c * point[2]) < 0.0:
            return n
        for k in range(3):
            other[k] = axis[k]
        other[0 if abs(axis[0]) < PARALLEL else 1] += 1.0
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
                _add_contact(step, n, contacts, owners, bodies, shapes, s, planes, p, body, point,
                             depth, work)  # fmt: skip
                n += 1
        return n
    ends = temporary(2, 3)
    _lowest_line(s, center, axis, along, shapes, planes[p], ends)
    for end in (1, 0):
        depth = d - (a * ends[end, 0] + b * ends[end, 1] + c * ends[end, 2])
        if depth >= 0.0:
            _add_contact(step, n, contacts, owners, bodies, shapes, s, planes, p, body, ends[end],
                         depth, work)  # fmt: skip
            n += 1
    return n


@compiled
def _add_points(
    step: float,
    n: int,
    points: Array,
    count: int,
    normal: Array,
    sign: float,
    s: int,
    body: int,
    surfaces: Array,
    p: int,
    other: int,
    bodies: Array,
    scene: Scene,
    contacts: Array,
    owners: Array,
    work: Array,
) -> int:
    """Contacts of shape s of a body at points (count, 4), with `sign` times a normal, with surface
    p of what `other` is the number of; the number of all then."""
    for i in range(count):
        if n >= len(contacts):
            break
        _add_contact(step, n, contacts, owners, bodies, scene.shapes, s, surfaces, p, body,
                     points[i, :3], points[i, 3], work)  # fmt: skip
        for k in range(3):
            contacts[n, C_NORMAL + k] = sign * normal[k]
        owners[n, 2], owners[n, 3] = -1, other
        n += 1
    return n


@compiled
def _contacts_of_mesh(
    step: float,
    n: int,
    s: int,
    b: int,
    body: int,
    bodies: Array,
    scene: Scene,
    contacts: Array,
    owners: Array,
    work: Array,
) -> int:
    """As _solid_contacts(), where one of both is a mesh."""
    a, found = scene.solid_of[s], scene.trees.found
    mine, its, trees = scene.solids[a], scene.solids[b], scene.trees
    kind, other, sign = scene.solid_kinds[a], scene.solid_kinds[b], -1.0
    if kind != MESH:
        sign = 1.0
        count = mesh_with_solid(its, scene.roots[b], mine, kind, trees, found)
    elif other != MESH:
        count = mesh_with_solid(mine, scene.roots[a], its, other, trees, found)
    else:  # what was there first is the first
        count = mesh_with_mesh(its, scene.roots[b], mine, scene.roots[a], trees, found)
    point = temporary(1, 4)
    for i in range(count):
        for k in range(3):
            point[0, k] = found[i, k]
        point[0, 3] = found[i, F_DEPTH]
        n = _add_points(step, n, point, 1, found[i, F_NORMAL : F_NORMAL + 3], sign, s, body,
                       scene.faces, b, scene.owners[b], bodies, scene, contacts, owners,
                       work)  # fmt: skip
    return n


@compiled
def _solid_contacts(
    step: float,
    n: int,
    s: int,
    b: int,
    body: int,
    bodies: Array,
    scene: Scene,
    contacts: Array,
    owners: Array,
    work: Array,
) -> int:
    """Contacts of a shape of a body with a solid; the number of all then."""
    a = scene.solid_of[s]
    if scene.solid_kinds[a] == MESH or scene.solid_kinds[b] == MESH:
        return _contacts_of_mesh(step, n, s, b, body, bodies, scene, contacts, owners, work)
    one, two, kind, other = (
        scene.solids[a],
        scene.solids[b],
        scene.solid_kinds[a],
        scene.solid_kinds[b],
    )
    points, normal, sign = temporary(16, 4), temporary(3), 1.0
    if kind == BOX and other != BOX or kind == SPHERE and other == CYLINDER:
        one, two, kind, other, sign = two, one, other, kind, -1.0
    if kind == BOX:
        count = box_with_box(one, two, points, normal)
    elif kind == SPHERE:
        if other == BOX:
            count = sphere_with_box(one, two, points, normal)
        else:
            count = sphere_with_sphere(one, two, points, normal)
    elif other == BOX:
        count = cylinder_with_box(one, two, points, normal)
    elif other == SPHERE:
        count = cylinder_with_sphere(one, two, points, normal)
    else:
        sign = -1.0  # what was there first is the first, whose way to the contact differs
        count = cylinder_with_cylinder(two, one, points, normal)
    return _add_points(step, n, points, count, normal, sign, s, body, scene.faces, b,
                       scene.owners[b], bodies, scene, contacts, owners, work)  # fmt: skip


@compiled
def place_solids(bodies: Array, scene: Scene, work: Array) -> None:
    """Put the solids of bodies, and their directions of friction, where they are."""
    across = temporary(3)
    for s in range(len(scene.solid_of)):
        b = scene.solid_of[s]
        if b < 0:
            continue
        body, shape = scene.kinds[s, 0], scene.shapes[s]
        turn, solid = work[body, W_R : W_R + 9], scene.solids[b]
        rotate(turn, shape[G_OFFSET : G_OFFSET + 3], solid[B_CENTER : B_CENTER + 3])
        rotate(shape[G_ROTATION : G_ROTATION + 9], shape[G_FDIR : G_FDIR + 3], across)
        rotate(turn, across, scene.faces[b, P_FDIR : P_FDIR + 3])
        for i in range(3):
            solid[B_CENTER + i] += bodies[body, POS + i]
            for j in range(3):
                total = 0.0
                for k in range(3):
                    total += turn[3 * i + k] * shape[G_ROTATION + 3 * k + j]
                solid[B_ROTATION + 3 * i + j] = total


@compiled
def _plane_contacts(
    step: float,
    n: int,
    s: int,
    p: int,
    body: int,
    bodies: Array,
    scene: Scene,
    contacts: Array,
    owners: Array,
    work: Array,
) -> int:
    """Contacts of a shape of a body with a plane; the number of all then."""
    shapes, kind, planes = scene.shapes, scene.kinds[s, 1], scene.planes
    center, point = temporary(3), temporary(3)
    center[:] = 0.0
    if kind != MESH:
        rotate(work[body, W_R : W_R + 9], shapes[s, G_OFFSET : G_OFFSET + 3], center)
    below = planes[p, P_PLANE + 3]
    for k in range(3):
        center[k] += bodies[body, POS + k]
        below -= planes[p, k] * center[k]
    if below + bodies[body, RADIUS] < 0.0:
        return n
    if kind == MESH:
        return _vertex_contacts(step, n, s, p, below, body, bodies, scene, contacts, owners, work)
    if kind == CYLINDER:
        return _cylinder_contacts(step, n, s, p, center, body, bodies, shapes, planes, contacts,
                                  owners, work)  # fmt: skip
    if kind == BOX:
        return _box_contacts(step, n, s, p, below, center, body, bodies, shapes, planes, contacts,
                             owners, work)  # fmt: skip
    depth = below + shapes[s, G_SIZE]
    if depth < 0.0:
        return n
    for k in range(3):
        point[k] = center[k] - planes[p, k] * shapes[s, G_SIZE]
    _add_contact(step, n, contacts, owners, bodies, shapes, s, planes, p, body, point, depth,
                work)  # fmt: skip
    return n + 1


@compiled
def find_contacts(
    step: float,
    bodies: Array,
    sequence: Array,
    scene: Scene,
    contacts: Array,
    owners: Array,
    start: int,
    work: Array,
) -> int:
    """Contacts from row `start`, in Gazebo's order; the number of all."""
    n, pairs = start, scene.pairs
    for i in range(list_pairs(bodies, sequence, scene)):
        if n + 16 > len(contacts):
            break
        s, b, other = pairs[i, 0], pairs[i, 1], pairs[i, 2]
        body = scene.kinds[s, 0]
        if b < 0:
            n = _plane_contacts(step, n, s, -1 - b, body, bodies, scene, contacts, owners,
                                work)  # fmt: skip
            continue
        first = n
        n = _solid_contacts(step, n, s, b, body, bodies, scene, contacts, owners, work)
        if other < 0:
            continue
        for j in range(first, n):
            owners[j, 1] = other
            contacts[j, C_MAX] = min(bodies[body, MAX_VEL], bodies[other, MAX_VEL])
            left = min(bodies[body, MIN_DEPTH], bodies[other, MIN_DEPTH])
            contacts[j, C_DEPTH] += bodies[body, MIN_DEPTH] - left
    return n
