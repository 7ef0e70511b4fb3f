"""Names of gazebo_ros' interfaces -> models, links, joints and frames of the world."""

from dataclasses import dataclass, field

import numpy as np
from bullet_sim.errors import WorldError
from bullet_sim.pose import Pose

WORLD_FRAMES = ("", "world", "map", "/world", "/map")
LISTED = 30  # names in an error message


@dataclass(frozen=True)
class Frame:
    """A reference frame: pose in the world, velocity of its origin along world axes."""

    pose: Pose = Pose()
    linear: np.ndarray = field(default_factory=lambda: np.zeros(3))
    angular: np.ndarray = field(default_factory=lambda: np.zeros(3))

    def inward(self, pose, linear, angular):
        """A pose and a velocity of the world as seen from this frame, along its axes."""
        rotation = self.pose.matrix.T
        return (
            self.pose.inverse() * pose,
            rotation @ (linear - self.linear),
            rotation @ (angular - self.angular),
        )


def find_frame(world, name):
    """Frame of a name: a world frame, MODEL, MODEL::LINK or a link's plain name.

    Raises:
        SimError: there is none.
    """
    if name in WORLD_FRAMES:
        return Frame()
    if name in world.models:
        model = world.model(name)
        return Frame(*model.link_state(model.description.root))
    model, link = find_link(world, name, "reference frame")
    return Frame(*model.link_state(link))


def find_link(world, name, what="link"):
    """(Model, link name) of MODEL::LINK or of a plain link name (the first model's that has it).

    Raises:
        WorldError: there is none; lists the links.
    """
    found = _find(world, name, lambda model: model.link_names)
    if found is None:
        raise WorldError(
            f"{what} '{name}' does not exist; "
            f"{_known(world, lambda model: model.link_names, 'links')}"
        )
    return found


def find_joint(world, name):
    """(Model, joint name) of a joint's plain name (the first model's that has it) or MODEL::JOINT.

    Raises:
        WorldError: there is none; lists the joints.
    """
    found = _find(world, name, lambda model: model.description.joints)
    if found is None:
        raise WorldError(
            f"joint '{name}' does not exist; "
            f"{_known(world, lambda model: model.description.joints, 'joints')}"
        )
    return found


def _find(world, name, parts):
    model_name, scoped, part = name.partition("::")
    if scoped:
        model = world.models.get(model_name)
        return (model, part) if model is not None and part in parts(model) else None
    for model in world.models.values():
        if name in parts(model):
            return model, name
    return None


def _known(world, parts, kind):
    names = [f"{model.name}::{part}" for model in world.models.values() for part in parts(model)]
    more = f" and {len(names) - LISTED} more" if len(names) > LISTED else ""
    return f"{kind} are {', '.join(names[:LISTED]) or '(none)'}{more}"
