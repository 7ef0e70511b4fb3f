"""Small values that carry the state of a world to its mirrors (renderer, viewer).

A snapshot feeds pictures. It is not bit-exact for going on from: contact caches are missing.
"""

from dataclasses import dataclass


@dataclass(frozen=True)
class BodySource:
    """What a mirror needs to load one body.

    Attributes:
        key: identity of the body, never used twice in one world.
        path: prepared URDF file.
        fixed_base: True when the body never moves.
    """

    key: int
    path: str
    fixed_base: bool


@dataclass(frozen=True)
class BodyState:
    """Pose of a body's root link in the world frame [m], (x, y, z, w), and its joints [rad, m]."""

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
