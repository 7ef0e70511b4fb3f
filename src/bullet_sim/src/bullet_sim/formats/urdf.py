"""URDF text -> ModelDescription; missing or invalid parts are repaired with a warning."""

import os
from dataclasses import replace

import numpy as np

from bullet_sim.description.parts import (
    MOVABLE_TYPES,
    Geometry,
    Joint,
    Link,
    ModelDescription,
    Shape,
    unit_axis,
)
from bullet_sim.errors import ModelError
from bullet_sim.formats.colors import rgba
from bullet_sim.formats.tags import gazebo as gazebo_tags
from bullet_sim.formats.transmissions import parse_transmissions
from bullet_sim.formats.xml_read import bound, floats, number, parse, urdf_origin

MESH_TYPES = (".obj", ".stl", ".dae")
UNLIMITED = 1e9  # [rad, m] stands for no limit on one side
UNSUPPORTED_TYPES = ("floating", "planar")


def parse_urdf(text, resolve, name="robot"):
    """Read a URDF.

    Args:
        text: the document, str or bytes.
        resolve: function URI -> file path (package://, model://, file:// or a path).
        name: name of the model, used in messages.

    Raises:
        ModelError: malformed, no or several root links, unknown joint type, bad number.
    """
    robot = parse(text, f"URDF of '{name}'")
    if robot.tag != "robot":
        raise ModelError(f"URDF of '{name}' starts with <{robot.tag}>, must be <robot>")
    _refuse_xacro(robot, name)
    model = ModelDescription(name)
    materials = {m.get("name"): _material_color(m, name) for m in robot.findall("material")}
    for element in robot.findall("link"):
        link = _link(element, materials, resolve, model)
        if link.name in model.links:
            raise ModelError(f"URDF of '{name}' has two links named '{link.name}'")
        model.links[link.name] = link
    for element in robot.findall("joint"):
        joint = _joint(element, model)
        if joint.name in model.joints:
            raise ModelError(f"URDF of '{name}' has two joints named '{joint.name}'")
        model.joints[joint.name] = joint
    model.find_root(f"URDF of '{name}'")
    _tie_to_world(model)
    for joint in model.joints.values():
        _stiffen(joint, model)
    gazebo_tags.apply(robot, model)
    model.transmissions = parse_transmissions(robot, model.joints, model.warn)
    return model


def _refuse_xacro(robot, name):
    for element in robot.iter():
        if isinstance(element.tag, str) and "xacro" in element.tag.split("}")[0]:
            raise ModelError(
                f"URDF of '{name}' has <xacro:{element.tag.split('}')[-1]}>: process "
                "it with xacro first"
            )


def _tie_to_world(model):
    """A root link `world` means the world itself, as in Gazebo: its child is fixed to it."""
    joints = model.joints_of(model.root)
    if model.root != "world" or not joints:
        return
    if len(joints) == 1 and joints[0].kind == "floating":
        del model.joints[joints[0].name], model.links["world"]
        model.root = joints[0].child
    else:
        model.fixed_base = True


def _stiffen(joint, model):
    if joint.kind in UNSUPPORTED_TYPES:
        model.warn(
            f"joint '{joint.name}' of '{model.name}' has type '{joint.kind}', which "
            "cannot be simulated here; it is held fixed"
        )
        joint.kind = "fixed"


def _link(element, materials, resolve, model):
    link = Link(element.get("name") or "")
    if not link.name:
        raise ModelError(f"a <link> of '{model.name}' has no name")
    what = f"link '{link.name}'"
    inertial = element.find("inertial")
    if inertial is not None:
        pose = urdf_origin(inertial, f"{what} inertial")
        mass, inertia = inertial.find("mass"), inertial.find("inertia")
        if mass is not None:
            link.mass = number(mass.get("value"), f"{what} mass")
        if link.mass < 0:
            raise ModelError(f"{what} mass is {link.mass}, must be 0 or more")
        if inertia is not None:
            xx, xy, xz, yy, yz, zz = (
                number(inertia.get(key, "0"), f"{what} inertia {key}")
                for key in ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
            )
            local = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
            link.inertia = pose.matrix @ local @ pose.matrix.T
        link.centre = np.array(pose.position)
    for tag, shapes in (("visual", link.visuals), ("collision", link.collisions)):
        for shape_element in element.findall(tag):
            shape = _shape(shape_element, f"{what} {tag}", materials, resolve, model)
            if shape is not None:
                shapes.append(
                    replace(
                        shape,
                        link=link.name,
                        name=shape_element.get("name") or _shape_name(link.name, tag, len(shapes)),
                    )
                )
    return link


def _shape_name(link, tag, number):
    """Name that sdformat gives to the number-th nameless collision or visual of a link."""
    return f"{link}_{tag}" + (f"_{number}" if number else "")


def _material_color(element, name):
    color = element.find("color")
    if color is None:
        return None
    return rgba(color.get("rgba") or "", f"material '{element.get('name')}' of '{name}' rgba")


