"""<scene> and <light> of SDF -> Scene."""

import math
from dataclasses import replace

import numpy as np

from bullet_sim.description.lights import KINDS, SUN, Fog, Light, Scene
from bullet_sim.formats.colors import rgba_of
from bullet_sim.formats.xml_read import child_flag, child_floats, child_number, child_text, sdf_pose

FOGS = {"linear": "linear", "exponential": "exp", "quadratic": "exp2", "exp": "exp", "exp2": "exp2"}
DOWN = (0.0, 0.0, -1.0)


def parse_scene(world, what):
    """Scene of a <world>, without lights.

    Args:
        world: the <world>.
        what: name for messages.
    """
    scene = world.find("scene")
    if scene is None:
        return Scene(lights=())
    what = f"{what} <scene>"
    background = None if scene.find("sky") is not None else _color(scene, "background", what, None)
    return Scene(
        _color(scene, "ambient", what, Scene.ambient),
        background,
        child_flag(scene, "shadows", what, True),
        _fog(scene.find("fog"), what),
        (),
    )


def sun(include, what):
    """Gazebo's model://sun at the pose of its <include>."""
    name = child_text(include, "name", SUN.name)
    if include.find("pose") is None:
        return replace(SUN, name=name)
    pose = sdf_pose(include, what)
    return replace(SUN, name=name, position=pose.position, direction=_turned(pose, SUN.direction))


def parse_light(element, what, pose=None):
    """Light of a <light>.

    Args:
        element: the <light>.
        what: name for messages.
        pose: Pose that replaces its own.
    """
    name = element.get("name") or "light"
    what = f"{what} light '{name}'"
    kind = element.get("type") or "point"
    if kind not in KINDS:
        element.warn(
            f"{what} has type '{kind}', known are {', '.join(KINDS)}; it becomes a point light",
            "lights have a type that is not known here and become point lights",
            f"'{name}' ({kind})",
        )
        kind = "point"
    pose = sdf_pose(element, what) if pose is None else pose
    reach = child_number(element, "attenuation/range", what, Light.reach)
    return Light(
        name,
        kind,
        pose.position,
        _turned(pose, child_floats(element, "direction", 3, what, DOWN)),
        _color(element, "diffuse", what, Light.diffuse),
        _color(element, "specular", what, Light.specular),
        reach,
        child_number(element, "attenuation/constant", what, Light.constant),
        child_number(element, "attenuation/linear", what, Light.linear),
        child_number(element, "attenuation/quadratic", what, Light.quadratic),
        child_number(element, "spot/inner_angle", what, Light.inner),
        child_number(element, "spot/outer_angle", what, Light.outer),
        child_number(element, "spot/falloff", what, Light.falloff),
        child_flag(element, "cast_shadows", what, Light.cast_shadows),
    )


def _turned(pose, direction):
    """A direction of a frame in its parent's, of length 1; down where it has none."""
    length = math.sqrt(sum(value * value for value in direction))
    if length < 1e-9:
        direction, length = DOWN, 1.0
    return tuple((pose.matrix @ (np.asarray(direction) / length)).tolist())


def _color(element, tag, what, default):
    """RGB of a child element."""
    text = child_text(element, tag)
    if text is None:
        return default
    found = rgba_of(element.find(tag), text, f"{what} <{tag}>")
    return default if found is None else found[:3]


def _fog(element, what):
    if element is None:
        return None
    kind = FOGS.get((child_text(element, "type") or "none").lower())
    if kind is None:
        return None
    what = f"{what} <fog>"
    return Fog(
        kind,
        _color(element, "color", what, Fog.color),
        child_number(element, "start", what, Fog.start),
        child_number(element, "end", what, Fog.end),
        child_number(element, "density", what, Fog.density),
    )
