"""Contacts of the solver 'ode': those that PyBullet finds, and what is told of the last step's."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Tuple

import numpy as np
import pybullet as p

from bullet_sim.description.model import Surface
from bullet_sim.engine import tables
from bullet_sim.engine.ode_arrays import Arrays, Models
from bullet_sim.engine.ode_scene import MAX_POINTS, BodyLink, space_level
from bullet_sim.engine.quickstep import layout as q
from bullet_sim.pose import Array, Vec3, matrix_from_quaternion

if TYPE_CHECKING:
    from bullet_sim.engine.engine import Engine

_CLOSE = 0.002  # [m] between a contact that Bullet finds and the shape that it is with
_MAX_FOUND = 64 * MAX_POINTS  # contacts that Bullet finds

# Body, link, other body, its link, point [m], normal towards the first, depth [m], force (3,) [N]
# on the first; world axes.
Contact = Tuple[int, int, int, int, Vec3, Vec3, float, Array]


class Contacts:
    """Contacts of what moves.

    Args:
        models: that the arrays are built of.

    Attributes:
        sleepers: the contacts with which links have fallen asleep, by (body, link).
    """

    def __init__(self, engine: Engine, models: Models) -> None:
        self._engine, self._models = engine, models
        self.sleepers: dict[BodyLink, list[Contact]] = {}

    def use(self, arrays: Arrays) -> None:
        """Take new arrays."""
        self._arrays, self._state = arrays, arrays.state
        self._others = list(arrays.known)  # (body, link) that contacts name by their place here
        self._surfaces: dict[Any, tuple[Array, int | None, Array]] = {}  # of pairs of links
        self._noted = b""  # rows of what sleeps
        self._static = {body: number for number, body in enumerate(self._models.static)}

    def restore(self, sleepers: dict[BodyLink, list[Contact]]) -> None:
        """Go back to what was saved of `sleepers`; there are no others."""
        self.sleepers, self._noted = sleepers, b""
        self._state.result[0] = 0

    def find(self) -> int:
        """Contacts that PyBullet finds where its bodies are, into the first rows; their number."""
        client = self._engine.client
        p.performCollisionDetection(physicsClientId=client)
        rows, known = self._arrays.rows, self._arrays.known
        passable = self._engine.passable
        self._others = list(known)
        n = 0
        for point in p.getContactPoints(physicsClientId=client) or ():
            _, one, two, link_one, link_two, _, at, normal, distance = point[:9]
            if distance > 0.0:
                continue
            if (one, link_one) in passable or (two, link_two) in passable:
                continue
            first, second = rows.get((one, link_one)), rows.get((two, link_two))
            if first is None:
                if second is None:
                    continue
                one, link_one, two, link_two = two, link_two, one, link_one
                first, second, normal = second, None, tuple(-x for x in normal)
            if second is None and (two, link_two) in known and self._is_known(first, at):
                continue  # found by quickstep
            if second is not None and self._state.scene.may_collide[first, second] == q.PAIR_NATIVE:
                continue
            if n >= _MAX_FOUND:
                break
            row = self._state.contacts.rows[n]
            row[:], turning, direction = self._surface_of_pair((one, link_one), (two, link_two))
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
            self._others.append((two, link_two))
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

    def _surface(self, key: BodyLink) -> Surface:
        body, link = key
        if body in self._models.moving and key in self._arrays.rows:
            return self._models.moving[body].link(self._arrays.rows[key]).surface
        return self._models.static[body].link.surface if body in self._models.static else Surface()

    def _surface_of_pair(self, one: BodyLink, two: BodyLink) -> tuple[Array, int | None, Array]:
        """A contact's row of all that does not depend on where it is, the body with which its
        direction of friction turns, and this direction; None: it has none.

        Args:
            one, two: (body, link); the first moves.
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
        if len(rows) == len(self.sleepers) and rows.tobytes() == self._noted:
            return
        self._noted = rows.tobytes()
        asleep = {self._arrays.owner[row] for row in rows}
        if asleep == self.sleepers.keys():
            return
        found = self._found_contacts()
        self.sleepers = {
            key: self.sleepers[key] if key in self.sleepers else [c for c in found if c[:2] == key]
            for key in asleep
        }

    def last(self) -> list[Contact]:
        """Contacts of the last step; of what sleeps those with which it fell asleep."""
        return self._awake_and_asleep()

    def of_link(self, key: BodyLink) -> list[Contact]:
        """As last(), of one link."""
        row, rows = self._arrays.rows.get(key), None
        if row is not None:  # no others need be read
            one, two, shape, _ = self._state.contacts.owners[: self._state.result[0]].T
            rows = np.flatnonzero((one == row) | ((two == row) & (shape < 0)))
        return [found for found in self._awake_and_asleep(rows) if key in (found[:2], found[2:4])]

    def _awake_and_asleep(self, rows: Array | None = None) -> list[Contact]:
        """_found_contacts() but for those of what sleeps, then all of that."""
        sleeping = [contact for kept in self.sleepers.values() for contact in kept]
        return [c for c in self._found_contacts(rows) if c[:2] not in self.sleepers] + sleeping

    def _found_contacts(self, rows: Array | None = None) -> list[Contact]:
        """Contacts of the last step; rows: their numbers, None: all."""
        found = []
        state, owner = self._state, self._arrays.owner
        chosen = slice(state.result[0]) if rows is None else rows
        for row, (one, two, shape, other) in zip(
            state.contacts.rows[chosen], state.contacts.owners[chosen].tolist()
        ):
            body, link = owner[one]
            if shape >= 0:
                partner = self._arrays.planes[other]
            else:
                partner = owner[two] if two >= 0 else self._others[other]
            point, normal = row[q.C_POINT : q.C_POINT + 3], row[q.C_NORMAL : q.C_NORMAL + 3]
            force = row[q.C_FORCE : q.C_FORCE + 3].copy()
            found.append((body, link, *partner, tuple(point), tuple(normal), row[q.C_DEPTH], force))
        return found

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
            number = self._static.get(key[0])
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
