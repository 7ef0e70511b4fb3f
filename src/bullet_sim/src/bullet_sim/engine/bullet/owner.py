"""What the parts of the engine 'bullet' know of it: a protocol, so that imports go one way."""

from __future__ import annotations

from typing import Any, Protocol

from bullet_sim.engine.bullet.client import Client


class Owner(Protocol):
    """See engine.BulletEngine, which has the attributes and methods of the same names."""

    client: Client
    bodies: Any
    weightless: list[Any]
    placements: int
    layout: int
    passable: Any

    def note_layout(self, *event: object) -> None: ...
