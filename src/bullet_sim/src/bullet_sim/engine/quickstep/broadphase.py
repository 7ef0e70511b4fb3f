"""Which bodies are close to each other, and whether the caller has to look for contacts."""

import math

from bullet_sim.engine.quickstep import layout as col
from bullet_sim.engine.quickstep.boxes import box_overlap
from bullet_sim.engine.quickstep.compiled import compiled, inlined, temporary
from bullet_sim.engine.quickstep.order import is_mixed, place_spaces, sort_pairs
from bullet_sim.engine.quickstep.state import Scene
from bullet_sim.engine.quickstep.vectors import matrix, overlap, rotate
from bullet_sim.pose import Array

_SOLID = col.B_COLUMNS  # for temporary()


@compiled
def _place_boxes(b: int, bodies: Array, scene: Scene) -> None:
    """Boxes around a body's shapes where they are."""
    turn = temporary(9)
    matrix(bodies[b, col.QUAT : col.QUAT + 4], turn)
    for s in range(scene.firsts[b], scene.firsts[b + 1]):
        for i in range(3):
            middle, reach = bodies[b, col.POS + i], 0.0
            for k in range(3):
                middle += turn[3 * i + k] * scene.extents[s, k]
                reach += abs(turn[3 * i + k]) * scene.extents[s, 3 + k]
            scene.aabbs[s, i], scene.aabbs[s, 3 + i] = middle - reach, middle + reach


@compiled
def solid_around(s: int, body: Array, scene: Scene, solid: Array) -> None:
    """The box around a shape, turned with its body, as a row of solids."""
    turn = solid[col.B_ROTATION : col.B_ROTATION + 9]
    matrix(body[col.QUAT : col.QUAT + 4], turn)
    rotate(turn, scene.extents[s, :3], solid[col.B_CENTER : col.B_CENTER + 3])
    for k in range(3):
        solid[col.B_CENTER + k] += body[col.POS + k]
        solid[col.B_HALF + k] = scene.extents[s, 3 + k]


@compiled
def is_near(bodies: Array, scene: Scene) -> bool:
    """Whether a body may touch what the caller finds the contacts of; notes what else is close."""
    found, count = False, 0
    for b in range(len(bodies)):
        if bodies[b, col.RADIUS] <= 0.0:
            continue
        _place_boxes(b, bodies, scene)
        if bodies[b, col.ASLEEP] != 0.0 or found:
            continue
        for s in range(scene.firsts[b], scene.firsts[b + 1]):
            is_known = scene.kinds[s, 1] != col.OTHER
            if is_known and scene.counts[1] == 0:
                continue
            box = scene.aabbs[s]
            if _is_near_static(box[:3], box[3:], is_known, scene.models[b], scene):
                found = True
    for b in range(len(bodies)):
        for other in range(b):
            if bodies[b, col.ASLEEP] * bodies[other, col.ASLEEP] != 0.0:
                continue
            kind = scene.may_collide[b, other]
            if kind == col.PAIR_FILTERED:
                continue
            distance = 0.0
            for k in range(3):
                gap = bodies[b, col.POS + k] - bodies[other, col.POS + k]
                distance += gap * gap
            reach = bodies[b, col.RADIUS] + bodies[other, col.RADIUS]
            if not distance <= reach * reach or not _may_touch(b, other, bodies, scene):
                continue
            if kind == col.PAIR_EXTERNAL:
                found = True
            elif count < len(scene.close_pairs):
                scene.close_pairs[count, 0], scene.close_pairs[count, 1] = b, other
                count += 1
    scene.counts[0] = count
    return found


@compiled
def _may_touch(b: int, other: int, bodies: Array, scene: Scene) -> bool:
    """Whether boxes around shapes of two bodies, turned with them, overlap."""
    one, two, found = temporary(_SOLID), temporary(_SOLID), temporary(4)
    for s in range(scene.firsts[b], scene.firsts[b + 1]):
        box = scene.aabbs[s]
        for t in range(scene.firsts[other], scene.firsts[other + 1]):
            if overlap(box[:3], box[3:], scene.aabbs[t]):
                solid_around(s, bodies[b], scene, one)
                solid_around(t, bodies[other], scene, two)
                if box_overlap(one, two, col.PARALLEL, found) >= 0:
                    return True
    return False


