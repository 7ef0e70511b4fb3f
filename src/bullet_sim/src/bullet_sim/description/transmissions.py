"""<transmission>s of a URDF."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple


class Transmission(NamedTuple):
    """A transmission that the parser takes.

    Attributes:
        joints: name and hardware interfaces, as written, of each of its joints.
    """

    name: str
    joints: tuple[tuple[str, tuple[str, ...]], ...]


@dataclass(frozen=True)
class Transmissions:
    """Those of a robot.

    Attributes:
        taken: in the order of the file.
        errors: why others are left out, in the parser's words.
    """

    taken: tuple[Transmission, ...] = ()
    errors: tuple[str, ...] = ()

    @property
    def joints(self) -> frozenset[str]:
        """Names of their joints."""
        return frozenset(name for each in self.taken for name, _ in each.joints)
