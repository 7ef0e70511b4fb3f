"""PyBullet's copies of the bodies that the engine 'ode' moves: for what quickstep does not know."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from bullet_sim.engine.api import BodyLink, Contact
from bullet_sim.engine.bullet.client import Client, Point
from bullet_sim.engine.bullet.passable import Passable
from bullet_sim.engine.ode.owner import Owner
from bullet_sim.pose import Array

if TYPE_CHECKING:
    from bullet_sim.engine.ode.body import OdeBody


class Mirror:
    """Copies of all bodies, made when something asks for the first of them, and put where the
    bodies are before each answer."""

    def __init__(self, engine: Owner) -> None:
        self._engine, self._client = engine, Client()
        self._passable = Passable(self._client)
        self._placed: set[OdeBody] = set()  # bodies that were put somewhere since the last time
        self._resting: set[OdeBody] = set()  # bodies that sleep where their copies are

    def close(self) -> None:
        """Disconnect."""
        self._client.close()

    def _add(self, body: OdeBody) -> None:
        fixed, model = body.is_fixed, body.model
        touching = {frozenset(pair) for pair in body.collisions}
        self._client.load(body.number, model, body.is_static, fixed, bool(touching))
        for one in model.links if touching else ():
            for other in model.links:
                if one < other and frozenset((one, other)) not in touching:
                    links = (body.number, one), (body.number, other)
                    self._client.set_pair_collision(*links, False)
        for name in model.links:
            bits = self._engine.contents.filtered.get((body.number, name))
            if bits is not None:
                self._client.set_bitmask((body.number, name), bits)
        self._passable.add(body.number, model)
        self._put(body)

    def remove(self, body: OdeBody) -> None:
        """Remove the copy of a body."""
        if body.number in self._client.bodies:
            self._client.remove(body.number)
            self._passable.remove(body.number)
        self._placed.discard(body)
        self._resting.discard(body)

    def note_placed(self, body: OdeBody) -> None:
        """A body was put somewhere."""
        self._placed.add(body)

    def set_bitmask(self, link: BodyLink, bits: int) -> None:
        """As Client.set_bitmask."""
        if link[0] in self._client.bodies:
            self._client.set_bitmask(link, bits)

    def _put(self, body: OdeBody) -> None:
        """Put the copy of a body where that is."""
        placement, loaded = body.present(), self._client.bodies[body.number]
        self._client.put(body.number, placement.pose, body.moves)
        if not loaded.is_static:
            self._client.api.resetBaseVelocity(loaded.uid, placement.linear, placement.angular)
        held = {joint.name for joint in body.model.welds if joint.holds}
        states = {n: s for n, s in zip(body.joints, placement.joints) if n not in held}
        if body.has_chains and np.isfinite(placement.linear).all():
            states.update((name, (position, 0.0)) for name, position in body.chains().items())
        self._client.set_joints(body.number, states)

    @property
    def client(self) -> Client:
        """That of PyBullet, with copies where the bodies are."""
        engine, client = self._engine, self._client
        for number in sorted(engine.bodies.keys() - client.bodies.keys()):
            self._add(engine.bodies[number])
        if engine.is_ahead:
            engine.is_ahead = False
            for body in engine.bodies.values():
                if body in self._placed or body.moves and not self._is_resting(body):
                    self._put(body)
            self._placed.clear()
        return client

    def _is_resting(self, body: OdeBody) -> bool:
        """Whether a body sleeps as at the last call: its copy is where it is."""
        if not body.is_resting():
            self._resting.discard(body)
            return False
        was = body in self._resting
        self._resting.add(body)
        return was

    # What it is asked ---------------------------------------------------------------------------
    def box(self, number: int) -> Array:
        """Box (6,) around a body that never moves."""
        uid = self.client.bodies[number].uid
        return np.concatenate(self._client.api.getAABB(uid, -1))

    def contact_points(self) -> Iterator[Point]:
        """Contact points where bodies are, but of links that push nothing."""
        for point in self.client.touching_points():
            if point.distance <= 0.0 and not (
                point.one in self._passable or point.two in self._passable
            ):
                yield point

    def overlaps(self, link: BodyLink) -> list[Contact]:
        """What a link overlaps where one of the two pushes nothing."""
        assert self.client
        return self._passable.overlapping(link, self._engine.bodies)
