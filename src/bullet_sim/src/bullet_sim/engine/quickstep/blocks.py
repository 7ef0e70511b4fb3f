"""The solver's iteration: constraint rows in blocks, each of which is solved at once.

A projected Gauss-Seidel iteration takes row after row, and each row needs what the rows before it
have changed: a processor waits for one result after the other. Rows that connect the same two
bodies depend on each other in a way that is known before: row i sees row k < i as J_i M_k times
what k has changed. So the rows of a joint, of which only the last may have bounds, are replaced by
their forward substitution (the lower triangle of the block's matrix inverted): then they all start
from the same velocities, and their result is that of one after the other. Two rows of contacts
that follow each other on the same bodies have bounds both; the second is corrected by what the
first has changed. Both solutions (the one that moves the bodies, and the one whose push is bounded)
are computed side by side in four lanes, two rows each.

Blocks of different bodies do not depend on each other. So joints, normals and friction are each
sorted by how many blocks have to be solved before one: what is solved next has other bodies, as
far as there are any, and a processor works on several at once. The result is the same, to the bit.

Source: Y. Saad, "Iterative Methods for Sparse Linear Systems" (2003), section 4.1 (block
Gauss-Seidel).
"""

from bullet_sim.engine.quickstep import layout as col
from bullet_sim.engine.quickstep.compiled import compiled, inlined, temporary
from bullet_sim.engine.quickstep.lanes import (
    first_two,
    greatest,
    last_two,
    least,
    load,
    load_twice,
    store,
)
from bullet_sim.engine.quickstep.state import Blocks, Islands
from bullet_sim.pose import Array

_ROWS = col.BLOCK_ROWS  # for temporary()


