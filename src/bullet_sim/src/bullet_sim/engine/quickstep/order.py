"""The order in which Gazebo looks at pairs of shapes, which is that of their contacts.

Each model has a space of its shapes, and so has each link that collides with its own model. ODE
finds close spaces by their cells: a space looks for others in its own cells and in larger ones, as
many meters wide as its level says; those that are too large for cells come last. In a space the
shape that was moved last is the first one; in a step, bodies move in the order of `sequence`, of
each the last shape first. What never moved since it was made has its last shape first, too.
"""

import math

from bullet_sim.engine.quickstep import layout as col
from bullet_sim.engine.quickstep.compiled import compiled, inlined
from bullet_sim.engine.quickstep.state import Scene
from bullet_sim.pose import Array


@inlined
def place_spaces(bodies: Array, sequence: Array, scene: Scene) -> None:
    """Set where the spaces of what moves are, their levels and the order in which ODE has them."""
    spaces = scene.spaces
    for k in range(scene.counts[2], len(spaces)):
        spaces[k, col.K_RANK] = -1.0
        for i in range(3):
            spaces[k, col.K_LOW + i], spaces[k, col.K_HIGH + i] = col.INFINITE, -col.INFINITE
    for rank in range(len(sequence)):
        b = sequence[rank]
        space = spaces[scene.space_of[b]]
        if bodies[b, col.ASLEEP] == 0.0 and space[col.K_RANK] < 0.0:
            space[col.K_RANK] = len(spaces) + rank
        for s in range(scene.firsts[b], scene.firsts[b + 1]):
            for i in range(3):
                low, high = scene.aabbs[s, i], scene.aabbs[s, 3 + i]
                if scene.kinds[s, 1] == col.SPHERE:
                    low = 0.5 * (low + high) - scene.shapes[s, col.G_SIZE]
                    high = low + 2.0 * scene.shapes[s, col.G_SIZE]
                space[col.K_LOW + i] = min(space[col.K_LOW + i], low)
                space[col.K_HIGH + i] = max(space[col.K_HIGH + i], high)
    for k in range(scene.counts[2], len(spaces)):
        size = 0.0
        for i in range(3):
            size = max(size, spaces[k, col.K_HIGH + i] - spaces[k, col.K_LOW + i])
        if spaces[k, col.K_RANK] < 0.0:  # it sleeps: it was moved before all others
            spaces[k, col.K_RANK] = k
        level, cell = col.MIN_LEVEL, 2.0**col.MIN_LEVEL
        while cell <= size and level <= col.MAX_LEVEL:
            level, cell = level + 1, 2.0 * cell
        spaces[k, col.K_LEVEL] = level


@inlined
def is_mixed(begin: int, n: int, pairs: Array) -> bool:
    """Whether pairs `begin` to before n have to be sorted: not all are with one shape that never
    moves."""
    for i in range(begin, n):
        if pairs[i, 1] != pairs[begin, 1] or pairs[i, 2] >= 0:
            return True
    return False


@inlined
def _item(pair: Array, scene: Scene) -> int:
    """Row of Scene.items of what a pair's shape meets."""
    return len(scene.solids) - 1 - pair[1] if pair[1] < 0 else pair[1]


@inlined
def _is_before(one: int, two: int, bodies: Array, scene: Scene) -> bool:
    """Whether a shape of a space that moves comes before another one of it."""
    a, b = scene.kinds[one, 0], scene.kinds[two, 0]
    if a != b:
        first, second = bodies[a, col.PLACE], bodies[b, col.PLACE]
        return first > second if first != second else a > b
    is_new = bodies[a, col.PLACE] == math.inf
    return one > two if is_new else one < two


@compiled
def _has_precedence(x: Array, y: Array, bodies: Array, scene: Scene) -> bool:
    """Whether Gazebo looks at pair x (3,) before pair y."""
    items, spaces = scene.items, scene.spaces
    at, to = _item(x, scene), _item(y, scene)
    own, other = scene.space_of[scene.kinds[x[0], 0]], scene.space_of[scene.kinds[y[0], 0]]
    met, other_met = items[at, 0], items[to, 0]
    one, one_met, two, two_met = x[0], items[at, 1], y[0], items[to, 1]
    if own == other_met and met == other:  # the same spaces, the other way round
        other, other_met, two, two_met = other_met, other, two_met, two
    if own != other or met != other_met:
        return _spaces_have_precedence(own, met, other, other_met, spaces)
    # the first of both spaces is in the outer loop if it has fewer shapes
    is_outer = spaces[own, col.K_COUNT] < spaces[met, col.K_COUNT]
    if spaces[own, col.K_COUNT] == spaces[met, col.K_COUNT]:
        is_outer = not looks(own, met, spaces)
    if one != two and (is_outer or one_met == two_met):
        return _is_before(one, two, bodies, scene)
    if x[2] >= 0 and one_met != two_met:
        return _is_before(one_met, two_met, bodies, scene)
    return bool(one_met < two_met)


@inlined
def looks(own: int, met: int, spaces: Array) -> bool:
    """Whether the first of two spaces finds the second one, rather than the other way round."""
    if spaces[own, col.K_LEVEL] > col.MAX_LEVEL or spaces[met, col.K_LEVEL] > col.MAX_LEVEL:
        return bool(spaces[own, col.K_LEVEL] <= col.MAX_LEVEL)
    if spaces[own, col.K_RANK] < spaces[met, col.K_RANK]:
        return bool(spaces[own, col.K_LEVEL] <= spaces[met, col.K_LEVEL])
    return bool(spaces[own, col.K_LEVEL] < spaces[met, col.K_LEVEL])


@compiled
def _spaces_have_precedence(own: int, met: int, other: int, other_met: int, spaces: Array) -> bool:
    """Whether the pair of the first two spaces comes before that of the others."""
    if not looks(own, met, spaces):
        own, met = met, own
    if not looks(other, other_met, spaces):
        other, other_met = other_met, other
    first, second = spaces[met, col.K_LEVEL], spaces[other_met, col.K_LEVEL]
    if (first > col.MAX_LEVEL) != (second > col.MAX_LEVEL):
        return bool(first <= col.MAX_LEVEL)
    if own != other:
        return bool(spaces[own, col.K_RANK] < spaces[other, col.K_RANK])
    if first > col.MAX_LEVEL:
        return bool(spaces[met, col.K_RANK] < spaces[other_met, col.K_RANK])
    if first != second:
        return bool(first < second)
    size = 2.0**first
    for i in range(3):
        start = spaces[own, col.K_LOW + i]
        one = math.floor(max(start, spaces[met, col.K_LOW + i]) / size)
        two = math.floor(max(start, spaces[other_met, col.K_LOW + i]) / size)
        if one != two:
            return bool(one < two)
    return bool(spaces[met, col.K_RANK] > spaces[other_met, col.K_RANK])


@compiled
def sort_pairs(begin: int, n: int, bodies: Array, scene: Scene) -> None:
    """Put pairs `begin` to before n in Gazebo's order."""
    pairs = scene.pairs
    for i in range(begin + 1, n):
        j = i
        while j > begin and _has_precedence(pairs[j], pairs[j - 1], bodies, scene):
            for k in range(3):
                pairs[j, k], pairs[j - 1, k] = pairs[j - 1, k], pairs[j, k]
            j -= 1
