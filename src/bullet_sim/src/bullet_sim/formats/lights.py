"""<light> of SDF, of worlds and of links, and of the <gazebo> elements of URDF -> Light."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TypeVar

from bullet_sim.description.model import LIGHT_TYPES, RGB, Light
from bullet_sim.description.world import SUN
from bullet_sim.formats.materials import rgba_of
from bullet_sim.pose import Pose, Vec3
from bullet_sim.xml_reader import (
    Node,
    child_flag,
    child_floats,
    child_number,
    child_text,
    sdf_pose,
)

D = TypeVar("D")
DOWN = (0.0, 0.0, -1.0)


def sun(include: Node, label: str) -> Light:
    """Gazebo's model://sun at the pose of its <include>."""
    name = child_text(include, "name", SUN.name)
    if include.find("pose") is None:
        return replace(SUN, name=name)
    above = replace(SUN, name=name, position=(0.0, 0.0, 0.0), direction=_unit(SUN.direction))
    return above.at(sdf_pose(include, label))


def parse_light(element: Node, label: str, pose: Pose | None = None) -> Light:
    """Light of a <light>.

    Args:
        pose: replaces its own.
    """
    name = element.get("name") or "light"
    label = f"{label} light '{name}'"
    light_type = element.get("type") or "point"
    if light_type not in LIGHT_TYPES:
        element.warn(
            f"{label} has type '{light_type}', known are {', '.join(LIGHT_TYPES)}; "
            "it becomes a point light",
            "lights have a type that is not known here and become point lights",
            f"'{name}' ({light_type})",
        )
        light_type = "point"
    pose = sdf_pose(element, label) if pose is None else pose
    reach = child_number(element, "attenuation/range", label, Light.reach)
    return Light(
        name,
        light_type,
        (0.0, 0.0, 0.0),
        _unit(child_floats(element, "direction", 3, label, DOWN)),
        child_color(element, "diffuse", label, Light.diffuse),
        child_color(element, "specular", label, Light.specular),
        reach,
        child_number(element, "attenuation/constant", label, Light.constant),
        child_number(element, "attenuation/linear", label, Light.linear),
        child_number(element, "attenuation/quadratic", label, Light.quadratic),
        child_number(element, "spot/inner_angle", label, Light.inner),
        child_number(element, "spot/outer_angle", label, Light.outer),
        child_number(element, "spot/falloff", label, Light.falloff),
        child_flag(element, "cast_shadows", label, Light.cast_shadows),
    ).at(pose)


def _unit(direction: Vec3) -> Vec3:
    """A direction as unit vector; down for a zero vector."""
    length = math.sqrt(sum(value * value for value in direction))
    if length < 1e-9:
        return DOWN
    x, y, z = direction
    return x / length, y / length, z / length


def child_color(element: Node, tag: str, label: str, default: D) -> RGB | D:
    """RGB of a child element."""
    text = child_text(element, tag)
    if text is None:
        return default
    color = rgba_of(element.find(tag), text, f"{label} <{tag}>")
    return default if color is None else color[:3]
