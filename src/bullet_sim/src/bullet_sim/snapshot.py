"""State of a world as a small value, for its mirrors (renderers).

A snapshot is for rendering. The simulation cannot be continued from it bit-exactly: it has no
contact caches.
"""

from __future__ import annotations

from dataclasses import dataclass

from bullet_sim.description.model import Shape, VisualLink


@dataclass(frozen=True)
class BodySource:
    """Source of one body for a mirror.

    Attributes:
        key: identifier of the body, unique in a world's lifetime.
        fixed_base: True when the root link never moves.
        links: VisualLinks, in the order of the body's links.
        converted: shapes of each link, as files that PyBullet's renderer reads; empty: its own.
    """

    key: int
    fixed_base: bool
    links: tuple[VisualLink, ...]
    converted: tuple[tuple[Shape, ...], ...] = ()


@dataclass(frozen=True)
class BodyState:
    """Pose of a root link in the world frame [m], (x, y, z, w), and joint positions [rad, m]."""

    key: int
    position: tuple[float, float, float]
    orientation: tuple[float, float, float, float]
    joints: tuple[float, ...]


@dataclass(frozen=True)
class Snapshot:
    """State of all bodies at one simulated time [s]."""

    time: float
    step: int
    bodies: tuple[BodyState, ...]
