"""Shapes of URDF and SDF: geometry, colors, materials.

Colors of Gazebo's standard materials, e.g. Gazebo/Orange, as RGBA 0..1. The names are Gazebo's;
the values are not: Gazebo's textures become similar plain colors.
"""

import math
import os
import re
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TypeVar

from bullet_sim.description.model import RGB, RGBA, Finish, Geometry, ModelDescription, Shape
from bullet_sim.pose import Pose, Vec3
from bullet_sim.xml_reader import (
    Node,
    child_flag,
    child_floats,
    child_number,
    child_text,
    floats,
    is_true,
    leading_numbers,
    warn_replaced,
)

D = TypeVar("D")
Resolve = Callable[[str], str]  # URI -> path of a file

_GREY = {
    "Grey": 0.7,
    "Gray": 0.7,
    "DarkGrey": 0.25,
    "DarkGray": 0.25,
    "LightGrey": 0.85,
    "White": 1.0,
    "FlatBlack": 0.08,
    "Black": 0.04,
    "Chrome": 0.78,
    "GreyTransparent": 0.7,
}
_COLORS = {
    "Red": (0.9, 0.08, 0.08),
    "RedBright": (0.95, 0.15, 0.1),
    "DarkRed": (0.5, 0.05, 0.05),
    "Green": (0.1, 0.8, 0.1),
    "DarkGreen": (0.05, 0.4, 0.05),
    "Blue": (0.1, 0.15, 0.9),
    "DarkBlue": (0.05, 0.07, 0.45),
    "SkyBlue": (0.3, 0.6, 0.95),
    "Yellow": (0.95, 0.9, 0.1),
    "DarkYellow": (0.65, 0.6, 0.05),
    "ZincYellow": (0.97, 0.93, 0.2),
    "Orange": (1.0, 0.5, 0.05),
    "DarkOrange": (0.8, 0.38, 0.03),
    "Gold": (0.85, 0.68, 0.22),
    "Purple": (0.62, 0.12, 0.75),
    "DarkPurple": (0.35, 0.07, 0.42),
    "Indigo": (0.29, 0.05, 0.5),
    "Violet": (0.6, 0.35, 0.85),
    "Turquoise": (0.15, 0.85, 0.8),
    "DarkTurquoise": (0.05, 0.55, 0.55),
    "Magenta": (0.9, 0.1, 0.8),
    "DarkMagenta": (0.5, 0.05, 0.45),
    "Pink": (0.95, 0.6, 0.7),
    "Brown": (0.45, 0.28, 0.12),
    "Wood": (0.6, 0.42, 0.24),
    "WoodFloor": (0.55, 0.4, 0.25),
    "WoodPallet": (0.65, 0.5, 0.32),
    "Bricks": (0.6, 0.3, 0.24),
    "Grass": (0.3, 0.5, 0.2),
    "Road": (0.22, 0.22, 0.23),
    "Residential": (0.3, 0.3, 0.31),
    "Pedestrian": (0.5, 0.5, 0.5),
    "Mud": (0.35, 0.25, 0.16),
    "PaintedWall": (0.8, 0.78, 0.72),
    "CeilingTiled": (0.88, 0.88, 0.85),
    "Rockwall": (0.5, 0.47, 0.42),
    "Tarmac": (0.2, 0.2, 0.2),
    "Asphalt": (0.2, 0.2, 0.2),
    "Gravel": (0.45, 0.43, 0.4),
    "Sand": (0.76, 0.7, 0.5),
    "Runway": (0.3, 0.3, 0.3),
}
_SUFFIXES = (
    "Transparent",
    "TransparentOverlay",
    "GlowOutline",
    "Glow",
    "Laser",
    "LaserScan",
    "Bright",
)


def gazebo_color(name: str) -> RGBA | None:
    """RGBA of a standard material; None: no such material.

    Args:
        name: 'Gazebo/Orange' or 'Orange'; Transparent and Glow forms count, too.
    """
    plain = name.strip().rsplit("/", 1)[-1]
    for suffix in ("",) + _SUFFIXES:
        base = plain[: -len(suffix)] if suffix and plain.endswith(suffix) else plain
        alpha = 0.5 if suffix.startswith(("Transparent", "Laser")) and base != plain else 1.0
        if base in _GREY:
            return (_GREY[base],) * 3 + (alpha,)
        if base in _COLORS:
            return _COLORS[base] + (alpha,)
    return None


