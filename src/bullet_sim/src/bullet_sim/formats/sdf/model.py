"""<model> of SDF: frames, links, poses -> ModelDescription."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from bullet_sim.description.model import (
    EVERYWHERE,
    INERTIA,
    WORLD_LINK,
    Link,
    ModelDescription,
    Surface,
)
from bullet_sim.errors import ModelError
from bullet_sim.formats.joints import JointReader, Tree, Version
from bullet_sim.formats.lights import parse_light
from bullet_sim.formats.materials import Resolve
from bullet_sim.formats.sdf.frames import Frames
from bullet_sim.formats.sdf.includes import Includes, OpenInclude, unused
from bullet_sim.formats.shapes import hollow_collision, parse_shape
from bullet_sim.formats.surfaces import read_flags, read_surface
from bullet_sim.plugins import parse_joint_sensor, parse_plugin, parse_sensor
from bullet_sim.plugins.grasping import parse_gripper
from bullet_sim.pose import Pose
from bullet_sim.xml_reader import Node, child_flag, child_number, child_text, is_true, sdf_pose


def read_inertial(element: Node, link: Link, label: str) -> None:
    """Set mass, center of mass and inertia of a Link from a <link>'s <inertial>."""
    link.mass, link.inertia = 1.0, np.eye(3)
    inertial = element.find("inertial")
    if inertial is None:
        return
    link.mass = child_number(inertial, "mass", label, 1.0)
    if link.mass < 0:
        inertial.warn(
            f"{label} mass is {link.mass}, must be 0 or more; 1 is used",
            "masses are below 0; 1 is used",
            label,
        )
        link.mass = 1.0
    pose = sdf_pose(inertial, f"{label} inertial")
    moments = []
    for key in INERTIA:  # a text that is no number becomes 0, for which lump.py computes an inertia
        is_one = key[1] == key[2] and inertial.find(f"inertia/{key}") is None
        moments.append(child_number(inertial, f"inertia/{key}", label, 1.0 if is_one else 0.0))
    link.set_inertia(pose, moments)


def read_surfaces(element: Node, link: Link, label: str, model: ModelDescription) -> list[Surface]:
    """Set the surface and the collision flags of a Link from a <link> and its <collision>s.

    Returns:
        The surface of each <collision>.
    """
    surfaces = []
    for index, part in enumerate(element.findall("collision")):
        surface = Surface()
        name = part.get("name") or f"collision {index}"
        read_surface(part, surface, f"{label} collision '{name}'", model.warn)
        _combine(link.surface, surface, first=index == 0)
        surfaces.append(surface)
    read_flags(element, link, label)
    return surfaces


def _combine(into: Surface, other: Surface, first: bool) -> None:
    """A link has one surface here: the lowest friction of its collisions, the bitmasks combined."""
    lowest = 1.0 if other.friction is None else other.friction
    if first or into.friction is None or lowest < into.friction:
        into.friction, into.friction2 = lowest, other.friction2
        into.direction = other.direction
    into.bitmask = other.bitmask if first else into.bitmask | other.bitmask
    into.max_speed = into.max_speed if other.max_speed is None else other.max_speed
    into.min_depth = max(into.min_depth, other.min_depth)


_MODEL_TAGS = {
    "link",
    "joint",
    "pose",
    "static",
    "self_collide",
    "plugin",
    "model",
    "frame",
    "allow_auto_disable",
    "enable_wind",
    "gripper",
    "placement_frame",
    "name",
    "uri",
}


def parse_model_element(
    element: Node, resolve: Resolve, version: Version, open_include: OpenInclude
) -> ModelDescription:
    """Read a <model>.

    Args:
        version: of the SDF document; up to (1, 4) joint axes are in the model's frame.

    Raises:
        ModelError: it has no link.
    """
    model = ModelDescription(element.get("name") or "model", warnings=element.document.warnings)
    Includes(model.name, open_include, model.warn).replace(element)
    model.static = is_true(child_text(element, "static", "false"))
    model.self_collide = is_true(child_text(element, "self_collide", "false"))
    model.auto_disable = is_true(child_text(element, "allow_auto_disable", "true"))
    reader = ModelReader(model, resolve)
    reader.read(element, "", Pose(), version)
    _find_loose_links(model, reader.poses)
    model.find_root(f"model '{model.name}'")
    model.root_pose = reader.poses[model.root]
    for name, (link, pose) in reader.nested.items():
        model.nested[name] = link, reader.poses[link].inverse() * pose
    for plugin, scope in reader.plugins:
        parse_plugin(plugin, model, scope)
    for gripper, scope in reader.grippers:
        parse_gripper(gripper, model, scope)
    return model


def _add_hollow(link: Link, part: Node, number: int, resolve: Resolve) -> None:
    """Note a collision that has no shape but is there in Gazebo, as its mesh is missing."""
    uri = part.find("geometry/mesh/uri")
    path = None if uri is None else uri.document.resolve_relative((uri.text or "").strip())
    shape = hollow_collision(path, resolve)
    if shape is not None:
        name = part.get("name") or "collision"
        link.hollow.append(replace(shape, link=link.name, name=name, number=number))


