"""Rows of contacts: what a shape and the surface that it touches make of a point and a depth."""

from typing import NamedTuple

from bullet_sim.engine.quickstep import layout as col
from bullet_sim.engine.quickstep.compiled import compiled, temporary
from bullet_sim.engine.quickstep.vectors import copy, rotate
from bullet_sim.pose import Array

_softness, _torsion = compiled(col.softness), compiled(col.set_torsion)


class Table(NamedTuple):
    """Where contacts are put, and what their rows are computed of.

    Attributes:
        step: length of a step [s].
        bodies, work: of System.
        shapes: of Scene.
        rows, owners: of Contacts.
    """

    step: float
    bodies: Array
    work: Array
    shapes: Array
    rows: Array
    owners: Array


class Pair(NamedTuple):
    """What touches.

    Attributes:
        shape, body: numbers of a shape, and of its body.
        surfaces: planes or faces, of Scene.
        surface: row of what the shape touches in these.
    """

    shape: int
    body: int
    surfaces: Array
    surface: int


@compiled
def most_contacts(pair: Pair, table: Table) -> int:
    """Number of contacts that a pair has at most."""
    plane = pair.surfaces[pair.surface]
    return int(min(table.shapes[pair.shape, col.G_MOST], plane[col.P_MOST]))


@compiled
def keep_most(first: int, n: int, most: int, table: Table) -> int:
    """Keep `most` of the contacts from row `first` to before n: the first ones, the last of them in
    favour of the deepest of the rest; the number of all then."""
    if n - first <= most:
        return n
    if most <= 0:
        return first
    last = first + most - 1
    for i in range(last + 1, n):
        if table.rows[i, col.C_DEPTH] > table.rows[last, col.C_DEPTH]:
            copy(table.rows[i], table.rows[last])
            copy(table.owners[i], table.owners[last])
    return last + 1


@compiled
def add_contact(n: int, pair: Pair, point: Array, depth: float, table: Table) -> None:
    """Write row n: a contact of a shape with a plane, at a point [m], with a depth [m]."""
    row, plane, shape = table.rows[n], pair.surfaces[pair.surface], table.shapes[pair.shape]
    body, owners = pair.body, table.owners
    owners[n, 0], owners[n, 1], owners[n, 2], owners[n, 3] = body, -1, pair.shape, pair.surface
    for k in range(3):
        row[col.C_POINT + k], row[col.C_NORMAL + k] = point[k], plane[col.P_PLANE + k]
        row[col.C_FDIR + k] = 0.0
    row[col.C_DEPTH] = depth - table.bodies[body, col.MIN_DEPTH]
    for k in range(2):
        row[col.C_MU + k] = min(shape[col.G_MU + k], plane[col.P_MU + k])
        row[col.C_SLIP + k] = shape[col.G_SLIP + k] + plane[col.P_SLIP + k]
        row[col.C_BOUNCE + k] = min(shape[col.G_BOUNCE + k], plane[col.P_BOUNCE + k])
    row[col.C_ERP], row[col.C_CFM] = _softness(
        table.step, shape[col.G_KP], shape[col.G_KD], plane[col.P_KP], plane[col.P_KD]
    )
    row[col.C_MAX] = table.bodies[body, col.MAX_VEL]
    _torsion(row, shape, plane)
    own, other = col.G_FDIR, col.P_FDIR
    if shape[own] != 0.0 or shape[own + 1] != 0.0 or shape[own + 2] != 0.0:
        across = temporary(3)
        rotate(shape[col.G_ROTATION : col.G_ROTATION + 9], shape[own : own + 3], across)
        turn = table.work[body, col.W_R : col.W_R + 9]
        rotate(turn, across, row[col.C_FDIR : col.C_FDIR + 3])
    elif plane[other] != 0.0 or plane[other + 1] != 0.0 or plane[other + 2] != 0.0:
        copy(plane[other : other + 3], row[col.C_FDIR : col.C_FDIR + 3])


@compiled
def add_points(
    n: int,
    pair: Pair,
    points: Array,
    count: int,
    normal: Array,
    sign: float,
    owner: int,
    table: Table,
) -> int:
    """Contacts of a shape with a solid, from row n; the number of all then.

    Args:
        points: (count, 4) points and depths.
        normal: (3,) which counts `sign` times.
        owner: number of what the solid is of.
    """
    for i in range(count):
        if n >= len(table.rows):
            break
        add_contact(n, pair, points[i, :3], points[i, 3], table)
        for k in range(3):
            table.rows[n, col.C_NORMAL + k] = sign * normal[k]
        table.owners[n, 2], table.owners[n, 3] = -1, owner
        n += 1
    return n