def rgba_of(element: Node | None, text: str | None, label: str) -> RGBA | None:
    """RGBA 0..1 of 3 or 4 numbers, or None with a warning; values are clamped to 0..1.

    Args:
        element: contains the text; takes the warning.
    """
    values, _ = leading_numbers(text, 4)
    values += (1.0,) * (len(values) == 3)
    if len(values) == 4 and all(map(math.isfinite, values)):
        r, g, b, a = (min(1.0, max(0.0, value)) for value in values)
        return r, g, b, a
    message = f"{label} is '{(text or '').strip()}', must be 3 or 4 numbers from 0 to 1"
    warn_replaced(element, label, text, message, None)
    return None


# Where Gazebo has searched for scripts already when a material names none.
DEFAULT_SCRIPTS = ("file://media/materials/scripts", "file://Media/materials/scripts")
_TOKEN = re.compile(r'"[^"]*"|[{}]|[^\s{}]+')


@dataclass(frozen=True)
class Material:
    """Path of a texture image, or a colour RGBA 0..1."""

    texture: str = ""
    color: RGBA | None = None


def read_materials(text: str) -> dict[str, tuple[str, RGBA | None]]:
    """All materials of an OGRE script: name -> (image's file name or '', RGBA or None).

    The first texture and the first color of a material count; inherited values
    ("material A : B") are copied; everything else is ignored.
    """
    materials: dict[str, tuple[str, RGBA | None]] = {}
    current, depth = None, 0
    for line in re.sub(r"/\*.*?\*/", "", text, flags=re.DOTALL).splitlines():
        tokens = _TOKEN.findall(line.split("//")[0])
        if tokens and tokens[0] == "material" and depth == 0 and len(tokens) > 1:
            names = [token.strip('"') for token in tokens[1:] if token not in ("{", "}", ":")]
            current = names[0]
            parent = materials.get(names[1]) if len(names) > 1 else None
            materials[current] = parent or ("", None)
        elif current is not None and len(tokens) > 1:
            materials[current] = _updated(materials[current], tokens)
        depth = max(0, depth + tokens.count("{") - tokens.count("}"))
    return materials


def _updated(so_far: tuple[str, RGBA | None], tokens: list[str]) -> tuple[str, RGBA | None]:
    texture, color = so_far
    if tokens[0] == "texture":
        texture = tokens[1].strip('"')
    elif tokens[0] in ("diffuse", "ambient") and (color is None or tokens[0] == "diffuse"):
        try:
            values = tuple(min(1.0, max(0.0, float(token))) for token in tokens[1:5])
        except ValueError:
            return so_far
        if len(values) >= 3:
            r, g, b, a = (*values, 1.0)[:4]
            color = (r, g, b, a)
    return texture, color


def script_material(
    element: Node, resolve: Resolve, label: str, model: ModelDescription
) -> Material | None:
    """Material of a <script> element, or None with a warning when it does not exist.

    Args:
        element: <script> with <name> and <uri>s.
    """
    name = child_text(element, "name", "")
    color = gazebo_color(name) if name.startswith("Gazebo/") else None
    if color is not None:
        return Material(color=color)
    files, folders = [], []
    uris = [(uri.text or "").strip() for uri in element.findall("uri")]
    for uri in uris or DEFAULT_SCRIPTS:
        try:
            path = resolve(element.document.resolve_relative(uri))
        except ValueError:
            continue
        folders.append(path if os.path.isdir(path) else os.path.dirname(path))
        files += _scripts(path)
    for path in files:
        try:
            with open(path, encoding="utf-8", errors="replace") as file:
                material = read_materials(file.read()).get(name)
        except OSError:
            continue
        if material is None:
            continue
        texture, color = material
        if not texture:
            return Material(color=color)
        image = _texture_path(texture, folders)
        if image:
            return Material(image, color)
        model.warn(
            f"{label}: image '{texture}' of material '{name}' is in none of {', '.join(folders)}",
            "images of materials are missing",
            f"'{texture}'",
        )
        return Material(color=color)
    model.warn(
        f"{label}: material '{name}' is not in its scripts; it stays gray",
        "materials are not in their scripts and stay gray",
        f"'{name}'",
    )
    return None


def _scripts(path: str) -> list[str]:
    if os.path.isdir(path):
        return sorted(
            os.path.join(path, name) for name in os.listdir(path) if name.endswith(".material")
        )
    return [path] if os.path.isfile(path) else []


def _texture_path(name: str, folders: list[str]) -> str:
    for folder in folders:
        for directory in (
            folder,
            os.path.join(folder, "..", "textures"),
            os.path.join(folder, "materials", "textures"),
        ):
            path = os.path.normpath(os.path.join(directory, name))
            if os.path.isfile(path):
                return path
    return ""


MESH_TYPES = (".obj", ".stl", ".dae")
MIN_SIZE = 1e-3  # [m] replaces a size of 0
MISSING = "meshes are missing and left out"


