"""SDF of a world and of its models, as they are in the solver: for Gazebo's libraries.

A model has the links and joints that it has in Gazebo, with poses in the frame that Gazebo 11
expects without frame semantics: so that no version of sdformat changes them.
"""

from __future__ import annotations

import math
import xml.etree.ElementTree as ElementTree
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING
from xml.etree.ElementTree import Element
from xml.sax.saxutils import escape, quoteattr

import numpy as np
from bullet_sim.description.model import INERTIA, Joint, Link, Shape
from bullet_sim.pose import Array, Pose

if TYPE_CHECKING:
    from bullet_sim.models.model import Model
    from bullet_sim.world import World

SDF = '<sdf version="1.6">{}</sdf>'
UNLIMITED = 1e16  # SDF's limit of a joint that has none
TYPES = {
    "revolute": "revolute",
    "continuous": "revolute",
    "prismatic": "prismatic",
    "fixed": "fixed",
}
SAME = Pose()
NO_LINK = "world"  # a joint's parent that is none of the model's links


def world_text(world: World) -> str:
    """SDF of a world without its models."""
    place, settings = world.place, world.engine.settings
    solver = "" if settings is None else _tag("iters", settings.iterations)
    solver = f"<ode><solver>{solver}</solver></ode>"
    physics = f'<physics type="ode">{_tag("max_step_size", world.time_step)}{solver}</physics>'
    on_earth = "".join(
        (
            _tag("surface_model", "EARTH_WGS84"),
            _tag("latitude_deg", place.latitude),
            _tag("longitude_deg", place.longitude),
            _tag("elevation", place.altitude),
            _tag("heading_deg", math.degrees(math.pi / 2.0 - place.heading)),
        )
    )
    inside = physics + _tag("gravity", world.gravity)
    inside += f"<spherical_coordinates>{on_earth}</spherical_coordinates>"
    return SDF.format(f"<world name={quoteattr(world.name)}>{inside}</world>")


def model_text(model: Model) -> str:
    """SDF of a model, where it is now, its joints at 0."""
    poses = model.description.poses()
    links = "".join(_link(model, name, poses[name]) for name in model.bodies)
    joints = "".join(_joint(model, joint) for joint in joints_of(model))
    inside = _tag("static", int(model.is_static)) + _pose(model.pose)
    inside += _tag("allow_auto_disable", int(model.description.auto_disable))
    return SDF.format(f"<model name={quoteattr(model.name)}>{inside}{links}{joints}</model>")


def joints_of(model: Model) -> list[Joint]:
    """The joints that a model has in Gazebo, between links that it has there."""
    own = {*model.bodies, NO_LINK}
    return [
        joint
        for joint in model.description.joints.values()
        if joint.kind in TYPES and model.stays(joint.name) and parent_of(model, joint) in own
    ]


def parent_of(model: Model, joint: Joint) -> str:
    """The link that a joint's parent is in Gazebo; NO_LINK: it is the world."""
    if joint.parent in model.bodies or joint.parent not in model.description.links:
        return joint.parent
    return model.link_in_body(joint.parent)[0]


def with_plugin(text: str, name: str = "") -> str:
    """SDF of a holder of a <plugin>, of a model or of the world."""
    if not name:
        return SDF.format(f'<world name="holder">{text}</world>')
    return SDF.format(f"<model name={quoteattr(name)}>{text}</model>")


def sensor_text(
    model: Model, link: str, pose: Pose, element: Element, plugins: Sequence[str]
) -> tuple[str, str]:
    """The link, or joint, of Gazebo's model that has a <sensor>, and an SDF whose link has it.

    Args:
        link, pose: of the description in which it is, or the joint, and where in its frame.
        element: the sensor; one of which Paddock has the plugin is off until somebody wants it.
        plugins: texts of its plugins in C++.
    """
    if link not in model.bodies and link not in model.description.joints:
        link, offset = model.link_in_body(link)
        pose = offset * pose
    copied = ElementTree.fromstring(ElementTree.tostring(element))
    own = copied.findall("plugin")
    for child in [*own, *copied.findall("pose")]:
        copied.remove(child)
    for flag in copied.findall("always_on") if own and not plugins else ():
        flag.text = "0"
    text = ElementTree.tostring(copied, encoding="unicode").strip()
    opening, _, rest = text.partition(">")
    if opening.endswith("/"):
        opening, rest = opening[:-1], "</sensor>"
    inside = f"{opening}>{_pose(pose)}{''.join(plugins)}{rest}"
    holder = f"<model name={quoteattr(model.name)}><link name={quoteattr(link)}>"
    return link, SDF.format(f"{holder}{inside}</link></model>")


