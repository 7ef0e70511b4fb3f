"""Shapes with <collide_without_contact>: what they overlap is told, but nothing is pushed."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Tuple

import numpy as np
import pybullet as p

from bullet_sim.description.lump import LumpedModel
from bullet_sim.description.model import Link, Shape
from bullet_sim.engine import tables
from bullet_sim.pose import Array, Pose, Vec3

BodyLink = Tuple[int, int]
Overlap = Tuple[int, int, Vec3, Vec3, float]  # other body, its link, point, normal, depth
_CLOSE = 1e-3  # [m] of a point to a shape that it is on


def is_passable(shape: Shape, link: Link) -> bool:
    """Whether a collision of a link pushes nothing."""
    return (shape.surface or link.surface).without_contact


class Passable:
    """Links that have such shapes.

    Args:
        client: gives PyBullet's number of the engine.
    """

    def __init__(self, client: Callable[[], int]) -> None:
        self._client = client
        self._masks: dict[BodyLink, int] = {}  # of all links whose mask is not 1
        # Of links with passable shapes: those, where they have others, too; None: all are.
        self._shapes: dict[BodyLink, list[Shape] | None] = {}

    def __bool__(self) -> bool:
        return bool(self._shapes)

    def __contains__(self, key: BodyLink) -> bool:
        return key in self._shapes

    def take(self, body: int, model: LumpedModel, links: Mapping[str, int]) -> list[int]:
        """Note a body's links; gives those that push nothing at all."""
        whole = []
        for name, link in model.links.items():
            key, mask = (body, links[name]), 0
            for shape in link.collisions:
                mask |= (shape.surface or link.surface).without_contact_bitmask
            if link.collisions and mask != 1:
                self._masks[key] = mask
            shapes = [shape for shape in link.collisions if is_passable(shape, link)]
            if not shapes:
                continue
            self._shapes[key] = None if len(shapes) == len(link.collisions) else shapes
            whole += [key[1]] if self._shapes[key] is None else []
        return whole

    def remove(self, body: int) -> None:
        """A body was removed."""
        self._masks = {key: mask for key, mask in self._masks.items() if key[0] != body}
        self._shapes = {key: each for key, each in self._shapes.items() if key[0] != body}

    def overlaps(self, body: int, link: int, moves: Callable[[int], bool]) -> Iterator[Overlap]:
        """What a link overlaps where one of the two is passable, at its deepest point of each.

        PyBullet's bodies have to be where they are.

        Args:
            moves: whether a body can move; two that cannot are not looked at.
        """
        own = body, link
        low, high = self._box(own)
        for other in self._links() if own in self._shapes else list(self._shapes):
            if other[0] == body or not (moves(body) or moves(other[0])):
                continue
            shared = self._masks.get(own, 1) & self._masks.get(other, 1)
            below, above = self._box(other)
            if not shared or (below > high).any() or (above < low).any():
                continue
            for point in p.getClosestPoints(
                body, other[0], 0.0, link, other[1], physicsClientId=self._client()
            ):
                if self._is_on(own, point[5]) or self._is_on(other, point[6]):
                    yield (*other, point[5], point[7], -point[8])

    def _links(self) -> Iterator[BodyLink]:
        for index in range(p.getNumBodies(physicsClientId=self._client())):
            body = p.getBodyUniqueId(index, physicsClientId=self._client())
            for link in range(-1, p.getNumJoints(body, physicsClientId=self._client())):
                yield body, link

    def _box(self, key: BodyLink) -> tuple[Array, Array]:
        low, high = p.getAABB(*key, physicsClientId=self._client())
        return np.array(low) - _CLOSE, np.array(high) + _CLOSE

    def _is_on(self, key: BodyLink, point: Vec3) -> bool:
        """Whether a point of a link is on a passable shape of it."""
        if key not in self._shapes:
            return False
        shapes = self._shapes[key]
        if shapes is None:
            return True
        frame = self._frame(key)
        for shape in shapes:
            half = tables.half_size(shape.geometry.kind, shape.geometry.size)
            local = (frame * shape.pose).inverse() * Pose(point)
            if half is None or (np.abs(local.position) <= half + _CLOSE).all():
                return True
        return False

    def _frame(self, key: BodyLink) -> Pose:
        """Pose of a link's frame in the world."""
        body, link = key
        if link >= 0:
            state = p.getLinkState(body, link, physicsClientId=self._client())
            return Pose(state[4], state[5])
        base = Pose(*p.getBasePositionAndOrientation(body, physicsClientId=self._client()))
        center = p.getDynamicsInfo(body, -1, physicsClientId=self._client())
        inertial = Pose(center[3], center[4]) if any(center[4]) else Pose()
        return base * inertial.inverse()