def usable_size(geometry: Geometry, label: str, model: ModelDescription) -> Geometry | None:
    """The geometry with sizes above 0, or None with a warning; planes and meshes have no size.

    A negative size counts without its sign, one of 0 becomes MIN_SIZE; a geometry with all sizes 0
    is left out.
    """
    if not geometry.size or min(geometry.size) > 0:
        return geometry
    message = f"{label} {geometry.kind} size is {geometry.size}, must be greater than 0"
    if not any(geometry.size):
        model.warn(f"{message}; it is left out", "shapes have no size and are left out", label)
        return None
    sizes = tuple(abs(value) or MIN_SIZE for value in geometry.size)
    model.warn(f"{message}; it becomes {sizes}", "shapes have a size of 0 or less", label)
    return replace(geometry, size=sizes)


def first_geometry(element: Node, label: str, model: ModelDescription) -> Node | None:
    """The element in the <geometry> of a visual or collision, or None with a warning."""
    geometry = element.find("geometry")
    if geometry is None or not len(geometry):
        model.warn(
            f"{label} has no geometry; it is left out",
            "shapes have no geometry and are left out",
            label,
        )
        return None
    return geometry[0]


def mesh_geometry(
    uri: str, scale: Vec3, label: str, resolve: Resolve, model: ModelDescription
) -> Geometry | None:
    """Mesh of a URI, or None with a warning that names the file when it cannot be used."""
    try:
        path = resolve(uri)
    except ValueError as error:
        model.warn(f"{label}: mesh '{uri}' is not found ({error}); it is left out", MISSING, uri)
        return None
    if 0.0 in scale:
        model.warn(
            f"{label}: mesh '{uri}' has scale {scale}, must not be 0; it is left out",
            "meshes have scale 0 and are left out",
            uri,
        )
        return None
    if not os.path.isfile(path):
        model.warn(
            f"{label}: mesh file '{path}' (from '{uri}') does not exist; it is left out",
            MISSING,
            uri,
        )
        return None
    if os.path.splitext(path)[1].lower() not in MESH_TYPES:
        model.warn(
            f"{label}: mesh '{path}' is not one of {', '.join(MESH_TYPES)}; it is left out",
            f"meshes are not one of {', '.join(MESH_TYPES)} and are left out",
            uri,
        )
        return None
    return Geometry("mesh", path=path, scale=scale)


PLANE_SIZE = (100.0, 100.0)  # [m] of a visual plane that gives none
PLANE_THICKNESS = 0.002  # [m]
GREY = (0.7, 0.7, 0.7, 1.0)
_ONE = (1.0, 1.0, 1.0)


def parse_shape(
    element: Node, tag: str, link: str, pose: Pose, model: ModelDescription, resolve: Resolve
) -> Shape | None:
    """Shape of a <visual> or <collision>, or None with a warning.

    Args:
        pose: in the link's frame.
    """
    name = element.get("name") or tag
    label = f"{tag} '{name}' of link '{link}' of '{model.name}'"
    geometry = first_geometry(element, label, model)
    if geometry is None:
        return None
    parsed = _geometry(geometry, label, model, resolve, tag)
    parsed = parsed and usable_size(parsed, label, model)
    if parsed is None:
        return None
    offset = _plane_rotation(geometry, label)
    if parsed.kind == "heightmap":
        offset = Pose(child_floats(geometry, "pos", 3, f"{label} heightmap", (0.0, 0.0, 0.0)))
    shape = Shape(parsed, pose * offset, name=name, link=link)
    if tag == "collision":
        return shape
    if geometry.tag == "plane":  # a thin box below the surface
        shape = replace(shape, pose=shape.pose * Pose((0.0, 0.0, -PLANE_THICKNESS / 2)))
    return _with_material(element, shape, label, model, resolve)


def _plane_rotation(shape: Node, label: str) -> Pose:
    """Shortest rotation from +z to the normal of a plane."""
    if shape.tag != "plane":
        return Pose()
    x, y, z = child_floats(shape, "normal", 3, f"{label} plane", (0.0, 0.0, 1.0))
    length = (x * x + y * y + z * z) ** 0.5
    if length < 1e-9 or (x == 0.0 and y == 0.0 and z > 0.0):
        return Pose()
    x, y, z = x / length, y / length, z / length
    if z < -0.999999:
        return Pose(orientation=(1.0, 0.0, 0.0, 0.0))
    return Pose(orientation=(-y, x, 0.0, 1.0 + z)).normalised()


