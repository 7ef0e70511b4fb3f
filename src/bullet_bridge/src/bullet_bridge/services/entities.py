"""Names of gazebo_ros' interfaces -> models, links, joints and frames of the world."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from bullet_sim.errors import ModelError, WorldError
from bullet_sim.pose import Array, Pose

if TYPE_CHECKING:
    from bullet_sim.models.model import Model
    from bullet_sim.world import World

WORLD_FRAMES = ("", "world", "map", "/map")
LISTED = 30  # names in an error message


@dataclass(frozen=True)
class Frame:
    """A reference frame: pose in the world, velocity of its origin along world axes."""

    pose: Pose = Pose()
    linear: np.ndarray = field(default_factory=lambda: np.zeros(3))
    angular: np.ndarray = field(default_factory=lambda: np.zeros(3))

    def inward(self, pose: Pose, linear: Array, angular: Array) -> tuple[Pose, Array, Array]:
        """A pose and a velocity of the world relative to this frame, along its axes."""
        rotation = self.pose.matrix.T
        return (
            self.pose.inverse() * pose,
            rotation @ (linear - self.linear),
            rotation @ (angular - self.angular),
        )


@dataclass(frozen=True)
class FoundModel:
    """A model of the world, or one inside it.

    Attributes:
        model: the outermost one.
        path: name of the model inside it, as MODEL::MODEL; empty: it is the outermost one.
    """

    model: Model
    path: str = ""

    def state(self) -> tuple[Pose, Array, Array]:
        """As Model.link_state, of the model's frame."""
        if not self.path:
            position, orientation, linear, angular = self.model.motion()
            return Pose(position, orientation), np.array(linear), np.array(angular)
        link, offset = self.model.description.nested[self.path]
        pose, linear, angular = self.model.link_state(link)
        arm = pose.matrix @ np.asarray(offset.position)
        return pose * offset, linear + np.cross(angular, arm), angular

    def set_state(self, pose: Pose, linear: Array, angular: Array) -> None:
        """Put the model to a world pose with a velocity.

        As in Gazebo a model inside another one goes with all its links and without the others, to
        which joints pull it back; its own links get the velocity, those of models inside it keep
        theirs.

        Raises:
            ModelError: a number is NaN, infinite or out of bounds, or a fixed joint holds one of
                its links to another model's.
        """
        model = self.model
        if not self.path:
            model.set_state(pose, linear, angular)
            return
        links = [name for name in model.description.links if name.startswith(self._scope)]
        parts = [name for name in links if name in model.rigid_parts]
        held = {model.link_in_body(name)[0] for name in links}
        if model.is_static or len(held) != len(parts):
            raise ModelError(
                f"model '{model.name}::{self.path}' is a fixed part of '{model.name}' and has no "
                "pose that can be set; set that of the whole"
            )
        moved = pose.normalized() * self.state()[0].inverse()
        for name in parts:
            there, at, spin = model.link_state(name)
            arm = np.subtract(model.body.link_center(name), there.position)
            motion = at + np.cross(spin, arm), spin
            if model.description.scope_of(name) == self._scope:
                motion = linear, angular
            model.set_link_state(name, moved * there, *motion)

    def own(self, names: Iterable[str]) -> list[str]:
        """Those of the outermost model's links or joints that are its own."""
        return [name for name in names if self.model.description.scope_of(name) == self._scope]

    def plain(self, names: Iterable[str]) -> list[str]:
        """As own(), by the names that they have in it."""
        return [name[len(self._scope) :] for name in self.own(names)]

    @property
    def _scope(self) -> str:
        return f"{self.path}::" if self.path else ""

    @property
    def parent(self) -> str:
        """Name of the model that it is in; empty: the world."""
        return f"{self.model.name}::{self.path}".split("::")[-2] if self.path else ""

    @property
    def children(self) -> list[str]:
        """Names of the models directly in it."""
        inner = [path for path in self.model.description.nested if path.startswith(self._scope)]
        return [
            path[len(self._scope) :]
            for path in inner
            if path != self.path and "::" not in path[len(self._scope) :]
        ]


def _entity(world: World, name: str) -> tuple[str, FoundModel] | None:
    """What has a name, as World::EntityByName of Gazebo finds it, whatever is looked for: of each
    model in turn itself, its links, the models inside it, its joints.

    Returns:
        ("model", it), ("link" or "joint", the outermost model and its link's or joint's name).
    """
    for model in world.models.values():
        if name == model.name:
            return "model", FoundModel(model)
        part = name[len(model.name) + 2 :] if name.startswith(f"{model.name}::") else name
        if part in model.bodies:
            return "link", FoundModel(model, part)
        for path in model.description.nested:
            if part in (path, path.rpartition("::")[2]):
                return "model", FoundModel(model, path)
        for body in model.bodies if model.description.nested else ():
            if part == body[len(model.description.scope_of(body)) :]:
                return "link", FoundModel(model, body)
        if part in model.description.joints and model.stays(part):
            return "joint", FoundModel(model, part)
    return None


def _other(kind: str, name: str) -> str:
    """That an entity of another kind has a name, and so hides others, as in Gazebo."""
    return f"'{name}' is a {kind}; what comes first of a name hides the others, as in Gazebo"


def find_model(world: World, name: str) -> FoundModel:
    """Model of a name: MODEL, OUTER::INNER or the plain name of one inside another.

    Raises:
        WorldError: there is none, or a link or joint of that name comes first.
    """
    kind, found = _entity(world, name) or ("", None)
    if found is None:
        return FoundModel(world.model(name))
    if kind != "model":
        raise WorldError(_other(kind, name))
    return found


def find_frame(world: World, name: str) -> Frame:
    """Frame of a name: a world frame, MODEL, MODEL::LINK or a link's plain name.

    Raises:
        SimError: there is none.
    """
    if name in WORLD_FRAMES:
        return Frame()
    kind, found = _entity(world, name) or ("", None)
    if found is not None and kind == "model":
        return Frame(*found.state())
    model, link = find_link(world, name, "reference frame")
    return Frame(*model.link_state(link))


def find_link(world: World, name: str, label: str = "link") -> tuple[Model, str]:
    """(Model, link name) of MODEL::LINK or of a plain link name (the first model's that has it).

    As in Gazebo a link that a URDF's fixed joint merges into another is none.

    Raises:
        WorldError: there is none; lists the links. Or a model or joint of that name comes first.
    """
    kind, found = _entity(world, name) or ("", None)
    if found is None:
        raise WorldError(
            f"{label} '{name}' does not exist; {_known(world, lambda model: model.bodies, 'links')}"
        )
    if kind != "link":
        raise WorldError(_other(kind, name))
    return found.model, found.path


def find_joint(world: World, name: str) -> tuple[Model, str]:
    """(Model, joint name) of a joint's plain name (the first model's that has it) or MODEL::JOINT.

    As in Gazebo those of models inside others are not found.

    Raises:
        WorldError: there is none; lists the joints.
    """
    for model in world.models.values():
        part = name[len(model.name) + 2 :] if name.startswith(f"{model.name}::") else name
        if part in model.description.joints and not model.description.scope_of(part):
            return model, part
    raise WorldError(
        f"joint '{name}' does not exist; "
        f"{_known(world, lambda model: model.description.joints, 'joints')}"
    )


def _known(world: World, parts: Callable[[Model], Iterable[str]], label: str) -> str:
    names = [f"{model.name}::{part}" for model in world.models.values() for part in parts(model)]
    more = f" and {len(names) - LISTED} more" if len(names) > LISTED else ""
    return f"{label} are {', '.join(names[:LISTED]) or '(none)'}{more}"
