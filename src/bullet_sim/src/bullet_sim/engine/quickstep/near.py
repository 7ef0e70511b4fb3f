"""What is near: which bodies have to be looked at, and whether the caller has to."""

from bullet_sim.engine.quickstep.compiled import compiled, inlined, temporary
from bullet_sim.engine.quickstep.layout import (
    APART,
    ASLEEP,
    B_CENTER,
    B_COLUMNS,
    B_HALF,
    B_ROTATION,
    COVERED,
    LEFT,
    MESH,
    OTHER,
    PARALLEL,
    POS,
    QUAT,
    RADIUS,
    Scene,
)
from bullet_sim.engine.quickstep.solids import box_overlap
from bullet_sim.engine.quickstep.vectors import matrix, overlap, rotate
from bullet_sim.pose import Array


@compiled
def _place_boxes(b: int, bodies: Array, scene: Scene) -> None:
    """Boxes around a body's shapes where they are."""
    turn = temporary(9)
    matrix(bodies[b, QUAT : QUAT + 4], turn)
    for s in range(scene.firsts[b], scene.firsts[b + 1]):
        for i in range(3):
            middle, reach = bodies[b, POS + i], 0.0
            for k in range(3):
                middle += turn[3 * i + k] * scene.extents[s, k]
                reach += abs(turn[3 * i + k]) * scene.extents[s, 3 + k]
            scene.around[s, i], scene.around[s, 3 + i] = middle - reach, middle + reach


@compiled
def _solid_around(s: int, body: Array, scene: Scene, solid: Array) -> None:
    """The box around a shape, turned with its body, as a row of solids."""
    turn = solid[B_ROTATION : B_ROTATION + 9]
    matrix(body[QUAT : QUAT + 4], turn)
    rotate(turn, scene.extents[s, :3], solid[B_CENTER : B_CENTER + 3])
    for k in range(3):
        solid[B_CENTER + k] += body[POS + k]
        solid[B_HALF + k] = scene.extents[s, 3 + k]


@compiled
def is_near(bodies: Array, scene: Scene) -> bool:
    """Whether a body may touch what the caller finds the contacts of; notes what else is close."""
    found, count = False, 0
    for b in range(len(bodies)):
        if bodies[b, RADIUS] <= 0.0:
            continue
        _place_boxes(b, bodies, scene)
        if bodies[b, ASLEEP] != 0.0 or found:
            continue
        for s in range(scene.firsts[b], scene.firsts[b + 1]):
            is_known = scene.kinds[s, 1] != OTHER
            if is_known and scene.counts[1] == 0:
                continue
            box = scene.around[s]
            if _is_near_still(box[:3], box[3:], is_known, scene.models[b], scene):
                found = True
    for b in range(len(bodies)):
        for other in range(b):
            if bodies[b, ASLEEP] * bodies[other, ASLEEP] != 0.0 or scene.meet[b, other] == APART:
                continue
            distance = 0.0
            for k in range(3):
                gap = bodies[b, POS + k] - bodies[other, POS + k]
                distance += gap * gap
            reach = bodies[b, RADIUS] + bodies[other, RADIUS]
            if distance > reach * reach or not _may_touch(b, other, bodies, scene):
                continue
            if scene.meet[b, other] == LEFT:
                found = True
            elif count < len(scene.close):
                scene.close[count, 0], scene.close[count, 1] = b, other
                count += 1
    scene.counts[0] = count
    return found


@compiled
def _may_touch(b: int, other: int, bodies: Array, scene: Scene) -> bool:
    """Whether boxes around shapes of two bodies, turned with them, overlap."""
    one, two, found = temporary(B_COLUMNS), temporary(B_COLUMNS), temporary(4)
    for s in range(scene.firsts[b], scene.firsts[b + 1]):
        box = scene.around[s]
        for t in range(scene.firsts[other], scene.firsts[other + 1]):
            if overlap(box[:3], box[3:], scene.around[t]):
                _solid_around(s, bodies[b], scene, one)
                _solid_around(t, bodies[other], scene, two)
                if box_overlap(one, two, PARALLEL, found) >= 0:
                    return True
    return False


