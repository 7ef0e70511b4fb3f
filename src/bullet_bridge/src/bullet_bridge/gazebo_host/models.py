"""Models that plugins in C++ insert and remove."""

from __future__ import annotations

import os
import threading
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING
from xml.sax.saxutils import escape

from bullet_sim.errors import SimError
from bullet_sim.formats.resolve import Resolver
from bullet_sim.formats.sdf.world import parse_model
from bullet_sim.formats.spawn_text import SpawnText
from bullet_sim.formats.urdf import parse_urdf
from bullet_sim.pose import Pose
from bullet_sim.xml_reader import Node

from bullet_bridge.resolve import RosPackages

if TYPE_CHECKING:
    from bullet_sim.description.model import ModelDescription
    from bullet_sim.models.model import Model
    from bullet_sim.world import World

REMOVE, TEXT, FILE, CLONE = range(4)  # of ModelChange, see changes.hh
INCLUDE = '<sdf version="1.6"><world name="w"><include><uri>{}</uri></include></world></sdf>'


@dataclass(frozen=True)
class ModelChange:
    """A model that a plugin inserts or removes.

    Attributes:
        kind: REMOVE, TEXT, FILE or CLONE.
        what: name of a model that is removed or copied; text of an SDF or a URDF; path or URI.
        pose: of the new model; None: that of the text.
        may_rename: where its name is taken.
    """

    kind: int
    what: str
    pose: Pose | None = None
    may_rename: bool = False


class Models:
    """Makes the changes of models that plugins ask for, in our world.

    Args:
        connect: gives a new model its plugins and controllers; of a thread of its own.
        remove: removes a model by its name; of a thread of its own. None: the world's method, of
            the simulation thread.
    """

    def __init__(
        self,
        world: World,
        connect: Callable[[Model], None] | None = None,
        remove: Callable[[str], None] | None = None,
    ) -> None:
        self._world, self._connect, self._remove = world, connect, remove
        self._resolve = Resolver(RosPackages())

    def make(self, change: ModelChange) -> None:
        """Insert or remove a model, between two steps (simulation thread).

        Raises:
            SimError: it is not done; says why.
        """
        if change.kind != REMOVE:
            model = self._insert(change)
            if self._connect is not None:
                threading.Thread(target=self._connect, args=(model,), daemon=True).start()
        elif change.what in self._world.models:
            if self._remove is None:
                self._world.delete(change.what)
            else:
                threading.Thread(target=self._remove, args=(change.what,), daemon=True).start()

    def _insert(self, change: ModelChange) -> Model:
        world = self._world
        if change.kind == CLONE:
            copied = world.model(change.what)
            name = self._free_name(f"{change.what}_clone")
            pose = copied.pose if change.pose is None else change.pose
            return world.spawn(replace(copied.description, name=name), pose)
        described, origin = self._read(self._text(change))
        if described.name in world.models and change.may_rename:
            described = replace(described, name=self._free_name(described.name))
        return world.spawn(described, origin if change.pose is None else change.pose)

    def _read(self, text: str) -> tuple[ModelDescription, Pose]:
        """Description of a model, and its own pose."""
        sorted_text = SpawnText.read(text, "")
        root = sorted_text.text
        if sorted_text.kind == "urdf" and isinstance(root, Node):
            massless = self._world.massless_links
            described = parse_urdf(root, self._resolve, root.get("name", ""), massless)
            return described, described.origin
        if sorted_text.kind == "light":
            raise SimError("a light is not inserted, which here the services of lights do alone")
        return parse_model(root, self._resolve, "a model that a C++ plugin inserts")

    def _text(self, change: ModelChange) -> str:
        if change.kind == TEXT:
            return change.what
        if "://" in change.what:
            return INCLUDE.format(escape(change.what))
        try:
            with open(os.path.expanduser(change.what), encoding="utf-8") as file:
                return file.read()
        except OSError as error:
            raise SimError(f"'{change.what}' cannot be read: {error.strerror or error}") from error

    def _free_name(self, name: str) -> str:
        """As Gazebo's: with _0, _1 ... where it is taken."""
        taken, number, free = self._world.models, 0, name
        while free in taken:
            free, number = f"{name}_{number}", number + 1
        return free
