"""Shapes of URDF and SDF: geometry."""

from __future__ import annotations

import os
from dataclasses import replace

from bullet_sim.description.model import (
    Geometry,
    Layer,
    ModelDescription,
    Shape,
    TextureMapping,
)
from bullet_sim.errors import ModelError
from bullet_sim.formats.materials import (
    Material,
    Resolve,
    script_material,
    standard,
    with_material,
)
from bullet_sim.meshes import elevation
from bullet_sim.pose import Pose, Vec3
from bullet_sim.xml_reader import (
    Node,
    child_floats,
    child_number,
    child_text,
    child_whole,
    floats,
    is_true,
)

MESH_TYPES = (".obj", ".stl", ".dae")
MIN_SIZE = 1e-3  # [m] replaces a size of 0
NO_GDAL = "elevation data, which GDAL reads (apt-get install python3-gdal)"
MISSING = "meshes are missing and left out"


def usable_size(
    geometry: Geometry, label: str, model: ModelDescription, touches: bool
) -> Geometry | None:
    """The geometry with sizes above 0, or None with a warning; planes and meshes have no size.

    A negative size counts without its sign, one of 0 becomes MIN_SIZE; a geometry with all sizes 0
    is left out, and one that touches where any of them is.

    Args:
        touches: it is a collision of a model that moves, which falls through everything in Gazebo
            where it has a size of 0; one of a static model is thin there.
    """
    if not geometry.size or min(geometry.size) > 0:
        return geometry
    message = f"{label} {geometry.kind} size is {geometry.size}, must be greater than 0"
    if not (all if touches else any)(geometry.size):
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


def hollow_collision(uri: str | None, resolve: Resolve) -> Shape | None:
    """What Gazebo has of a collision whose mesh leads to no file: one without a shape.

    Args:
        uri: of the mesh; None: it has none.
    """
    missing = uri is not None and not existing_file(uri, resolve)
    return Shape(Geometry("empty")) if missing else None


def existing_file(uri: str, resolve: Resolve) -> str:
    """Path of a URI's file, or "" where there is none."""
    try:
        path = resolve(uri)
    except ValueError:
        return ""
    return path if os.path.isfile(path) else ""


PLANE_SIZE = (100.0, 100.0)  # [m] of a visual plane that gives none
PLANE_THICKNESS = 0.002  # [m]
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
    if geometry.tag == "polyline":
        parsed: Geometry | None = _polylines(element, label)
    else:
        parsed = _geometry(geometry, label, model, resolve, tag)
    parsed = parsed and usable_size(parsed, label, model, tag == "collision" and not model.static)
    if parsed is None:
        return None
    offset = _plane_rotation(geometry, label)
    if parsed.kind == "heightmap":
        x, y, z = child_floats(geometry, "pos", 3, f"{label} heightmap", (0.0, 0.0, 0.0))
        # ODEHeightmapShape takes the height alone.
        offset = Pose((0.0, 0.0, z) if tag == "collision" else (x, y, z))
    shape = Shape(parsed, pose * offset, name=name, link=link)
    if tag == "collision":
        return shape
    if geometry.tag == "plane":  # the upper side of a thin box
        shape = replace(shape, pose=shape.pose * Pose((0.0, 0.0, -PLANE_THICKNESS / 2)))
    shape = with_material(element, shape, label, model, resolve)
    if parsed.kind == "heightmap":
        shape = _with_textures(geometry, shape, label, model, resolve)
    return shape


MAX_TEXTURES = 4  # of a heightmap
GLOSS = 16.0  # exponent of a heightmap's highlights, as OGRE has it