def _link(model: Model, name: str, pose: Pose) -> str:
    part, offset = model.link_in_body(name)
    inner = offset.inverse()
    if model.description.is_urdf:
        link = model.rigid_parts[part]
        shapes = [shape.at(inner) for shape in link.collisions] if part == name else []
    else:
        link, inner = model.description.links[name], SAME
        shapes = link.collisions
    inside = _pose(pose) + _inertial(link, inner)
    inside += _tag("gravity", int(link.gravity)) + _tag("self_collide", int(link.self_collide))
    inside += _tag("kinematic", int(link.kinematic))
    inside += "".join(_collision(model, name, shape) for shape in shapes)
    return f"<link name={quoteattr(name)}>{inside}</link>"


def _inertial(link: Link, inner: Pose) -> str:
    """<inertial>; inner: pose of the frame of its numbers in the link's."""
    if not link.mass > 0.0:
        return ""
    center = Pose(tuple(np.asarray(link.center).tolist()))
    turned: Array = inner.matrix @ link.inertia @ inner.matrix.T
    moments = (turned[0, 0], turned[0, 1], turned[0, 2], turned[1, 1], turned[1, 2], turned[2, 2])
    inertia = "".join(_tag(name, value) for name, value in zip(INERTIA, moments))
    place = Pose((inner * center).position)
    return (
        f"<inertial>{_pose(place)}{_tag('mass', link.mass)}<inertia>{inertia}</inertia></inertial>"
    )


def _collision(model: Model, link: str, shape: Shape) -> str:
    """<collision>; of a mesh or a heightmap none: its triangles are the solver's alone."""
    kind, size = shape.geometry.kind, shape.geometry.size
    if kind == "box":
        inside = _tag("size", size[:3])
    elif kind == "sphere":
        inside = _tag("radius", size[0])
    elif kind == "cylinder":
        inside = _tag("radius", size[0]) + _tag("length", size[1])
    elif kind == "plane":
        inside = _tag("normal", (0, 0, 1)) + _tag("size", (100, 100))
    else:
        return ""
    key = shape.link or link, shape.number
    name = model.collision_names.get(key, f"::collision_{shape.number}").rpartition("::")[2]
    geometry = f"<geometry><{kind}>{inside}</{kind}></geometry>"
    return f"<collision name={quoteattr(name)}>{_pose(shape.pose)}{geometry}</collision>"


def _joint(model: Model, joint: Joint) -> str:
    inside = _pose(joint.anchor) + _tag("parent", parent_of(model, joint))
    inside += _tag("child", joint.child)
    if joint.kind != "fixed":
        lower = -UNLIMITED if joint.lower is None else joint.lower
        upper = UNLIMITED if joint.upper is None else joint.upper
        limit = _tag("lower", lower) + _tag("upper", upper)
        limit += _tag("effort", joint.effort or -1) + _tag("velocity", joint.velocity or -1)
        dynamics = _tag("damping", joint.damping) + _tag("friction", joint.friction)
        dynamics += _tag("spring_stiffness", joint.stiffness) + _tag("spring_reference", joint.rest)
        axis = f"{_tag('xyz', joint.axis)}<limit>{limit}</limit><dynamics>{dynamics}</dynamics>"
        inside += f"<axis>{axis}</axis>"
    return f"<joint name={quoteattr(joint.name)} type='{TYPES[joint.kind]}'>{inside}</joint>"


def _pose(pose: Pose) -> str:
    return _tag("pose", (*pose.position, *pose.rpy))


def _tag(name: str, value: str | float | Sequence[float] | Array) -> str:
    if isinstance(value, Iterable) and not isinstance(value, str):
        value = " ".join(repr(float(number)) for number in value)
    return f"<{name}>{escape(str(value))}</{name}>"
