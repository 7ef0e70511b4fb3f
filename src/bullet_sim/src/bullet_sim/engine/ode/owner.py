"""What the parts of the engine 'ode' know of it: a protocol, so that imports go one way."""

from __future__ import annotations

from typing import Any, Protocol

from bullet_sim.description.model import Joint, Link
from bullet_sim.engine.api import BodyLink
from bullet_sim.pose import Array, Pose, Vec3


class JointsOwner(Protocol):
    """See body.OdeBody."""

    joints: Any
    tree: list[Joint]

    def has_rows(self) -> bool: ...
    def place(self) -> Any: ...
    def link(self, row: int) -> Link: ...


class Owner(Protocol):
    """See engine.OdeEngine, which has the attributes and methods of the same names."""

    bodies: Any
    contents: Any
    held: dict[Any, Vec3]
    arrays: Any
    rows: Array
    joint_rows: Array
    joint_numbers: Any
    is_built: bool
    is_ahead: bool
    placements: int
    time_step: float
    last_contacts: Any
    records: Any

    @property
    def mirror(self) -> Any: ...
    @property
    def has_mirror(self) -> bool: ...

    def build(self) -> None: ...
    def refresh(self) -> None: ...
    def measure_joints(self) -> None: ...
    def note_placed(self, body: Any) -> None: ...
    def frame_of(self, link: BodyLink) -> Pose: ...
    def note_layout(self, *event: object) -> None: ...