def _geometry(
    shape: Node, label: str, model: ModelDescription, resolve: Resolve, tag: str
) -> Geometry | None:
    if shape.tag == "plane":
        if tag == "collision":
            return Geometry("plane")
        size = child_floats(shape, "size", 2, f"{label} plane", PLANE_SIZE)
        return Geometry("box", size + (PLANE_THICKNESS,))
    if shape.tag == "box":
        return Geometry("box", child_floats(shape, "size", 3, f"{label} box", _ONE))
    if shape.tag == "cylinder":
        return Geometry(
            "cylinder",
            (child_number(shape, "radius", label, 1.0), child_number(shape, "length", label, 1.0)),
        )
    if shape.tag == "sphere":
        return Geometry("sphere", (child_number(shape, "radius", label, 1.0),))
    if shape.tag == "mesh":
        scale = child_floats(shape, "scale", 3, f"{label} mesh", _ONE)
        uri = shape.document.resolve_relative(child_text(shape, "uri", ""))
        geometry = mesh_geometry(uri, scale, label, resolve, model)
        submesh = child_text(shape, "submesh/name")
        if geometry is not None and submesh:
            geometry = replace(
                geometry,
                submesh=submesh,
                centered=is_true(child_text(shape, "submesh/center", "false")),
            )
        return geometry
    if shape.tag in ("heightmap", "polyline"):
        return (_heightmap if shape.tag == "heightmap" else _polyline)(shape, label, model, resolve)
    if shape.tag != "empty":
        model.warn(
            f"{label} has geometry <{shape.tag}>, known are plane, box, cylinder, sphere, "
            "mesh, heightmap, polyline; it is left out",
            "shapes have a geometry that is unknown here and are left out",
            f"{label} <{shape.tag}>",
        )
    return None


def _heightmap(
    shape: Node, label: str, model: ModelDescription, resolve: Resolve
) -> Geometry | None:
    uri = child_text(shape, "uri", "")
    size = child_floats(shape, "size", 3, f"{label} heightmap", _ONE)
    try:
        path = resolve(shape.document.resolve_relative(uri))
        exists = os.path.isfile(path)
    except ValueError:
        exists = False
    if not exists:
        model.warn(
            f"{label}: heightmap '{uri}' is not found; it is left out",
            "heightmaps are missing and left out",
            uri,
        )
        return None
    return Geometry("heightmap", size, path=path)


def _polyline(shape: Node, label: str, model: ModelDescription, _: Resolve) -> Geometry | None:
    corners = (
        floats(point.text or "", 2, f"{label} polyline point") for point in shape.findall("point")
    )
    points = tuple((x, y) for x, y in corners)
    return Geometry(
        "polyline", (child_number(shape, "height", f"{label} polyline", 1.0),), points=points
    )


def _with_material(
    element: Node, shape: Shape, label: str, model: ModelDescription, resolve: Resolve
) -> Shape:
    material = element.find("material")
    color, texture = None, ""
    if material is not None:
        text = child_text(material, "diffuse") or child_text(material, "ambient")
        color = rgba_of(material, text, f"{label} material") if text else None
        script = material.find("script")
        scripted = script_material(script, resolve, label, model) if script is not None else None
        if scripted is not None:
            color, texture = scripted.color or color, scripted.texture
    if color is None and not texture and shape.geometry.kind != "mesh":
        color = GREY
    transparency = min(1.0, max(0.0, child_number(element, "transparency", label, 0.0)))
    if transparency and color is not None:
        color = color[:3] + (color[3] * (1.0 - transparency),)
    if transparency >= 1.0:
        color = (0.0, 0.0, 0.0, 0.0)
    finish = _finish(element, material, 1.0 - transparency if color is None else 1.0, label)
    return replace(shape, color=color, texture=texture, painted=color is not None, finish=finish)


def _finish(element: Node, material: Node | None, opacity: float, label: str) -> Finish:
    """Finish of a <visual>: its <material> except color and texture."""
    casts = child_flag(element, "cast_shadows", label, True)
    if material is None:
        return Finish(opacity=opacity, cast_shadows=casts)

    has_script = material.find("script") is not None
    return Finish(
        None
        if has_script or not child_text(material, "diffuse")
        else _material_rgb(material, "ambient", label, None),
        _material_rgb(material, "specular", label, None),
        _material_rgb(material, "emissive", label, (0.0, 0.0, 0.0)),
        child_number(material, "shininess", label, 0.0) or Finish.shininess,
        opacity,
        casts,
        child_flag(material, "lighting", label, True),
    )


def _material_rgb(material: Node, tag: str, label: str, default: D) -> RGB | D:
    """RGB of a child of a <material>."""
    text = child_text(material, tag)
    color = rgba_of(material, text, f"{label} material") if text else None
    return default if color is None else color[:3]