def _with_textures(
    element: Node, shape: Shape, label: str, model: ModelDescription, resolve: Resolve
) -> Shape:
    """A heightmap with its <texture>s, one above the other as its <blend>s say.

    Without any, or where one is missing, it keeps its material; in Gazebo the first is a pattern
    that says so.
    """
    label = f"{label} heightmap"
    layers: list[Layer] = []
    path = shape.geometry.path
    base = elevation.read(path).low if elevation.is_elevation(path) else 0.0
    for number, texture in enumerate(element.findall("texture")[:MAX_TEXTURES]):
        uri = child_text(texture, "diffuse", "")
        path = existing_file(texture.document.resolve_relative(uri), resolve)
        if not path:
            model.warn(
                f"{label}: texture '{uri}' is not found; it has one color",
                "textures of heightmaps are missing; these have one color",
                f"'{uri}'",
            )
            return shape
        tile = max(child_number(texture, "size", label, 10.0), 1e-3)
        across, along = (side / tile for side in shape.geometry.size[:2])
        mapping = TextureMapping((across, 0.0, 0.0, 0.0, along, -along))
        blends = element.findall("blend")
        if number > len(blends):  # which is never seen in Gazebo
            break
        blend = (0.0, 1.0)
        if number:
            blend = (
                base + child_number(blends[number - 1], "min_height", label, 0.0),
                child_number(blends[number - 1], "fade_dist", label, 0.0),
            )
        layers.append(Layer(path, "height", mapping, blend))
    if not layers:
        return shape
    white = (1.0, 1.0, 1.0)
    finish = replace(
        shape.finish,
        ambient=white,
        specular=white,
        shininess=GLOSS,
        mapping=layers[0].mapping,
        layers=tuple(layers[1:]),
        gloss=True,
    )
    return replace(shape, color=(*white, 1.0), texture=layers[0].path, painted=True, finish=finish)


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
    return Pose(orientation=(-y, x, 0.0, 1.0 + z)).normalized()


def _geometry(
    shape: Node, label: str, model: ModelDescription, resolve: Resolve, tag: str
) -> Geometry | None:
    if shape.tag == "plane":
        if tag == "collision":
            return Geometry("plane")
        size = child_floats(shape, "size", 2, f"{label} plane", PLANE_SIZE)
        return Geometry("box", size + (PLANE_THICKNESS,), flat=True)
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
    if shape.tag == "heightmap":
        return _heightmap(shape, label, model, resolve)
    if shape.tag != "empty":
        model.warn(
            f"{label} has geometry <{shape.tag}>, known are plane, box, cylinder, sphere, "
            "mesh, heightmap, polyline; it is left out",
            "shapes have a geometry that is unknown here and are left out",
            f"{label} <{shape.tag}>",
        )
    return None


def parse_road(
    element: Node, label: str, model: ModelDescription, resolve: Resolve
) -> Shape | None:
    """What is seen of a <road>, or None with a warning; as in Gazebo of its material the script.

    Args:
        model: takes the warnings.
    """
    label = f"{label} road '{element.get('name')}'"
    points = [floats(point.text or "", 3, f"{label} point") for point in element.findall("point")]
    width = child_number(element, "width", label, 1.0)
    if len(points) < 2 or width <= 0.0:
        element.warn(
            f"{label} has {len(points)} points and width {width:g}, must be two or more and above "
            "0; it is left out",
            "roads have no two points or no width and are left out",
            f"'{element.get('name')}'",
        )
        return None
    middle = tuple((x, y, z) for x, y, z in points)
    script = element.find("material/script")
    material = None if script is None else script_material(script, resolve, label, model)
    material = material or standard("Gazebo/Road", resolve) or Material()
    return material.on(Shape(Geometry("road", (width,), points=middle)))


def _heightmap(
    shape: Node, label: str, model: ModelDescription, resolve: Resolve
) -> Geometry | None:
    uri = child_text(shape, "uri", "")
    size: Vec3 = child_floats(shape, "size", 3, f"{label} heightmap", _ONE)
    path = existing_file(shape.document.resolve_relative(uri), resolve)
    if not path:
        model.warn(
            f"{label}: heightmap '{uri}' is not found; it is left out",
            "heightmaps are missing and left out",
            uri,
        )
        return None
    if elevation.is_elevation(path):
        if not elevation.has_reader():
            text = f"{label}: heightmap '{uri}' is {NO_GDAL}; it is left out"
            model.warn(text, f"heightmaps are {NO_GDAL}, and left out", uri)
            return None
        try:
            size = elevation.size(path, None if shape.find("size") is None else size)
        except ModelError as error:
            text = f"{label} is left out: {error}"
            model.warn(text, "heightmaps cannot be used and are left out", uri)
            return None
    sampling = child_whole(shape, "sampling", f"{label} heightmap", 2)
    return Geometry("heightmap", size, path=path, sampling=sampling)


def _polylines(element: Node, label: str) -> Geometry:
    """All <polyline>s of a shape; the first one has the height, as in Gazebo."""
    shapes = element.findall("geometry/polyline")
    label = f"{label} polyline"
    outlines = []
    for shape in shapes:
        corners = (
            floats(point.text or "", 2, f"{label} point") for point in shape.findall("point")
        )
        outlines.append(tuple((x, y) for x, y in corners))
    height = child_number(shapes[0], "height", label, 1.0)
    return Geometry("polyline", (height,), outlines=tuple(outlines))
