"""Rays of a lidar: from one point, at everything."""

import math

import numpy as np

from bullet_sim.engine.client import Client
from bullet_sim.engine.library import p

_MARGIN = 0.01  # around a box that may be hit [m]
_ALL, _MOVING = -1, ~2  # masks of rays; Bullet's group 2 is what never moves


class Sweep(Client):
    """Casts all rays of a lidar.

    What never moves is asked by itself (Scenery); PyBullet casts the rays that come near anything
    else.
    """

    def sweep(self, centre, directions, box, near, far, own=None, look_near=True):
        """Distances to what rays from one point hit first.

        Args:
            centre: (3,) [m] in the world.
            directions: (n, 3) unit vectors, world axes.
            box: two corners (3,) [m] of a box that contains the rays up to `far`.
            near, far: distances between which a hit is measured [m].
            own: body that does not count where it is nearer than `near`.
            look_near: whether to look for what is nearer than `near`.

        Returns:
            (n,) float64 [m]; inf: nothing up to `far`; -inf: something nearer than `near`.
        """
        self._scenery.refresh()
        look_near = look_near and near > 0.0
        is_housed = own in self._scenery  # then PyBullet tells its own body from the others
        start = 0.0 if look_near and not is_housed else near
        ranges, again = self._cast_at_scenery(centre, directions, box, start, far)
        rays = {_ALL: again, _MOVING: None}
        too_near = None if not (look_near and is_housed) else np.ones(len(directions), bool)
        for low, high, mask, body in self._others(box):
            corner = np.maximum(np.subtract(high, centre), np.subtract(centre, low))
            if corner @ corner > near * near:
                found = _towards(low, high, centre, directions, near, far)
                rays[mask] = _either(rays[mask], found)
            if look_near and body != own:
                found = _towards(low, high, centre, directions, 0.0, near)
                too_near = _either(too_near, found)
        for mask, wanted in rays.items():
            if wanted is not None:
                distances, _ = self._cast(centre, directions[wanted], near, far, mask)
                ranges[wanted] = np.minimum(ranges[wanted], distances)
        if look_near:
            ranges[ranges < near] = -np.inf
        if too_near is not None:
            distances, bodies = self._cast(centre, directions[too_near], 0.0, near, _ALL)
            hit = np.isfinite(distances) & (bodies != own)
            ranges[np.flatnonzero(too_near)[hit]] = -np.inf
        return ranges

    def _cast_at_scenery(self, centre, directions, box, start, far):
        """Distances (n,), and which rays (n,) PyBullet has to cast again, or None."""
        ranges, again = np.full(len(directions), np.inf), None
        found = self._scenery.cast(centre, directions, box, start, far)
        if found is not None:
            ranges, inside = found
            if len(inside):
                again = np.zeros(len(directions), bool)
                again[inside], ranges[inside] = True, np.inf
        middle, half = np.add(*box) / 2.0, np.subtract(box[1], box[0]) / 2.0
        for point, normal in self._scenery.planes:
            height = normal @ np.subtract(centre, point)
            reach = np.abs(normal) @ half
            if abs(normal @ (middle - point)) > reach:  # the whole box is on one side
                continue
            with np.errstate(divide="ignore", invalid="ignore"):
                distances = -height / (directions @ normal)
            hit = (distances >= start) & (distances <= far)
            ranges[hit] = np.minimum(ranges[hit], distances[hit])
        return ranges, again

    def _others(self, box):
        """Boxes (low, high) of what PyBullet has to cast at, the rays' mask, the body or -1."""
        overlapping = p.getOverlappingObjects(*map(tuple, box), physicsClientId=self._client) or ()
        for body, link in sorted(set(overlapping)):
            if body not in self._scenery:
                fixed = link < 0 and body not in self._free
                low, high = p.getAABB(body, link, physicsClientId=self._client)
                yield low, high, _ALL if fixed else _MOVING, body
        for *centre, radius in self._scenery.spheres:
            yield np.subtract(centre, radius), np.add(centre, radius), _ALL, -1

    def _cast(self, centre, directions, start, end, mask):
        """Distances (n,) [m] of the nearest hits, inf: none, and bodies (n,)."""
        fractions, bodies = self.ray_batch(
            centre + start * directions, centre + end * directions, mask
        )
        distances = start + fractions * (end - start)
        return np.where(bodies >= 0, distances, np.inf), bodies


def _either(first, second):
    if first is None or second is None:
        return first if second is None else second
    return first | second


def _towards(low, high, centre, directions, near, far):
    """Which rays (n,) may meet a box between two distances; None: none does.

    Args:
        low, high: corners (3,) [m].
        centre: (3,) [m] from which the rays come.
        directions: (n, 3) unit vectors.
        near, far: [m].
    """
    way = np.add(low, high) / 2.0 - centre
    half = np.subtract(high, low) / 2.0 + _MARGIN
    outside = np.maximum(np.abs(way) - half, 0.0)
    if outside @ outside > far * far:
        return None
    square = way @ way - half @ half
    if square > 0.0:  # a cone around the sphere that contains the box
        found = directions @ way >= math.sqrt(square)
    else:
        with np.errstate(divide="ignore", invalid="ignore"):
            ends = np.stack([way - half, way + half])[:, None] / directions
        enter, leave = ends.min(axis=0).max(axis=1), ends.max(axis=0).min(axis=1)
        found = ~((enter > leave) | (leave < near) | (enter > far))
    return found if found.any() else None
