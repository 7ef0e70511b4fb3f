"""Contacts of all bodies, in the order in which Gazebo has them."""

from bullet_sim.engine.quickstep import layout as col
from bullet_sim.engine.quickstep.boxes import box_with_box
from bullet_sim.engine.quickstep.broadphase import list_pairs
from bullet_sim.engine.quickstep.compiled import compiled, inlined, switch, temporary
from bullet_sim.engine.quickstep.contacts import (
    Pair,
    Table,
    add_points,
    keep_most,
    most_contacts,
)
from bullet_sim.engine.quickstep.cylinders import cylinder_with_box
from bullet_sim.engine.quickstep.fields import field_contacts
from bullet_sim.engine.quickstep.mesh_pairs import mesh_with_mesh
from bullet_sim.engine.quickstep.meshes import mesh_with_solid
from bullet_sim.engine.quickstep.mpr import cylinder_with_cylinder
from bullet_sim.engine.quickstep.planes import plane_contacts
from bullet_sim.engine.quickstep.spheres import (
    cylinder_with_sphere,
    sphere_with_box,
    sphere_with_sphere,
)
from bullet_sim.engine.quickstep.state import Contacts, Scene, System
from bullet_sim.engine.quickstep.vectors import rotate
from bullet_sim.pose import Array

# (kind of a body's shape, kind of what it touches) -> (its collider, whether the latter is the
# first argument). A collider takes two rows of solids; it gives points and depths (16, 4), the
# normal (3,) towards its first argument, and their number.
COLLIDERS = {
    (col.CYLINDER, col.BOX): (cylinder_with_box, False),
    (col.CYLINDER, col.CYLINDER): (cylinder_with_cylinder, True),  # the older one, as in ODE
    (col.CYLINDER, col.SPHERE): (cylinder_with_sphere, False),
    (col.BOX, col.BOX): (box_with_box, False),
    (col.BOX, col.CYLINDER): (cylinder_with_box, True),
    (col.BOX, col.SPHERE): (sphere_with_box, True),
    (col.SPHERE, col.BOX): (sphere_with_box, False),
    (col.SPHERE, col.CYLINDER): (cylinder_with_sphere, True),
    (col.SPHERE, col.SPHERE): (sphere_with_sphere, False),
}
_KINDS = 3
_collide = switch({_KINDS * a + b: collider for (a, b), (collider, _) in COLLIDERS.items()})
_SWAPPED = sum(swapped << (_KINDS * a + b) for (a, b), (_, swapped) in COLLIDERS.items())  # bits


@compiled
def _mesh_contacts(n: int, pair: Pair, scene: Scene, table: Table) -> int:
    """As _solid_contacts(), where one of both is a mesh."""
    a, b, found = scene.solid_of[pair.shape], pair.surface, scene.trees.found
    mine, its, trees = scene.solids[a], scene.solids[b], scene.trees
    kind, other, sign = scene.solid_kinds[a], scene.solid_kinds[b], -1.0
    most = most_contacts(pair, table)
    if kind != col.MESH:
        sign = 1.0
        count = mesh_with_solid(its, scene.roots[b], mine, kind, trees, found, most)
    elif other != col.MESH:
        count = mesh_with_solid(mine, scene.roots[a], its, other, trees, found, most)
    else:  # what was there first is the first
        count = mesh_with_mesh(its, scene.roots[b], mine, scene.roots[a], trees, found, most)
    point = temporary(1, 4)
    for i in range(count):
        for k in range(3):
            point[0, k] = found[i, k]
        point[0, 3] = found[i, col.F_DEPTH]
        normal = found[i, col.F_NORMAL : col.F_NORMAL + 3]
        n = add_points(n, pair, point, 1, normal, sign, scene.owners[b], table)
    return n


@compiled
def _solid_contacts(n: int, pair: Pair, scene: Scene, table: Table) -> int:
    """Contacts of a shape of a body with a solid, from row n; the number of all then."""
    a, b = scene.solid_of[pair.shape], pair.surface
    kind, other = scene.solid_kinds[a], scene.solid_kinds[b]
    if other == col.FIELD:
        return field_contacts(n, pair, scene, table)
    if kind == col.MESH or other == col.MESH:
        return _mesh_contacts(n, pair, scene, table)
    points, normal, sign = temporary(16, 4), temporary(3), 1.0
    one, two, code = scene.solids[a], scene.solids[b], _KINDS * kind + other
    if (_SWAPPED >> code) & 1:
        one, two, sign = two, one, -1.0
    count = _collide(code, one, two, points, normal)
    end = add_points(n, pair, points, count, normal, sign, scene.owners[b], table)
    return keep_most(n, end, most_contacts(pair, table), table)


@inlined
def place_solids(system: System, scene: Scene) -> None:
    """Put the solids of bodies, and their directions of friction, where they are."""
    across = temporary(3)
    for s in range(len(scene.solid_of)):
        b = scene.solid_of[s]
        if b < 0:
            continue
        body, shape = scene.kinds[s, 0], scene.shapes[s]
        turn, solid = system.work[body, col.W_R : col.W_R + 9], scene.solids[b]
        offset = shape[col.G_OFFSET : col.G_OFFSET + 3]
        rotate(turn, offset, solid[col.B_CENTER : col.B_CENTER + 3])
        direction = shape[col.G_FDIR : col.G_FDIR + 3]
        rotate(shape[col.G_ROTATION : col.G_ROTATION + 9], direction, across)
        rotate(turn, across, scene.faces[b, col.P_FDIR : col.P_FDIR + 3])
        for i in range(3):
            solid[col.B_CENTER + i] += system.bodies[body, col.POS + i]
            for j in range(3):
                total = 0.0
                for k in range(3):
                    total += turn[3 * i + k] * shape[col.G_ROTATION + 3 * k + j]
                solid[col.B_ROTATION + 3 * i + j] = total


@inlined
def find_contacts(
    step: float, system: System, sequence: Array, scene: Scene, contacts: Contacts, start: int
) -> int:
    """Contacts from row `start`, in Gazebo's order; the number of all."""
    n, pairs, bodies, rows = start, scene.pairs, system.bodies, contacts.rows
    table = Table(step, bodies, system.work, scene.shapes, rows, contacts.owners)
    for i in range(list_pairs(bodies, sequence, scene)):
        if n + 16 > len(rows):
            break
        s, b, other = pairs[i, 0], pairs[i, 1], pairs[i, 2]
        body, first = scene.kinds[s, 0], n
        if b < 0:
            n = plane_contacts(n, Pair(s, body, scene.planes, -1 - b), scene, table)
        else:
            n = _solid_contacts(n, Pair(s, body, scene.faces, b), scene, table)
        for j in range(first, n):  # of the pair: each has its part of the force
            for k in range(2):
                rows[j, col.C_SLIP + k] *= n - first
        if b < 0 or other < 0:
            continue
        for j in range(first, n):
            contacts.owners[j, 1] = other
            rows[j, col.C_MAX] = min(bodies[body, col.MAX_VEL], bodies[other, col.MAX_VEL])
            left = min(bodies[body, col.MIN_DEPTH], bodies[other, col.MIN_DEPTH])
            rows[j, col.C_DEPTH] += bodies[body, col.MIN_DEPTH] - left
    return n
