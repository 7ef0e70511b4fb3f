"""The contacts of one body, as sensors tell them."""

from bullet_sim.engine.quickstep import layout as col
from bullet_sim.engine.quickstep.compiled import compiled, temporary
from bullet_sim.engine.quickstep.state import Touching
from bullet_sim.engine.quickstep.vectors import matrix, rotate_back


@compiled
def list_contacts(row: int, touching: Touching) -> int:
    """Choose a body's contacts of the last step; how many there are.

    They are seen from the body: normals towards it, forces on it.
    """
    rows, owners, result, bodies, chosen, numbers = touching
    turn, arm, torque, n = temporary(9), temporary(3), temporary(3), 0
    body = bodies[row]
    matrix(body[col.QUAT : col.QUAT + 4], turn)
    for i in range(result[0]):
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