@compiled
def _is_near_still(low: Array, high: Array, is_known: bool, model: int, scene: Scene) -> bool:
    """Whether a box around a shape overlaps what never moves and the caller has to look at."""
    for i in range(len(scene.covers)):
        if not overlap(low, high, scene.covers[i]):
            continue
        for at in range(i * COVERED, min((i + 1) * COVERED, len(scene.boxes))):
            if is_known and scene.contents[at] >= 0 or scene.hosts[at, 0] == model:
                continue
            if overlap(low, high, scene.boxes[at]):
                return True
    return False


@inlined
def _add_pair(pairs: Array, n: int, s: int, b: int, other: int) -> int:
    if n < len(pairs):
        pairs[n, 0], pairs[n, 1], pairs[n, 2] = s, b, other
        n += 1
    return n


@inlined
def _list_still(s: int, meshes: bool, n: int, kind: int, model: int, scene: Scene) -> int:
    """Append what never moves, but planes, and is near a shape; the number of all pairs then."""
    low, high = scene.around[s, :3], scene.around[s, 3:]
    for i in range(len(scene.covers)):
        if not overlap(low, high, scene.covers[i]):
            continue
        for at in range(i * COVERED, min((i + 1) * COVERED, len(scene.boxes))):
            b = scene.contents[at]
            if b < 0 or (kind == MESH or scene.solid_kinds[b] == MESH) != meshes:
                continue
            if scene.hosts[at, 0] == model or scene.hosts[at, 1] & scene.bits[s] == 0:
                continue
            if overlap(low, high, scene.boxes[at]):
                n = _add_pair(scene.pairs, n, s, b, -1)
    return n


@compiled
def _list_close(one: int, two: int, meshes: bool, n: int, scene: Scene) -> int:
    """Append pairs of shapes of two bodies, those of the body with fewer in the outer loop."""
    ends = scene.firsts[one], scene.firsts[one + 1], scene.firsts[two], scene.firsts[two + 1]
    swapped = ends[3] - ends[2] <= ends[1] - ends[0]
    outer = (ends[2], ends[3]) if swapped else (ends[0], ends[1])
    inner = (ends[0], ends[1]) if swapped else (ends[2], ends[3])
    for i in range(outer[0], outer[1]):
        for j in range(inner[0], inner[1]):
            s, t = (j, i) if swapped else (i, j)
            if (scene.kinds[s, 1] == MESH or scene.kinds[t, 1] == MESH) != meshes:
                continue
            box = scene.around[s]
            if overlap(box[:3], box[3:], scene.around[t]):
                n = _add_pair(scene.pairs, n, s, scene.solid_of[t], two)
    return n


@compiled
def list_pairs(bodies: Array, sequence: Array, scene: Scene) -> int:
    """Fill scene.pairs in the order of Gazebo's contacts; the number of them.

    Those with a mesh come after the others; first those of bodies that are close to each other,
    then with what never moves: bodies as in the last step, of a body the first shape first.
    """
    n, kinds, firsts, bits, pairs = 0, scene.kinds, scene.firsts, scene.bits, scene.pairs
    plane_bits, planes, still = scene.plane_bits, len(scene.planes), len(scene.covers) > 0
    for meshes in (False, True):
        for i in range(scene.counts[0]):
            n = _list_close(scene.close[i, 0], scene.close[i, 1], meshes, n, scene)
        for body in sequence:
            if bodies[body, ASLEEP] != 0.0:
                continue
            for s in range(firsts[body], firsts[body + 1]):
                kind = kinds[s, 1]
                if kind == OTHER:
                    continue
                for p in range(planes if (kind == MESH) == meshes else 0):
                    if plane_bits[p] & bits[s] != 0:
                        n = _add_pair(pairs, n, s, -1 - p, -1)
                if still:
                    n = _list_still(s, meshes, n, kind, scene.models[body], scene)
    return n
