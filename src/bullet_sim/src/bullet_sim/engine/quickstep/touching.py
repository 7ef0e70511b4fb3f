"""The contacts of one body, as sensors tell them."""

from bullet_sim.engine.quickstep import layout as col
from bullet_sim.engine.quickstep.compiled import compiled, temporary
from bullet_sim.engine.quickstep.order import looks, place_spaces
from bullet_sim.engine.quickstep.state import ContactRecords, Contacts, Scene, Touching
from bullet_sim.engine.quickstep.vectors import matrix, rotate_back
from bullet_sim.pose import Array


@compiled
def list_contacts(row: int, touching: Touching) -> int:
    """Choose a body's contacts of the last step; how many there are.

    They are seen from the body: normals towards it, forces on it.
    """
    rows, owners, result, bodies, chosen, numbers = touching
    return _list(row, result[0], rows, owners, bodies, chosen, numbers)


@compiled
def record_contacts(
    n: int, step: int, sequence: Array, bodies: Array, scene: Scene, contacts: Contacts,
    records: ContactRecords,
) -> None:  # fmt: skip
    """Record the contacts of some bodies after a step.

    Args:
        n: number of all contacts of the step.
        step: its number among the recorded ones.
    """
    begin = records.ends[step - 1] if step > 0 else 0
    place_spaces(bodies, sequence, scene)
    spaces = scene.spaces
    for row in records.bodies:
        chosen = records.chosen[begin:]
        count = _list(
            row, n, contacts.rows, contacts.owners, bodies, chosen, records.numbers[begin:]
        )
        own = scene.space_of[row]
        for i in range(count):
            owner = chosen[i]
            owner[col.CR_BODY] = row
            if owner[2] >= 0:
                met = scene.items[len(scene.solids) + owner[3], 0]
            elif owner[1] < 0:
                met = records.spaces[owner[3]]
            else:
                met = scene.space_of[owner[1] if owner[0] == row else owner[0]]
            is_large = met < 0 or spaces[met, col.K_LEVEL] > col.MAX_LEVEL
            owner[col.CR_FIRST] = is_large or looks(own, met, spaces)
        begin += count
    records.ends[step] = begin


@compiled
def _list(
    row: int, count: int, rows: Array, owners: Array, bodies: Array, chosen: Array, numbers: Array
) -> int:
    """See list_contacts(); count: of all contacts."""
    turn, arm, torque, n = temporary(9), temporary(3), temporary(3), 0
    body = bodies[row]
    matrix(body[col.QUAT : col.QUAT + 4], turn)
    for i in range(count):
        is_own = owners[i, 0] == row
        if not is_own and (owners[i, 1] != row or owners[i, 2] >= 0):
            continue
        sign, out = 1.0 if is_own else -1.0, numbers[n]
        for k in range(4):
            chosen[n, k] = owners[i, k]
        for k in range(3):
            out[k] = rows[i, col.C_POINT + k]
            out[3 + k] = sign * rows[i, col.C_NORMAL + k]
            out[7 + k] = sign * rows[i, col.C_FORCE + k]
            arm[k] = out[k] - body[col.POS + k]
        out[6] = rows[i, col.C_DEPTH]
        force = out[7:10]
        torque[0] = arm[1] * force[2] - arm[2] * force[1]
        torque[1] = arm[2] * force[0] - arm[0] * force[2]
        torque[2] = arm[0] * force[1] - arm[1] * force[0]
        rotate_back(turn, force, out[10:13])
        rotate_back(turn, torque, out[13:16])
        n += 1
    return n