def _shape(element, what, materials, resolve, model):
    geometry = element.find("geometry")
    if geometry is None or not len(geometry):
        model.warn(f"{what} has no geometry; it is left out")
        return None
    parsed = _geometry(geometry[0], what, resolve, model)
    if parsed is None:
        return None
    color = None
    material = element.find("material")
    if material is not None:
        color = _material_color(material, model.name) or materials.get(material.get("name"))
    return Shape(parsed, urdf_origin(element, what), color)


def _geometry(element, what, resolve, model):
    def get(key):
        return floats(element.get(key), 1, f"{what} {element.tag} {key}")[0]

    if element.tag == "box":
        return positive(Geometry("box", floats(element.get("size"), 3, f"{what} box size")), what)
    if element.tag == "cylinder":
        return positive(Geometry("cylinder", (get("radius"), get("length"))), what)
    if element.tag == "sphere":
        return positive(Geometry("sphere", (get("radius"),)), what)
    if element.tag == "mesh":
        scale = floats(element.get("scale", "1 1 1"), 3, f"{what} mesh scale")
        return mesh_geometry(element.get("filename", ""), scale, what, resolve, model)
    model.warn(
        f"{what} has geometry <{element.tag}>, which is not one of box, cylinder, "
        "sphere, mesh; it is left out"
    )
    return None


def positive(geometry, what):
    """The geometry, whose sizes must be greater than 0; a plane or a mesh has none.

    Raises:
        ModelError: names the shape and its size.
    """
    if geometry.size and min(geometry.size) <= 0:
        raise ModelError(f"{what} {geometry.kind} size is {geometry.size}, must be greater than 0")
    return geometry


def mesh_geometry(uri, scale, what, resolve, model):
    """Mesh geometry of a URI; None with a warning that names the file if it is unusable."""
    try:
        path = resolve(uri)
    except ValueError as error:
        model.warn(f"{what}: mesh '{uri}' is not found ({error}); it is left out")
        return None
    if 0.0 in scale:
        model.warn(f"{what}: mesh '{uri}' has scale {scale}, must not be 0; it is left out")
        return None
    if not os.path.isfile(path):
        model.warn(f"{what}: mesh file '{path}' (from '{uri}') does not exist; it is left out")
        return None
    if os.path.splitext(path)[1].lower() not in MESH_TYPES:
        model.warn(f"{what}: mesh '{path}' is not one of {', '.join(MESH_TYPES)}; it is left out")
        return None
    return Geometry("mesh", path=path, scale=tuple(scale))


def _joint(element, model):
    name, kind = element.get("name") or "", element.get("type")
    what = f"joint '{name}' of '{model.name}'"
    if not name:
        raise ModelError(f"a <joint> of '{model.name}' has no name")
    if kind not in MOVABLE_TYPES + ("fixed",) + UNSUPPORTED_TYPES:
        raise ModelError(
            f"{what} has type '{kind}', must be one of "
            f"{', '.join(MOVABLE_TYPES + ('fixed',) + UNSUPPORTED_TYPES)}"
        )
    ends = []
    for tag in ("parent", "child"):
        found = element.find(tag)
        link = found.get("link") if found is not None else None
        if link not in model.links:
            raise ModelError(
                f"{what} has {tag} link '{link}', which does not exist; "
                f"links are {', '.join(model.links)}"
            )
        ends.append(link)
    joint = Joint(name, kind, *ends, origin=urdf_origin(element, what))
    axis = element.find("axis")
    if axis is not None:
        vector = floats(axis.get("xyz", "1 0 0"), 3, f"{what} axis")
        if kind in MOVABLE_TYPES:
            joint.axis = unit_axis(vector, what)
    limit = element.find("limit")
    if limit is not None:
        joint.effort = abs(bound(limit.get("effort"), f"{what} effort limit") or 0.0)
        joint.velocity = abs(bound(limit.get("velocity"), f"{what} velocity limit") or 0.0)
    if kind in ("revolute", "prismatic") and limit is not None:
        lower = bound(limit.get("lower", "0"), f"{what} lower limit")
        upper = bound(limit.get("upper", "0"), f"{what} upper limit")
        if lower is not None or upper is not None:  # PyBullet has both or none
            joint.lower = -UNLIMITED if lower is None else lower
            joint.upper = UNLIMITED if upper is None else upper
            if joint.lower > joint.upper:
                raise ModelError(f"{what} has lower limit {lower} above upper {upper}")
    dynamics = element.find("dynamics")
    if dynamics is not None:
        joint.damping = max(0.0, number(dynamics.get("damping", "0"), f"{what} damping"))
        joint.friction = max(0.0, number(dynamics.get("friction", "0"), f"{what} friction"))
    if element.find("mimic") is not None:
        model.warn(f"{what} has <mimic>, which Gazebo ignores, too")
    return joint
