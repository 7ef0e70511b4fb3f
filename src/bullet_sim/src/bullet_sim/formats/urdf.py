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
from bullet_sim.formats.shapes import hollow_collision, mesh_geometry, usable_size
from bullet_sim.formats.transmissions import parse_transmissions
from bullet_sim.formats.urdfdom import SIZES, inertia_fault, mass_fault, shape_fault
from bullet_sim.pose import Pose
from bullet_sim.xml_reader import Node, child_floats, child_number, parse, urdf_origin

PARTS_OF_INERTIAL = ("origin", "mass", "inertia")
PARTS = {"gazebo", "joint", "link", "material", "sensor", "transmission"}  # of a <robot>
_ONE = (1.0, 1.0, 1.0)


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
            gets a small mass, and one whose <inertial> cannot be read keeps its shapes.

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
        link = _link(element, materials, resolve, model, massless)
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
    gone = leave_out(model, _unexpanded(robot)) if massless == LEAVE_OUT else set()
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
    massless: str,
) -> Link | None:
    """A link with what urdfdom reads of it, or None with a warning."""
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
    if not _inertial(element.find("inertial"), link, label, massless == LEAVE_OUT):
        return link
    parts = [*element.findall("visual"), *element.findall("collision")]
    for part, fault in ((part, shape_fault(part)) for part in parts):
        if fault:
            part.warn(
                f"{label} {part.tag} {fault}; it is left out with the shapes of the link that "
                "urdfdom reads after it (first all visuals, then all collisions), as in Gazebo",
                "links lose shapes from the first on that cannot be read, as in Gazebo",
                label,
            )
            break
        shape = _shape(part, f"{label} {part.tag}", materials, resolve, model)
        given, shapes, number = part.get("name") or "", link.visuals, len(link.visuals)
        if part.tag == "collision":
            shapes, number = link.collisions, len(link.collisions) + len(link.hollow)
            if shape is None:
                mesh = part.find("geometry/mesh")
                uri = None if mesh is None else mesh.get("filename", "")
                shape, shapes = hollow_collision(uri, resolve), link.hollow
        if shape is not None:
            name = given or _shape_name(link.name, part.tag, number)
            shapes.append(replace(shape, link=link.name, name=name, number=number, given=given))
    return link


def _inertial(inertial: Node | None, link: Link, label: str, strict: bool) -> bool:
    """Read a link's mass and inertia; returns whether its shapes are to be read, too.

    Args:
        strict: as urdfdom, which gives the link up at the first fault, so that what comes after it
            is 0; False: a bad value costs itself.
    """
    if inertial is None:
        return True
    massless = mass_fault(inertial)
    fault = massless or inertia_fault(inertial)
    if fault and strict:
        macros = [f"<{child.tag}>" for child in inertial if child.tag not in PARTS_OF_INERTIAL]
        inertial.warn(
            f"{label} inertial {fault}; as in Gazebo its {'mass' if massless else 'inertia'} "
            "counts "
            "as 0 and it has no shapes"
            + (f"; is {macros[0]} a macro without 'xacro:'?" if macros else ""),
            "links have an <inertial> that cannot be read, and lose their shapes, as in Gazebo",
            label,
        )
        if massless:
            return False
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
    link.center = np.array(pose.position)
    if inertia is not None and not (fault and strict):
        moments = [child_number(inertia, f"@{key}", f"{label} inertia", 0.0) for key in INERTIA]
        link.set_inertia(pose, moments)
    return not (fault and strict)


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
    """A shape without a fault, or None with a warning where its size or mesh is not usable."""
    geometry = next(element.iter("geometry"))[0]
    parsed = _geometry(geometry, label, resolve, model, element.tag == "collision")
    if parsed is None:
        return None
    color = None
    material = element.find("material")
    if material is not None:
        color = _material_color(material, model.name) or materials.get(material.get("name"))
    return Shape(parsed, urdf_origin(element, label), color)


def _geometry(
    element: Node, label: str, resolve: Resolve, model: ModelDescription, touches: bool
) -> Geometry | None:
    if element.tag == "mesh":
        scale = child_floats(element, "@scale", 3, f"{label} mesh", _ONE)
        return mesh_geometry(element.get("filename", ""), scale, label, resolve, model)
    sizes = [
        child_floats(element, f"@{key}", count, f"{label} {element.tag}", ())
        for key, count in SIZES[element.tag]
    ]
    return usable_size(Geometry(element.tag, sum(sizes, ())), label, model, touches)
