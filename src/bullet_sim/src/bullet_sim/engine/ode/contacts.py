"""Contacts of the engine 'ode': those that the mirror finds, what is told of the last step's."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any, NamedTuple, Tuple, cast

import numpy as np

from bullet_sim.description.model import Surface
from bullet_sim.engine.api import BodyLink, Contact, ContactRows
from bullet_sim.engine.ode import tables
from bullet_sim.engine.ode.arrays import Arrays
from bullet_sim.engine.ode.owner import Owner
from bullet_sim.engine.ode.scene import MAX_POINTS, space_level
from bullet_sim.engine.quickstep import layout as q
from bullet_sim.engine.quickstep.library import contact_lister
from bullet_sim.engine.quickstep.state import Touching
from bullet_sim.pose import Array, Vec3, matrix_from_quaternion

_CLOSE = 0.002  # [m] between a contact that the mirror finds and the shape that it is with
_MAX_FOUND = 64 * MAX_POINTS  # contacts that the mirror finds
# Link, other link, point [m], normal towards the first, depth [m], force (3,) [N] on the first;
# world axes.
Point = Tuple[BodyLink, BodyLink, Vec3, Vec3, float, Array]


class _Step(NamedTuple):
    """Contacts of a step, of those that fell asleep in it."""

    rows: Array
    owners: Array
    others: list[BodyLink]


class Contacts:
    """Contacts of what moves."""

    def __init__(self, engine: Owner) -> None:
        self._engine = engine
        # of links that sleep: their contacts in the step in which they fell asleep; of those that
        # did so in one step they are chosen when they are asked for
        self._kept: dict[BodyLink, list[Point] | _Step] = {}

    def use(self, arrays: Arrays) -> None:
        """Take new arrays."""
        self._choose_kept()
        self._lister: Callable[[int], int] | None = None
        self._arrays, self._state = arrays, arrays.state
        self._others = list(arrays.known)  # links that contacts name by their place here
        self._surfaces: dict[Any, tuple[Array, int | None, Array]] = {}  # of pairs of links
        self._noted = b""  # rows of what sleeps
        immobile = self._engine.contents.immobile
        self._immobile = {number: place for place, number in enumerate(immobile)}

    def restore(self, sleepers: dict[BodyLink, list[Point]]) -> None:
        """Go back to what was saved of `sleepers`; there are no others."""
        self._kept, self._noted = dict(sleepers), b""
        self._state.result[0] = 0

    @property
    def sleepers(self) -> dict[BodyLink, list[Point]]:
        """The contacts with which links have fallen asleep."""
        self._choose_kept()
        return cast("dict[BodyLink, list[Point]]", self._kept)

    def _choose_kept(self) -> None:
        """Of kept steps the contacts of each link."""
        points: dict[int, list[Point]] = {}  # of the steps
        for key, kept in self._kept.items():
            if isinstance(kept, _Step):
                if id(kept) not in points:
                    points[id(kept)] = self._points_of(*kept)
                self._kept[key] = [point for point in points[id(kept)] if point[0] == key]

    def find(self) -> int:
        """Contacts that the mirror finds where bodies are, into the first rows; their number."""
        rows, known = self._arrays.rows, self._arrays.known
        self._others = list(known)
        n = 0
        for one, two, at, normal, distance in self._engine.mirror.contact_points():
            first, second = rows.get(one), rows.get(two)
            if first is None:
                if second is None:
                    continue
                one, two, first, second = two, one, second, None
                x, y, z = normal
                normal = -x, -y, -z
            if second is None and two in known and self._is_known(first, at):
                continue  # found by quickstep
            if second is not None and self._state.scene.may_collide[first, second] == q.PAIR_NATIVE:
                continue
            if n >= _MAX_FOUND:
                break
            row = self._state.contacts.rows[n]
            row[:], turning, direction = self._surface_of_pair(one, two)
            row[q.C_POINT : q.C_POINT + 3], row[q.C_NORMAL : q.C_NORMAL + 3] = at, normal
            if turning is not None:
                orientation: Any = self._state.system.bodies[turning, q.QUAT : q.QUAT + 4]
                row[q.C_FDIR : q.C_FDIR + 3] = matrix_from_quaternion(orientation) @ direction
            row[q.C_DEPTH] -= distance
            self._state.contacts.owners[n] = (
                first,
                -1 if second is None else second,
                -1,
                len(self._others),
            )
            self._others.append(two)
            n += 1
        return n

    def _is_known(self, row: int, point: Vec3) -> bool:
        """Whether quickstep finds a body's contact with what never moves."""
        scene, body = self._state.scene, self._state.system.bodies[row]
        own = slice(scene.firsts[row], scene.firsts[row + 1])
        known = scene.kinds[own, 1] != q.OTHER
        if known.all() or not known.any():
            return bool(known.all())
        orientation: Any = body[q.QUAT : q.QUAT + 4]
        local = matrix_from_quaternion(orientation).T @ (np.asarray(point) - body[: q.QUAT])
        middle, half = scene.extents[own, :3], scene.extents[own, 3:]
        return bool((known & (np.abs(local - middle) < half + _CLOSE).all(axis=1)).any())

    def _surface(self, link: BodyLink) -> Surface:
        body = self._engine.bodies.get(link[0])
        return Surface() if body is None else body.model.links[link[1]].surface

    def _surface_of_pair(self, one: BodyLink, two: BodyLink) -> tuple[Array, int | None, Array]:
        """A contact's row of all that does not depend on where it is, the body with which its
        direction of friction turns, and this direction; None: it has none.

        Args:
            one, two: the first moves.
        """
        key = one, two, self._engine.time_step
        if key not in self._surfaces:
            first, second = self._arrays.rows[one], self._arrays.rows.get(two)
            mine, its = self._surface(one), self._surface(two)
            row = np.zeros(q.C_SIZE)
            row[q.C_MU : q.C_MU + 2] = np.minimum(tables.friction(mine), tables.friction(its))
            row[q.C_ERP], row[q.C_CFM] = q.softness(
                self._engine.time_step,
                *(tables.stiffness(mine), tables.damping(mine)),
                *(tables.stiffness(its), tables.damping(its)),
            )
            row[q.C_SLIP] = mine.slip1 + its.slip1
            row[q.C_SLIP + 1] = mine.slip2 + its.slip2
            shape, plane = np.zeros(q.G_COLUMNS), np.zeros(q.P_COLUMNS)
            tables.surface_columns(shape[q.G_MU :], mine)
            tables.surface_columns(plane[q.P_MU :], its)
            row[q.C_BOUNCE : q.C_BOUNCE + 2] = np.minimum(
                shape[q.G_BOUNCE : q.G_BOUNCE + 2], plane[q.P_BOUNCE : q.P_BOUNCE + 2]
            )
            q.set_torsion(row, shape, plane)
            rows = [first] if second is None else [first, second]
            row[q.C_MAX] = self._state.system.bodies[rows, q.MAX_VEL].min()
            row[q.C_DEPTH] = -self._state.system.bodies[rows, q.MIN_DEPTH].min()
            turning, direction = None, np.zeros(3)
            for surface, index in ((its, second), (mine, first)):
                if surface.direction is not None and index is not None:
                    turning, direction = index, np.asarray(surface.direction)
            self._surfaces[key] = row, turning, direction
        return self._surfaces[key]

    def note_sleepers(self) -> None:
        """Retain the contacts of bodies that have fallen asleep, drop those of what woke."""
        rows = np.flatnonzero(self._state.system.bodies[:, q.ASLEEP])
        if len(rows) == len(self._kept) and rows.tobytes() == self._noted:
            return
        self._noted = rows.tobytes()
        asleep = {self._arrays.owner[row] for row in rows.tolist()}
        if asleep == self._kept.keys():
            return
        contacts, owner = self._state.contacts, self._arrays.owner
        fallen = [row for row in rows.tolist() if owner[row] not in self._kept]
        chosen = np.isin(contacts.owners[: self._state.result[0], 0], fallen).nonzero()[0]
        step = _Step(contacts.rows[chosen], contacts.owners[chosen], self._others)
        self._kept = {key: self._kept.get(key, step) for key in asleep}

    def of_link(self, link: BodyLink) -> list[Contact]:
        """Contacts of one link, as of the last step."""
        row, rows = self._arrays.rows.get(link), None
        if row is not None:  # no others need be read
            one, two, shape, _ = self._state.contacts.owners[: self._state.result[0]].T
            rows = np.flatnonzero((one == row) | ((two == row) & (shape < 0)))
        points = self.last(rows)
        return [contact for own, contact in _seen_by(link[0], points) if own == link[1]]

    def rows_of_link(self, link: BodyLink) -> ContactRows | None:
        """As of_link, with what is first in Gazebo; None: of_link has to be asked."""
        row = self._arrays.rows.get(link)
        if row is None or link in self._kept:
            return None
        if self._engine.records.shown is not None:
            return self._recorded_rows(row)
        if self._lister is None:
            contacts, room = self._state.contacts, len(self._state.contacts.rows)
            self._touching = Touching(
                *(contacts.rows, contacts.owners, self._state.result, self._state.system.bodies),
                *(np.zeros((room, 4), np.int64), np.zeros((room, 16))),
            )
            self._lister = contact_lister(self._touching)
        count, owner = self._lister(row), self._arrays.owner
        chosen = self._touching.chosen[:count].tolist()
        if any(one != row and owner[one][0] == link[0] for one, *_ in chosen):
            return None
        others = self._touched(row, chosen)
        numbers = self._touching.numbers[:count].copy()
        firsts = {other: self.is_first(link, other) for other in set(others)}
        return ContactRows(others, [firsts[other] for other in others], numbers, numbers[:, 10:])

    def _recorded_rows(self, row: int) -> ContactRows:
        """As rows_of_link(), of a row of bodies after the step that is shown."""
        records = self._engine.records
        chosen, numbers = records.contacts(records.shown, row)
        others = self._touched(row, chosen[:, : q.CR_BODY].tolist())
        firsts = chosen[:, q.CR_FIRST].astype(bool).tolist()
        return ContactRows(others, firsts, numbers, numbers[:, 10:])

    def _touched(self, row: int, owners: list[list[int]]) -> list[BodyLink]:
        """What a row of bodies touches, of its rows of owners."""
        owner, others = self._arrays.owner, self._others
        return [
            self._partner(two, shape, other, others) if one == row else owner[one]
            for one, two, shape, other in owners
        ]

    def of_body(self, number: int) -> list[tuple[str, Contact]]:
        """(link, Contact) of a body, as of the last step."""
        return list(_seen_by(number, self.last()))

    def last(self, rows: Array | None = None) -> list[Point]:
        """_points() but for those of what sleeps, then those with which it fell asleep."""
        sleepers = self.sleepers
        sleeping = [point for kept in sleepers.values() for point in kept]
        return [p for p in self._points(rows) if p[0] not in sleepers] + sleeping

    def _points(self, rows: Array | None = None) -> list[Point]:
        """Contacts of the last step; rows: their numbers, None: all."""
        chosen = slice(self._state.result[0]) if rows is None else rows
        contacts = self._state.contacts
        return self._points_of(contacts.rows[chosen], contacts.owners[chosen], self._others)

    def _partner(self, two: int, shape: int, other: int, others: list[BodyLink]) -> BodyLink:
        """What the first body of a row of owners touches."""
        if shape >= 0:
            return self._arrays.planes[other]
        return self._arrays.owner[two] if two >= 0 else others[other]

    def _points_of(self, rows: Array, owners: Array, others: list[BodyLink]) -> list[Point]:
        """Of rows of contacts and their owners, see quickstep.state.Contacts."""
        points: list[Point] = []
        owner = self._arrays.owner
        for row, (one, two, shape, other) in zip(rows, owners.tolist()):
            partner = self._partner(two, shape, other, others)
            point, normal = row[q.C_POINT : q.C_POINT + 3], row[q.C_NORMAL : q.C_NORMAL + 3]
            force = row[q.C_FORCE : q.C_FORCE + 3].copy()
            points.append((owner[one], partner, tuple(point), tuple(normal), row[q.C_DEPTH], force))
        return points

    def is_first(self, one: BodyLink, two: BodyLink) -> bool:
        """Whether the first of two links that touch comes first in Gazebo: see quickstep.order.

        The space of the first one's shapes finds that of the second one, not the other way round.
        """
        other_level, other_rank = self._space(two)
        if other_level > q.MAX_LEVEL and one in self._arrays.rows:
            return True
        level, rank = self._space(one)
        if max(level, other_level) > q.MAX_LEVEL:
            return level <= q.MAX_LEVEL
        return level <= other_level if rank < other_rank else level < other_level

    def _space(self, key: BodyLink) -> tuple[float, float]:
        """Level and rank of the space of a link's shapes."""
        scene, row = self._state.scene, self._arrays.rows.get(key)
        if row is None:
            number = self._immobile.get(key[0])
            if number is None:
                return q.MAX_LEVEL + 1, -1.0
            space = scene.spaces[number]
            return float(space[q.K_LEVEL]), float(space[q.K_RANK])
        owners, own = scene.kinds[:, 0], scene.space_of[row]
        shapes = np.flatnonzero(scene.space_of[owners] == own)
        low, high = scene.aabbs[shapes, :3], scene.aabbs[shapes, 3:]
        is_ball = scene.kinds[shapes, 1] == q.SPHERE
        radius = scene.shapes[shapes, q.G_SIZE, None]
        middle = 0.5 * (low + high)
        low = np.where(is_ball[:, None], middle - radius, low)
        high = np.where(is_ball[:, None], middle + radius, high)
        sequence = self._state.sequence
        is_own = (scene.space_of[sequence] == own) & (
            self._state.system.bodies[sequence, q.ASLEEP] == 0.0
        )
        rank = len(scene.spaces) + float(is_own.argmax()) if is_own.any() else float(own)
        return space_level(high.max(axis=0) - low.min(axis=0)), rank


def _seen_by(number: int, points: list[Point]) -> Iterator[tuple[str, Contact]]:
    """(link, Contact) of a body."""
    for one, two, point, normal, depth, force in points:
        at, across = np.array(point), np.array(normal)
        if one[0] == number:
            yield one[1], Contact(*two, at, across, depth, force)
        elif two[0] == number:
            yield two[1], Contact(*one, at, -across, depth, -force)
