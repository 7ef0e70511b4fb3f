"""URDF -> ModelDescription."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from bullet_sim.description.model import (
    INERTIA,
    RGBA,
    Geometry,
    Link,
    ModelDescription,
    Shape,
)
from bullet_sim.errors import ModelError, reads
from bullet_sim.formats import gazebo as gazebo_tags
from bullet_sim.formats.joints import (
    UNSUPPORTED_TYPES,
    check_mimics,
    read_joints,
    read_sdf_joints,
)
from bullet_sim.formats.lumping import LEAVE_OUT, keep_joints, leave_out
from bullet_sim.formats.materials import Resolve, rgba_of
from bullet_sim.formats.shapes import first_geometry, hollow_collision, mesh_geometry, usable_size
from bullet_sim.formats.transmissions import parse_transmissions
from bullet_sim.pose import Pose
from bullet_sim.xml_reader import Node, child_floats, child_number, parse, urdf_origin

PARTS = {"gazebo", "joint", "link", "material", "sensor", "transmission"}  # of a <robot>
_ONE = (1.0, 1.0, 1.0)
_SIZES = {"box": ("size",), "cylinder": ("radius", "length"), "sphere": ("radius",)}


@reads
def parse_urdf(
    text: str | bytes | Node, resolve: Resolve, name: str = "robot", massless: str = LEAVE_OUT
) -> ModelDescription:
    """Read a URDF.

    Args:
        resolve: of package://, model://, file:// or a path.
        name: name of the model, used in messages.
        massless: what happens to links without mass that no fixed joint merges into one that has
            some: leave_out: they, their joints and all that hangs on them, as in Gazebo; keep: each
            gets a small mass.

    Raises:
        ModelError: malformed, no <robot>, no link, several root links.
    """
    model = ModelDescription(name, is_urdf=True)
    robot = parse(text, f"URDF of '{name}'", model.warnings)
    if robot.tag != "robot":
        raise ModelError(f"URDF of '{name}' starts with <{robot.tag}>, must be <robot>")
    model.origin = urdf_origin(robot, f"robot '{name}'")
    xacro_tag = _xacro_tag(robot, name)
    materials: dict[str | None, RGBA | None] = {}
    for element in robot.findall("material"):
        materials.setdefault(element.get("name"), _material_color(element, name))
    for element in robot.findall("link"):
        link = _link(element, materials, resolve, model)
        if link is not None:
            model.links[link.name] = link
    if xacro_tag and not model.links:
        raise ModelError(
            f"URDF of '{name}' has no link but <{xacro_tag}>: process it with xacro first"
        )
    read_joints(robot, model)
    try:
        model.find_root(f"URDF of '{name}'")
    except ModelError as error:
        raise ModelError(f"{error}{_unexpanded(robot)}") from None
    keep_joints(robot, model, massless)
    gone = leave_out(model) if massless == LEAVE_OUT else set()
    _fix_to_world(model)
    _free_links(model)
    read_sdf_joints(robot, model)
    model.transmissions = parse_transmissions(robot)
    check_mimics(model)
    gazebo_tags.apply(robot, model, resolve, gone)
    return model


def _unexpanded(robot: Node) -> str:
    """A sentence's end that names macros which xacro has left as they are, or ""."""
    tags = dict.fromkeys(node.tag for node in robot if node.tag not in PARTS and node.attrib)
    if not tags:
        return ""
    first = next(iter(tags))
    return f"; <{first}> is no URDF: xacro of ROS Noetic expands a macro only as <xacro:{first}>"


def _xacro_tag(robot: Node, name: str) -> str:
    """The first tag of xacro, or '', with a warning for each; as in Gazebo, they are ignored."""
    nodes = [node for node in robot.iter() if node.tag.startswith("xacro:")]
    for node in nodes:
        node.warn(
            f"<{node.tag}> in the URDF of '{name}' is ignored: process it with xacro first",
            "xacro tags are ignored: process the file with xacro first",
            f"<{node.tag}>",
        )
    return nodes[0].tag if nodes else ""


def _fix_to_world(model: ModelDescription) -> None:
    """A root link `world` means the world itself, as in Gazebo: its child is fixed to it."""
    joints = model.joints_of(model.root)
    if model.root != "world" or not joints:
        return
    if len(joints) == 1 and joints[0].kind in UNSUPPORTED_TYPES:  # as in Gazebo, without its origin
        del model.joints[joints[0].name], model.links["world"]
        model.root = joints[0].child
    else:
        model.fixed_base = True


def _free_links(model: ModelDescription) -> None:
    """Drop joints that sdformat does not know: the links below start at the model's pose, free."""
    for joint in list(model.joints.values()):
        if joint.kind in UNSUPPORTED_TYPES:
            model.warn(
                f"joint '{joint.name}' of '{model.name}' has type '{joint.kind}', which is none in "
                f"Gazebo; link '{joint.child}' moves freely and starts at the model's pose",
                f"joints of type {joint.kind} are none in Gazebo: their links move freely and "
                "start at the model's pose",
                f"'{joint.name}'",
            )
            del model.joints[joint.name]
            model.loose[joint.child] = Pose()


