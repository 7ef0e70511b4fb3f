"""Contact properties and flags of <link> and <collision> of SDF, which URDFs become as well."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from bullet_sim.description.model import EVERYTHING, Link, Surface, Torsion
from bullet_sim.description.world import MAX_CONTACTS
from bullet_sim.errors import ModelError
from bullet_sim.xml_reader import (
    Node,
    child_flag,
    child_number,
    child_text,
    floats,
    is_true,
    number,
)

ENDLESS_FRICTION = 1e6
MAX_STIFFNESS = 1e5  # [N/m] above which Bullet's default hard contacts are used


def read_surface(element: Node, surface: Surface, label: str, warn: Callable[[str], None]) -> None:
    """Read the contact properties of a <collision>; what cannot be read stays unchanged.

    Args:
        surface: changed in place.
    """
    for key, (read, *paths) in _PROPERTIES.items():
        for path in paths:  # the first that exists counts
            text = child_text(element, path)
            if text is None:
                continue
            try:
                setattr(surface, key, read(text, f"{label} <{path}>"))
            except ModelError as error:
                warn(f"{error}; it is ignored")
            break
    if surface.direction is not None and not any(surface.direction):
        surface.direction = None
    torsional = element.find("surface/friction/torsional")
    if torsional is not None:
        surface.torsion = _torsion(torsional, f"{label} <torsional>")


def _torsion(element: Node, label: str) -> Torsion:
    coefficient, patch, surface, slip = (
        max(0.0, child_number(element, path, label, default))
        for path, default in (
            ("coefficient", 1.0), ("patch_radius", 0.0), ("surface_radius", 0.0), ("ode/slip", 0.0)
        )
    )  # fmt: skip
    by_patch = child_flag(element, "use_patch_radius", label, True)
    return Torsion(coefficient, patch, surface, by_patch, slip)


def soften(surface: Surface) -> None:
    """Give a surface of a URDF its <kp> and <kd>, where softer than Bullet's hard contact."""
    if surface.kp is not None and 0 < surface.kp < MAX_STIFFNESS:
        surface.stiffness = surface.kp
        surface.damping = 1.0 if surface.kd is None else surface.kd


def read_flags(element: Node, link: Link, label: str) -> None:
    """Set what a <link> says of collisions, gravity and decay of a Link."""
    link.self_collide = is_true(child_text(element, "self_collide", "false"))
    link.kinematic = is_true(child_text(element, "kinematic", "false"))
    link.gravity = is_true(child_text(element, "gravity", "true"))
    linear = child_number(element, "velocity_decay/linear", label, 0.0)
    angular = child_number(element, "velocity_decay/angular", label, 0.0)
    link.decay = max(0.0, linear), max(0.0, angular)


def _not_negative(text: str, label: str) -> float:
    return max(0.0, number(text, label))


def _friction(text: str, label: str) -> float:
    """As FrictionPyramid of Gazebo: a negative coefficient is as good as infinite."""
    value = number(text, label)
    return ENDLESS_FRICTION if value < 0.0 else value


def _whole(text: str, label: str) -> int:
    return int(min(_not_negative(text, label), MAX_CONTACTS))


def _bitmask(text: str, label: str) -> int:
    try:
        value = int(text, 0)
    except ValueError:
        value = -1
    if value < 0:
        raise ModelError(f"{label} is '{text}', must be a whole number such as 0x01")
    return value & EVERYTHING


# property -> its reader, its paths in <collision>
_PROPERTIES: dict[str, tuple[Any, ...]] = {
    "friction": (_friction, "surface/friction/ode/mu"),
    "friction2": (_friction, "surface/friction/ode/mu2"),
    "direction": (lambda text, label: floats(text, 3, label), "surface/friction/ode/fdir1"),
    "kp": (_not_negative, "surface/contact/ode/kp"),
    "kd": (_not_negative, "surface/contact/ode/kd"),
    "slip1": (_not_negative, "surface/friction/ode/slip1"),
    "slip2": (_not_negative, "surface/friction/ode/slip2"),
    "max_speed": (_not_negative, "surface/contact/ode/max_vel"),
    "min_depth": (_not_negative, "surface/contact/ode/min_depth"),
    "bitmask": (_bitmask, "surface/contact/collide_bitmask"),
    "most": (_whole, "max_contacts"),
    "bounce": (_not_negative, "surface/bounce/restitution_coefficient"),
    "bounce_speed": (number, "surface/bounce/threshold"),
    "without_contact": (
        lambda text, _: is_true(text),
        "surface/contact/collide_without_contact",
    ),
    "without_contact_bitmask": (_bitmask, "surface/contact/collide_without_contact_bitmask"),
}