@compiled
def _is_near_static(low: Array, high: Array, is_known: bool, model: int, scene: Scene) -> bool:
    """Whether a box around a shape overlaps what never moves and the caller has to look at."""
    for i in range(len(scene.aabb_groups)):
        if not overlap(low, high, scene.aabb_groups[i]):
            continue
        for at in range(i * col.AABB_GROUP, min((i + 1) * col.AABB_GROUP, len(scene.static_aabbs))):
            if is_known and scene.static_solid[at] >= 0 or scene.static_owner[at, 0] == model:
                continue
            if overlap(low, high, scene.static_aabbs[at]):
                return True
    return False


@inlined
def _add_pair(pairs: Array, n: int, s: int, b: int, other: int) -> int:
    if n < len(pairs):
        pairs[n, 0], pairs[n, 1], pairs[n, 2] = s, b, other
        n += 1
    return n


@inlined
def _list_static(s: int, meshes: bool, n: int, kind: int, model: int, scene: Scene) -> int:
    """Append what never moves, but planes, and is near a shape; the number of all pairs then."""
    low, high = scene.aabbs[s, :3], scene.aabbs[s, 3:]
    for i in range(len(scene.aabb_groups)):
        if not overlap(low, high, scene.aabb_groups[i]):
            continue
        for at in range(i * col.AABB_GROUP, min((i + 1) * col.AABB_GROUP, len(scene.static_aabbs))):
            b = scene.static_solid[at]
            if b < 0 or (kind == col.MESH or scene.solid_kinds[b] == col.MESH) != meshes:
                continue
            if scene.static_owner[at, 0] == model or scene.static_owner[at, 1] & scene.bits[s] == 0:
                continue
            if overlap(low, high, scene.static_aabbs[at]):
                n = _add_pair(scene.pairs, n, s, b, -1)
    return n


@compiled
def _list_close(one: int, two: int, meshes: bool, n: int, scene: Scene) -> int:
    """Append pairs of shapes of two bodies."""
    for s in range(scene.firsts[one], scene.firsts[one + 1]):
        for t in range(scene.firsts[two], scene.firsts[two + 1]):
            if (scene.kinds[s, 1] == col.MESH or scene.kinds[t, 1] == col.MESH) != meshes:
                continue
            box = scene.aabbs[s]
            if overlap(box[:3], box[3:], scene.aabbs[t]):
                n = _add_pair(scene.pairs, n, s, scene.solid_of[t], two)
    return n


@compiled
def list_pairs(bodies: Array, sequence: Array, scene: Scene) -> int:
    """Fill scene.pairs in the order of Gazebo's contacts; the number of them.

    Those with a mesh come after the others.
    """
    n, kinds, firsts, bits, pairs = 0, scene.kinds, scene.firsts, scene.bits, scene.pairs
    plane_bits, planes = scene.plane_bits, len(scene.planes)
    has_static = len(scene.aabb_groups) > 0
    placed = False
    for meshes in (False, True):
        begin = n
        for i in range(scene.counts[0]):
            n = _list_close(scene.close_pairs[i, 0], scene.close_pairs[i, 1], meshes, n, scene)
        for body in sequence:
            if bodies[body, col.ASLEEP] != 0.0:
                continue
            is_new = bodies[body, col.PLACE] == math.inf
            for i in range(firsts[body], firsts[body + 1]):
                s = firsts[body] + firsts[body + 1] - 1 - i if is_new else i
                kind = kinds[s, 1]
                if kind == col.OTHER:
                    continue
                for p in range(planes if (kind == col.MESH) == meshes else 0):
                    if plane_bits[p] & bits[s] != 0:
                        n = _add_pair(pairs, n, s, -1 - p, -1)
                if has_static:
                    n = _list_static(s, meshes, n, kind, scene.models[body], scene)
        if is_mixed(begin, n, pairs):
            if not placed:
                place_spaces(bodies, sequence, scene)
                placed = True
            sort_pairs(begin, n, bodies, scene)
    return n