def _link(
    element: Node,
    materials: dict[str | None, RGBA | None],
    resolve: Resolve,
    model: ModelDescription,
) -> Link | None:
    link = Link(element.get("name") or "")
    label = f"link '{link.name}'"
    if not link.name or link.name in model.links:
        error = "has no name" if not link.name else "is there already: there are two of that name"
        element.warn(
            f"{label} of '{model.name}' {error}; it is left out",
            "links are left out",
            label,
        )
        return None
    if not _inertial(element, link, label):
        return link
    for part in element.findall("visual"):
        shape = _shape(part, f"{label} visual", materials, resolve, model)
        if shape is not None:
            name = part.get("name") or _shape_name(link.name, "visual", len(link.visuals))
            link.visuals.append(replace(shape, link=link.name, name=name))
    for part in element.findall("collision"):
        shape = _shape(part, f"{label} collision", materials, resolve, model)
        shapes = link.collisions
        if shape is None:
            mesh = part.find("geometry/mesh")
            uri = None if mesh is None else mesh.get("filename", "")
            shape, shapes = hollow_collision(uri, resolve), link.hollow
        if shape is not None:
            given, number = part.get("name") or "", len(link.collisions) + len(link.hollow)
            name = given or _shape_name(link.name, "collision", number)
            shapes.append(replace(shape, link=link.name, name=name, number=number, given=given))
    return link


def _inertial(element: Node, link: Link, label: str) -> bool:
    """Read a link's mass and inertia; returns whether its shapes are to be read, too.

    urdfdom reads a link's <inertial> first and gives the link up where it has a mass, but no
    <inertia>: in Gazebo such a link has a mass, but nothing to see or to collide with.
    """
    inertial = element.find("inertial")
    if inertial is None:
        return True
    pose = urdf_origin(inertial, f"{label} inertial")
    mass, inertia = inertial.find("mass"), inertial.find("inertia")
    if mass is not None:
        link.mass = child_number(mass, "@value", f"{label} mass", 0.0)
        if link.mass < 0:
            mass.warn(
                f"{label} mass is {link.mass}, must be 0 or more; 0 is used",
                "masses are below 0; 0 is used",
                label,
            )
            link.mass = 0.0
    if inertia is not None:
        moments = [child_number(inertia, f"@{key}", f"{label} inertia", 0.0) for key in INERTIA]
        link.set_inertia(pose, moments)
    link.center = np.array(pose.position)
    if mass is None or inertia is not None:
        return True
    macros = [f"<{child.tag}>" for child in inertial if child.tag not in ("origin", "mass")]
    inertial.warn(
        f"{label} has a mass, but no <inertia>; as in Gazebo its shapes are left out, and nothing "
        "collides with it" + (f"; is {macros[0]} a macro without 'xacro:'?" if macros else ""),
        "links have a mass, but no <inertia>, and lose their shapes, as in Gazebo",
        label,
    )
    return False


def _shape_name(link: str, tag: str, index: int) -> str:
    """Name that sdformat gives to a nameless collision or visual with an index in its link."""
    return f"{link}_{tag}" + (f"_{index}" if index else "")


def _material_color(element: Node, name: str) -> RGBA | None:
    color = element.find("color")
    if color is None:
        return None
    label = f"material '{element.get('name')}' of '{name}' rgba"
    return rgba_of(color, color.get("rgba"), label)


def _shape(
    element: Node,
    label: str,
    materials: dict[str | None, RGBA | None],
    resolve: Resolve,
    model: ModelDescription,
) -> Shape | None:
    geometry = first_geometry(element, label, model)
    if geometry is None:
        return None
    parsed = _geometry(geometry, label, resolve, model)
    if parsed is None:
        return None
    color = None
    material = element.find("material")
    if material is not None:
        color = _material_color(material, model.name) or materials.get(material.get("name"))
    return Shape(parsed, urdf_origin(element, label), color)


def _size(element: Node, label: str) -> tuple[float | None, ...]:
    """Size of a box, cylinder or sphere; None for each text that is no number."""
    label = f"{label} {element.tag}"
    if element.tag == "box":
        missing = (0.0,) * 3 if element.get("size") is None else (None,)
        return child_floats(element, "@size", 3, label, missing)
    return tuple(
        child_number(element, f"@{key}", label, 0.0 if element.get(key) is None else None)
        for key in _SIZES[element.tag]
    )


def _geometry(
    element: Node, label: str, resolve: Resolve, model: ModelDescription
) -> Geometry | None:
    if element.tag in _SIZES:
        size = _size(element, label)
        numbers = tuple(value for value in size if value is not None)
        if len(numbers) < len(size):
            return None
        return usable_size(Geometry(element.tag, numbers), label, model)
    if element.tag == "mesh":
        scale = child_floats(element, "@scale", 3, f"{label} mesh", _ONE)
        return mesh_geometry(element.get("filename", ""), scale, label, resolve, model)
    model.warn(
        f"{label} has geometry <{element.tag}>, which is not one of box, cylinder, "
        "sphere, mesh; it is left out",
        "shapes have a geometry that is none of box, cylinder, sphere, mesh and are left out",
        f"{label} <{element.tag}>",
    )
    return None