@compiled
def _pack_joint(
    at: int, first: int, count: int, rows: Array, links: Array, numbers: Array, scratch: Array
) -> bool:
    """Rows of a joint into its block, where the last is the sixth; whether one has a CFM."""
    block, soft = numbers[at : at + col.JB_SIZE], False
    block[: col.JB_LOW] = 0.0
    block[col.JB_LOW : col.JB_HIGH] = -col.INFINITE
    block[col.JB_HIGH : col.JB_CFM] = col.INFINITE
    for i in range(count):
        row, place = rows[first + i], i if i < count - 1 else col.BLOCK_ROWS - 1
        if place == col.BLOCK_ROWS - 1:
            for k in range(2):
                block[col.JB_LOW + 2 + k] = row[col.R_LOW]
                block[col.JB_HIGH + 2 + k] = row[col.R_HIGH]
        mine = scratch[i]
        for k in range(12):
            mine[k] = row[col.R_J + k]
        mine[12], mine[13] = row[col.R_RHS], row[col.R_RHS + 1]
        mine[14:] = 0.0
        mine[14 + place] = row[col.R_CFM]
        soft = soft or row[col.R_CFM] != 0.0
        for j in range(i):
            other = rows[first + j]
            factor = 0.0
            for k in range(12):
                factor += row[col.R_J + k] * other[col.R_M + k]
            theirs = scratch[j]
            for k in range(20):
                mine[k] -= factor * theirs[k]
        lanes = block[48 * (place // 2) + 2 * (place % 2) :]
        pushes = block[col.JB_M + 24 * place :]
        for k in range(12):
            lanes[4 * k] = lanes[4 * k + 1] = mine[k]
            pushes[2 * k] = pushes[2 * k + 1] = row[col.R_M + k]
        for k in range(2):
            block[col.JB_RHS + 2 * place + k] = mine[12 + k]
            block[col.JB_L + 2 * place + k] = row[col.R_L + k]
        links[first + i, 5] = at + col.JB_L + 2 * place
    if soft:
        block[col.JB_CFM :] = 0.0
        for i in range(count):
            place = i if i < count - 1 else col.BLOCK_ROWS - 1
            lanes = block[col.JB_CFM + 4 * (place // 2) + 2 * (place % 2) :]
            for k in range(col.BLOCK_ROWS):
                lanes[12 * k] = lanes[12 * k + 1] = scratch[i, 14 + k]
    return soft


@compiled
def _is_bounded(row: Array) -> bool:
    return bool(row[col.R_LOW] > -col.INFINITE or row[col.R_HIGH] < col.INFINITE)


@compiled
def _pack_contact(at: int, one: int, two: int, rows: Array, links: Array, numbers: Array) -> None:
    """One row of a contact, or two (two >= 0), into a block."""
    block = numbers[at : at + col.CB_SIZE]
    block[:] = 0.0
    for place in range(2 if two >= 0 else 1):
        i = one if place == 0 else two
        row, lanes, pushes = rows[i], block[2 * place :], block[col.CB_M + 24 * place :]
        for k in range(12):
            lanes[4 * k] = lanes[4 * k + 1] = row[col.R_J + k]
            pushes[2 * k] = pushes[2 * k + 1] = row[col.R_M + k]
        for k in range(2):
            lanes[col.CB_RHS + k], lanes[col.CB_L + k] = row[col.R_RHS + k], row[col.R_L + k]
            lanes[col.CB_CFM + k] = row[col.R_CFM]
            lanes[col.CB_LOW + k], lanes[col.CB_HIGH + k] = row[col.R_LOW], row[col.R_HIGH]
        links[i, 5] = at + col.CB_L + 2 * place
    if two >= 0:
        factor = 0.0
        for k in range(12):
            factor += rows[two, col.R_J + k] * rows[one, col.R_M + k]
        block[col.CB_COUPLING + 2] = block[col.CB_COUPLING + 3] = factor


@compiled
def _place(block: Array, at: int, row: int, pair: bool, links: Array, nobody: int) -> None:
    one, two = links[row, 0], links[row, 1]
    block[col.BLOCK_AT], block[col.BLOCK_ONE] = at, one * col.W_SIZE + col.W_A
    block[col.BLOCK_TWO] = (two if two >= 0 else nobody) * col.W_SIZE + col.W_A
    block[col.BLOCK_BOTH], block[col.BLOCK_PAIR], block[col.BLOCK_NORMAL] = two >= 0, pair, -1
    if links[row, 2] >= 0:
        block[col.BLOCK_NORMAL] = links[links[row, 2], 5]


@compiled
def _sort(group: int, first: int, last: int, blocks: Blocks) -> None:
    """Blocks of a group of islands from `first` to before `last`, sorted by their levels."""
    places, unsorted, levels = blocks.places, blocks.unsorted, blocks.levels
    counts = blocks.counts[first + group :]  # one more than it has blocks
    for i in range(first, last):
        levels[places[i, col.BLOCK_ONE] // col.W_SIZE] = 0
        levels[places[i, col.BLOCK_TWO] // col.W_SIZE] = 0
    deepest = 0
    for i in range(first, last):
        block = unsorted[i]
        for k in range(col.BLOCK_SIZE):
            block[k] = places[i, k]
        one, two = block[col.BLOCK_ONE] // col.W_SIZE, block[col.BLOCK_TWO] // col.W_SIZE
        level = levels[one]
        if block[col.BLOCK_BOTH]:
            level = max(level, levels[two])
            levels[two] = level + 1
        levels[one] = level + 1
        block[col.BLOCK_LEVEL] = level
        deepest = max(deepest, level)
    for level in range(deepest + 2):
        counts[level] = 0
    for i in range(first, last):
        counts[unsorted[i, col.BLOCK_LEVEL] + 1] += 1
    for level in range(deepest):
        counts[level + 1] += counts[level]
    for i in range(first, last):
        level = unsorted[i, col.BLOCK_LEVEL]
        for k in range(col.BLOCK_SIZE):
            places[first + counts[level], k] = unsorted[i, k]
        counts[level] += 1


@compiled
def pack(group: int, rows: Array, links: Array, blocks: Blocks, islands: Islands) -> None:
    """Blocks of the rows of a group of islands.

    Args:
        links: gets where the rows' impulses are in the blocks.
    """
    places, numbers, starts = blocks.places, blocks.numbers, islands.starts
    scratch, nobody = temporary(_ROWS, 20), len(blocks.work) // col.W_SIZE - 1
    begin, m, ends = starts[group, col.I_ROW], starts[group + 1, col.I_ROW], starts[group]
    n, at, i = begin, starts[group, col.I_NUMBER], begin
    while i < m:
        if links[i, 2] != col.BILATERAL:
            i += 1
            continue
        count = 1
        while (
            count < col.BLOCK_ROWS
            and i + count < m
            and links[i + count, 3] == links[i, 3]
            and not _is_bounded(rows[i + count - 1])
        ):
            count += 1
        soft = _pack_joint(at, i, count, rows, links, numbers, scratch)
        _place(places[n], at, i, soft, links, nobody)
        n, at, i = n + 1, at + col.JB_SIZE, i + count
    ends[col.I_ENDS] = n
    _sort(group, begin, n, blocks)
    for friction in range(2):
        waiting = -1  # a row that makes a block with the next one, if that is of the same bodies
        for turn in range(begin, m + 1):
            i = -1 if turn == m else turn if friction else m - 1 - (turn - begin)
            if i >= 0 and (links[i, 2] < 0 if friction else links[i, 2] != col.UNILATERAL):
                continue
            if waiting < 0:
                waiting = i
                continue
            pair = i >= 0 and links[i, 0] == links[waiting, 0] and links[i, 1] == links[waiting, 1]
            if friction and pair:
                pair = links[i, 2] == links[waiting, 2]
            _pack_contact(at, waiting, i if pair else -1, rows, links, numbers)
            _place(places[n], at, waiting, pair, links, nobody)
            n, at = n + 1, at + col.CB_SIZE
            waiting = -1 if pair else i
        _sort(group, ends[col.I_ENDS + friction], n, blocks)
        ends[col.I_ENDS + 1 + friction] = n


@compiled
def unpack(group: int, rows: Array, links: Array, blocks: Blocks, islands: Islands) -> None:
    """Impulses of the rows of a group of islands from their blocks."""
    for i in range(islands.starts[group, col.I_ROW], islands.starts[group + 1, col.I_ROW]):
        for k in range(2):
            rows[i, col.R_L + k] = blocks.numbers[links[i, 5] + k]


@inlined
def _solve_joint(block: Array, n: Array, w: Array) -> None:
    """Solve a joint's block: the residuals of all rows, the bounds of the last, the changes.

    Args:
        block: row of places.
        n, w: numbers and working values, see Blocks.
    """
    at, one, two = block[col.BLOCK_AT], block[col.BLOCK_ONE], block[col.BLOCK_TWO]
    # x, y, z: two rows each; u, v, t: what the second body has of them
    x, y, z = load(n, at + col.JB_RHS), load(n, at + col.JB_RHS + 4), load(n, at + col.JB_RHS + 8)
    a = load_twice(w, two)
    u, v, t = a * load(n, at + 24), a * load(n, at + 72), a * load(n, at + 120)
    a = load_twice(w, one)
    x, y, z = x - a * load(n, at), y - a * load(n, at + 48), z - a * load(n, at + 96)
    for k in range(1, 6):
        a, b = load_twice(w, one + 2 * k), load_twice(w, two + 2 * k)
        x, u = x - a * load(n, at + 4 * k), u + b * load(n, at + 24 + 4 * k)
        y, v = y - a * load(n, at + 48 + 4 * k), v + b * load(n, at + 72 + 4 * k)
        z, t = z - a * load(n, at + 96 + 4 * k), t + b * load(n, at + 120 + 4 * k)
    x, y, z = x - u, y - v, z - t
    if block[col.BLOCK_PAIR]:  # it has a CFM
        for k in range(col.BLOCK_ROWS):
            a, g = load_twice(n, at + col.JB_L + 2 * k), at + col.JB_CFM + 12 * k
            x, y, z = x - a * load(n, g), y - a * load(n, g + 4), z - a * load(n, g + 8)
    old = load(n, at + col.JB_L + 8)
    new = old + z
    new = least(greatest(new, load(n, at + col.JB_LOW)), load(n, at + col.JB_HIGH))
    z = new - old
    store(n, at + col.JB_L, load(n, at + col.JB_L) + x)
    store(n, at + col.JB_L + 4, load(n, at + col.JB_L + 4) + y)
    store(n, at + col.JB_L + 8, new)
    a, b, c, d, e, f = (
        first_two(x), last_two(x), first_two(y), last_two(y), first_two(z), last_two(z),
    )  # fmt: skip
    for k in range(0, 12, 4):
        g = at + col.JB_M + k
        t = load(w, one + k) + a * load(n, g)
        u = b * load(n, g + 24) + c * load(n, g + 48)
        v = d * load(n, g + 72) + e * load(n, g + 96)
        store(w, one + k, (t + u) + (v + f * load(n, g + 120)))
    if not block[col.BLOCK_BOTH]:
        return
    for k in range(0, 12, 4):
        g = at + col.JB_M + 12 + k
        t = load(w, two + k) + a * load(n, g)
        u = b * load(n, g + 24) + c * load(n, g + 48)
        v = d * load(n, g + 72) + e * load(n, g + 96)
        store(w, two + k, (t + u) + (v + f * load(n, g + 120)))


@inlined
def _solve_contact(block: Array, n: Array, w: Array) -> None:
    """Solve a contact's block: its first row, and the second after what the first has changed;
    arguments as those of _solve_joint()."""
    at, one, two = block[col.BLOCK_AT], block[col.BLOCK_ONE], block[col.BLOCK_TWO]
    both, normal = block[col.BLOCK_BOTH], block[col.BLOCK_NORMAL]
    x, y = load(n, at + col.CB_RHS), load_twice(w, one + 6) * load(n, at + 12)
    for k in range(3):
        x -= load_twice(w, one + 2 * k) * load(n, at + 4 * k)
    for k in range(4, 6):
        y += load_twice(w, one + 2 * k) * load(n, at + 4 * k)
    if both:
        for k in range(6):
            x -= load_twice(w, two + 2 * k) * load(n, at + 24 + 4 * k)
    old = load(n, at + col.CB_L)
    x = (x - old * load(n, at + col.CB_CFM)) - y
    low, high = load(n, at + col.CB_LOW), load(n, at + col.CB_HIGH)
    if normal >= 0:
        push = load_twice(n, normal)
        low, high = low * push, high * push
        low, high = least(low, high), greatest(low, high)
    new = least(greatest(old + x, low), high)
    if block[col.BLOCK_PAIR]:
        x -= first_two(new - old) * load(n, at + col.CB_COUPLING)
        new = least(greatest(old + x, low), high)
    change = new - old
    store(n, at + col.CB_L, load(n, 0) * new + load(n, 4) * old)
    a, b = first_two(change), last_two(change)
    for k in range(0, 12, 4):
        g = at + col.CB_M + k
        store(w, one + k, load(w, one + k) + (a * load(n, g) + b * load(n, g + 24)))
    if both:
        for k in range(0, 12, 4):
            g = at + col.CB_M + 12 + k
            store(w, two + k, load(w, two + k) + (a * load(n, g) + b * load(n, g + 24)))


@compiled
def iterate(iterations: int, group: int, blocks: Blocks, islands: Islands) -> None:
    """Projected Gauss-Seidel on both solutions of a group of islands, then friction alone."""
    places, numbers, work, starts = blocks.places, blocks.numbers, blocks.work, islands.starts
    begin, joints = starts[group, col.I_ROW], starts[group, col.I_ENDS]
    normals, end = starts[group, col.I_ENDS + 1], starts[group, col.I_ENDS + 2]
    for iteration in range(iterations + col.FRICTION_ITERATIONS):
        if iteration < iterations:
            for i in range(begin, joints):
                _solve_joint(places[i], numbers, work)
        for i in range(joints if iteration < iterations else normals, end):
            _solve_contact(places[i], numbers, work)
