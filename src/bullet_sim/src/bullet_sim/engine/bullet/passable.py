"""Shapes with <collide_without_contact>: what they overlap is told, but nothing is pushed."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from bullet_sim.description.collisions import is_passable
from bullet_sim.description.lump import LumpedModel
from bullet_sim.description.model import Shape
from bullet_sim.engine.api import Body, BodyLink, Contact
from bullet_sim.engine.bullet.client import Client
from bullet_sim.engine.ode import tables
from bullet_sim.pose import Array, Pose, Vec3

_CLOSE = 1e-3  # [m] of a point to a shape that it is on


class Passable:
    """Links that have such shapes."""

    def __init__(self, client: Client) -> None:
        self._client = client
        self._masks: dict[BodyLink, int] = {}  # of all links whose mask is not 1
        # Of links with passable shapes: those, where they have others, too; None: all are.
        self._shapes: dict[BodyLink, list[Shape] | None] = {}

    def __contains__(self, link: BodyLink) -> bool:
        return link in self._shapes

    def add(self, number: int, model: LumpedModel) -> list[BodyLink]:
        """Note a body's links; gives those that push nothing at all."""
        whole = []
        for name, link in model.links.items():
            key, mask = (number, name), 0
            for shape in link.collisions:
                mask |= (shape.surface or link.surface).without_contact_bitmask
            if link.collisions and mask != 1:
                self._masks[key] = mask
            shapes = [shape for shape in link.collisions if is_passable(shape, link)]
            if not shapes:
                continue
            self._shapes[key] = None if len(shapes) == len(link.collisions) else shapes
            whole += [key] if self._shapes[key] is None else []
        return whole

    def remove(self, number: int) -> None:
        """A body was removed."""
        self._masks = {link: mask for link, mask in self._masks.items() if link[0] != number}
        self._shapes = {link: some for link, some in self._shapes.items() if link[0] != number}

    def overlapping(self, link: BodyLink, bodies: Mapping[int, Body]) -> list[Contact]:
        """What a link overlaps where one of the two is passable, at its deepest point of each.

        PyBullet's bodies have to be where they are.

        Args:
            bodies: by their numbers; two that cannot move are not looked at.
        """
        return list(self._overlaps(link, bodies)) if self._shapes else []

    def _overlaps(self, own: BodyLink, bodies: Mapping[int, Body]) -> Iterator[Contact]:
        low, high = self._box(own)
        for other in self._links() if own in self._shapes else list(self._shapes):
            if other[0] == own[0] or not (bodies[own[0]].moves or bodies[other[0]].moves):
                continue
            shared = self._masks.get(own, 1) & self._masks.get(other, 1)
            below, above = self._box(other)
            if not shared or (below > high).any() or (above < low).any():
                continue
            (uid, index), (its, its_index) = self._client.index(own), self._client.index(other)
            for point in self._client.api.getClosestPoints(uid, its, 0.0, index, its_index):
                if self._is_on(own, point[5]) or self._is_on(other, point[6]):
                    at, normal = np.array(point[5]), np.array(point[7])
                    yield Contact(*other, at, normal, -point[8], np.zeros(3))

    def _links(self) -> Iterator[BodyLink]:
        for number, loaded in self._client.bodies.items():
            for name in loaded.links:
                yield number, name

    def _box(self, link: BodyLink) -> tuple[Array, Array]:
        low, high = self._client.api.getAABB(*self._client.index(link))
        return np.array(low) - _CLOSE, np.array(high) + _CLOSE

    def _is_on(self, link: BodyLink, point: Vec3) -> bool:
        """Whether a point of a link is on a passable shape of it."""
        if link not in self._shapes:
            return False
        shapes = self._shapes[link]
        if shapes is None:
            return True
        frame = Pose(*self._client.link_frame(link))
        for shape in shapes:
            half = tables.half_size(shape.geometry.kind, shape.geometry.size)
            local = (frame * shape.pose).inverse() * Pose(point)
            if half is None or (np.abs(local.position) <= half + _CLOSE).all():
                return True
        return False