def _find_loose_links(model: ModelDescription, poses: dict[str, Pose]) -> None:
    """Find the links that are loose: those that are no joint's child, but for the root, which is
    the first of them that is held in the world, or the first one; the world where joints move
    against it."""
    if not model.links:
        raise ModelError(f"model '{model.name}' has no link")
    above = model.above()
    held = {joint.child for joint in model.joints.values() if joint.holds}
    roots = [name for name in model.links if name not in above]
    roots.sort(key=lambda name: (name != WORLD_LINK, name not in held))
    model.root = next(iter(roots), "")
    model.loose = {name: poses[name] for name in model.links if name in roots[1:]}


def _number_names(element: Node) -> None:
    """Append a number to names of links, joints and models in a <model> that are taken."""
    for tag in ("link", "joint", "model"):
        taken: set[str] = set()
        for part in element.findall(tag):
            name = unused(part.get("name") or tag, taken, part)
            part.set("name", name)
            taken.add(name)


class ModelReader:
    """Collects links, joints and plugins of a model and of the models inside it.

    Attributes:
        poses: link name -> Pose in the outermost model's frame.
        nested: name of a model inside it -> (its first link, Pose of its frame in the outermost
            model's).
        plugins, grippers: (<plugin> or <gripper>, prefix of its model's names), to be read when the
            root link is known.
    """

    def __init__(self, model: ModelDescription, resolve: Resolve) -> None:
        self.model, self._resolve = model, resolve
        self.poses: dict[str, Pose] = {}
        self._tree = Tree()
        self.nested: dict[str, tuple[str, Pose]] = {}
        self.plugins: list[tuple[Node, str]] = []
        self.grippers: list[tuple[Node, str]] = []

    def read(self, element: Node, prefix: str, pose: Pose, version: Version) -> None:
        """Add a <model> with a prefix of its names and its frame's pose in the outermost model."""
        _number_names(element)
        frames = Frames(element, element.get("name") or self.model.name)
        windy = child_flag(element, "enable_wind", f"model '{self.model.name}'", False)
        for link in element.findall("link"):
            self._link(link, prefix, pose, frames, windy)
        for inner in element.findall("model"):
            name = inner.get("name") or "model"
            there = pose * sdf_pose(
                inner, f"model '{name}'"
            )  # Gazebo's reader of it knows no frames
            self.read(inner, f"{prefix}{name}::", there, version)
            first = next((link for link in self.poses if link.startswith(f"{prefix}{name}::")), "")
            if first:
                self.nested[prefix + name] = first, there
        joints = JointReader(self.model, self.poses, prefix, frames, version, self._tree)
        for joint in element.findall("joint"):
            joints.read(joint)
            for sensor in joint.findall("sensor"):
                if prefix + joint.get("name", "") in self.model.joints:
                    parse_joint_sensor(sensor, prefix + joint.get("name", ""), self.model)
        self.plugins += [(plugin, prefix) for plugin in element.findall("plugin")]
        self.grippers += [(gripper, prefix) for gripper in element.findall("gripper")]
        for part in element:
            if isinstance(part.tag, str) and part.tag not in _MODEL_TAGS and ":" not in part.tag:
                self.model.warn(
                    f"<{part.tag}> in model '{self.model.name}' is not known here and is ignored",
                    f"models have <{part.tag}>, which is not known here and is ignored",
                    f"'{self.model.name}'",
                )

    def _link(self, element: Node, prefix: str, pose: Pose, frames: Frames, windy: bool) -> None:
        name = element.get("name") or "link"
        link = Link(prefix + name)
        label = f"link '{link.name}' of '{self.model.name}'"
        inner = frames.pose(name, element)
        read_inertial(element, link, label)
        surfaces = read_surfaces(element, link, label, self.model)
        link.wind = child_flag(element, "enable_wind", label, windy)
        for tag, shapes in (("visual", link.visuals), ("collision", link.collisions)):
            for number, part in enumerate(element.findall(tag)):
                in_link = inner.inverse() * frames.pose_of(part, name, f"{label} {tag}")
                shape = parse_shape(part, tag, link.name, in_link, self.model, self._resolve)
                if shape is None:
                    if shapes is link.collisions:
                        _add_hollow(link, part, number, self._resolve)
                    continue
                retro = child_number(part, "laser_retro", f"{label} {tag}", 0.0)
                shape = replace(shape, laser_retro=retro)
                if shapes is link.collisions:
                    shape = replace(shape, surface=surfaces[number], number=number)
                else:
                    flags = child_number(part, "visibility_flags", f"{label} {tag}", EVERYWHERE)
                    shape = replace(shape, visibility=int(flags) & EVERYWHERE)
                shapes.append(shape)
        self.model.links[link.name] = link
        self.poses[link.name] = pose * inner
        for sensor in element.findall("sensor"):
            parse_sensor(sensor, link.name, self.model)
        link.lights += [parse_light(light, label) for light in element.findall("light")]
