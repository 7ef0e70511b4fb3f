"""The world as a page in a browser or a recorder shows it: its looks, and where everything is.

Two values, so that a frame stays small: a scene changes when models come and go, a view with each
step; contacts are a third one, for those who want them. All are lists and dicts, for JSON; lengths
in m, angles in rad, quaternions (x, y, z, w).
"""

from __future__ import annotations

import math
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

import numpy as np

from bullet_sim.description.mirrors import end_of

if TYPE_CHECKING:
    from bullet_sim.models.model import Model
    from bullet_sim.snapshot import BodyState

MAX_CONTACTS = 1000  # that contacts() has


class WorldViews:
    """Makes scenes and views of a world, which is not changed.

    Args:
        world: World, to be used in the thread that owns its engine.
    """

    def __init__(self, world: Any) -> None:
        self._world = world
        self._number = 0  # of the present scene
        self._last: Any = None  # what it was made of

    def view(self) -> dict[str, Any]:
        """Time and the bodies that can move.

        Returns:
            time [s]; scene: number of the scene that the bodies belong to; bodies: for each of them
            its key, position, quaternion and joint positions. A body with a number that is not
            finite is missing.
        """
        self._count_scene()
        states = (model.state() for model in self._world.models.values() if not model.is_static)
        rows = [row for row in map(state_row, states) if all(map(math.isfinite, row))]
        return {"time": self._world.time, "scene": self._number, "bodies": rows}

    def scene(self) -> dict[str, Any]:
        """All models with their visuals, and the light.

        Returns:
            number; light: the fields of Scene; bodies: for each model its key, name, whether it is
            static, state as in a view, links (fields of VisualLink with their name and the name of
            the joint to their parent, empty if the file has no such joint) and frames: of each link
            of its file the row of `links` that it belongs to, and its pose there.
        """
        self._count_scene()
        return {
            "number": self._number,
            "light": asdict(self._world.scene),
            "bodies": [body_fields(model) for model in self._world.models.values()],
        }

    def contacts(self) -> dict[str, Any]:
        """Where bodies press against each other, as of the last step.

        Returns:
            contacts: for each point its position [m], its unit normal (both in the world frame) and
            its normal force [N]: seven numbers; the strongest first, at most MAX_CONTACTS. A point
            with a number that is not finite is missing.
        """
        places, normals, forces = self._world.engine.all_contacts()
        rows = np.column_stack([places, normals, forces])
        rows = rows[np.isfinite(rows).all(axis=1)]
        strongest = np.argsort(-rows[:, 6], kind="stable")[:MAX_CONTACTS]
        return {"contacts": rows[strongest].round(5).tolist()}

    def _count_scene(self) -> None:
        """Give the scene another number if it is not what it was."""
        models = self._world.models.values()
        static = tuple(model.pose for model in models if model.is_static)
        present = (tuple(self._world.sources()), self._world.scene, static)
        if present != self._last:
            self._number, self._last = self._number + 1, present


def body_fields(model: Model) -> dict[str, Any]:
    """A model's part of a scene."""
    names = model.body.links
    joints = {end_of(joint): joint.name for joint in model.joints.limits.values()}
    links = [
        {**asdict(link), "name": name, "joint": joints.get(name, "")}
        for name, link in zip(names, model.source.links)
    ]
    rows = {name: row for row, name in enumerate(names)}
    frames = {}
    for name in model.link_names:
        part, pose = model.link_in_body(name)
        frames[name] = [rows[part], *pose.position, *pose.orientation]
    return {
        "key": model.source.key,
        "name": model.name,
        "static": model.is_static,
        "state": state_row(model.state()),
        "links": links,
        "frames": frames,
    }


def state_row(state: BodyState) -> list[float]:
    """Key, position, quaternion and joint positions of a body."""
    return [state.key, *state.position, *state.orientation, *state.joints]
